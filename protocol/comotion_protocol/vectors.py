"""Golden bytes of every message and every error, for tests in any language.

`python -m comotion_protocol.vectors [FOLDER]` writes five files of cases: `requests.json`, `replies.json` and
`news.json` hold header and bulk as hexadecimal and what they mean, `errors.json` the payloads of error replies,
`refused.json` requests that must be refused, and how. Floats in the meaning are JSON numbers that read back bit for
bit; arrays are `{dtype, shape, values}`.
"""

import json
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from comotion_protocol import codec
from comotion_protocol import messages as m
from comotion_protocol.errors import CODES, RemoteProtocolError
from comotion_protocol.header import pack

FOLDER = Path(__file__).parent.parent / "vectors"
"""Where the vectors are in the repository."""

VERTICES = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype="<u4")
FORCES = np.array([[1.5, 0.0, -2.25], [0.1, 0.2, 0.3], [1e-300, -1e300, 0.0], [-0.0, 5e-324, 7.0]])
CLIENT = m.ClientInfo(name="solver", version="2.1", id="c0ffee")
SERVER = m.ServerInfo(name="comotion", version="0.1.0", instance="5eed5eed5eed5eed")
LEASE = "00112233445566778899aabbccddeeff"
SUMS = m.Sums(force=(1.6, 0.2, 5.05), moment=(0.25, -0.5, 0.0))


def requests() -> dict[str, tuple[str, m.Request]]:
    """Name of the case: message and request."""
    return {
        "open, all said": (
            "open",
            m.OpenRequest(
                client=CLIENT,
                protocol=(1, 0),
                wants=m.Wants(poses=True, impacts=True, sample="midpoint", indexing="facets"),
                dt=0.005,
                digest="d1" * 32,
            ),
        ),
        "open, least said": ("open", m.OpenRequest(client=m.ClientInfo(name="c", version="1"), protocol=(1, 7))),
        "step with forces": (
            "step",
            m.StepRequest(
                lease=LEASE,
                step=1,
                attempt=0,
                dt=0.005,
                dt_next=0.01,
                sums=SUMS,
                forces={"ice": FORCES, "hull": -FORCES},
            ),
        ),
        "step with wrenches": (
            "step",
            m.StepRequest(lease=LEASE, step=2, attempt=3, dt=1e-12, wrenches=np.arange(12.0).reshape(2, 6)),
        ),
        "step without load": ("step", m.StepRequest(lease=LEASE, step=2**53 - 1, attempt=2**32, dt=0.1)),
        "close": ("close", m.CloseRequest(lease=LEASE, step=300)),
        "status": ("status", m.StatusRequest()),
        "look": ("look", m.LookRequest()),
    }


def replies() -> dict[str, tuple[str, m.Reply]]:
    """Name of the case: message and reply."""
    return {
        "open": ("open", _open_reply()),
        "step, all wanted": ("step", _step_reply()),
        "step, nothing wanted": (
            "step",
            m.StepReply(
                step=2,
                attempt=0,
                time=0.02,
                dt=0.005,
                sample_time=0.02,
                status="blocked",
                sums=m.Sums(force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)),
                budget=m.Budget(limit=10000, used=10000, exhausted=True),
                books=_books(0),
            ),
        ),
        "step, blocked": ("step", _blocked_reply()),
        "close": ("close", m.CloseReply(steps=300, time=1.5)),
        "status, held": ("status", _status()),
        "look": ("look", _look_reply()),
        "status, free": (
            "status",
            m.StatusReply(
                protocol=(1, 0),
                server=SERVER,
                run="channel",
                phase="free",
                phase_seconds=0.0,
                step=0,
                attempt=0,
                time=0.0,
                busy=0.0,
            ),
        ),
    }


def news() -> dict[str, tuple[str, m.News]]:
    """Name of the case: kind of news and news."""
    blocked = _blocked_reply()
    return {
        "state": (
            "state",
            m.StateNews(
                step=7,
                attempt=1,
                time=0.035,
                poses=np.arange(14.0).reshape(2, 7),
                twists=np.arange(12.0).reshape(2, 6),
            ),
        ),
        "state, scaled": (
            "state",
            m.StateNews(
                step=8,
                attempt=0,
                time=0.04,
                poses=np.arange(14.0).reshape(2, 7),
                twists=np.arange(12.0).reshape(2, 6),
                scales=np.array([[1.0], [0.75]]),
            ),
        ),
        "events": (
            "events",
            m.EventsNews(
                step=100,
                attempt=0,
                time=0.5,
                dt=0.005,
                status="blocked",
                budget=blocked.budget,
                books=blocked.books,
                blocked=blocked.blocked,
                impacts=blocked.impacts or (),
                contacts=blocked.contacts or (),
            ),
        ),
        "progress": ("progress", _status()),
    }


def _status() -> m.StatusReply:
    return m.StatusReply(
        protocol=(1, 0),
        server=SERVER,
        run="channel",
        phase="computing",
        phase_seconds=12.5,
        step=7,
        attempt=1,
        time=0.035,
        busy=99.5,
        client=CLIENT,
        held_seconds=120.25,
    )


def _look_reply() -> m.LookReply:
    opened = _open_reply()
    return m.LookReply(
        protocol=(1, 0),
        server=SERVER,
        run="channel",
        step=7,
        attempt=1,
        time=0.035,
        regions=opened.regions,
        digest=opened.digest,
        vertices=opened.vertices,
        triangles=opened.triangles,
        poses=np.arange(14.0).reshape(2, 7),
    )


def _books(impacts: int) -> m.Books:
    return m.Books(momentum=1e-16, angular_momentum=0.0, energy=2e-15, overlaps=0, overlap_max=0.0, impacts=impacts)


def _open_reply() -> m.OpenReply:
    body = m.RegionBody(name="floe-1", first_vertex=0, vertex_count=4)
    bank = m.RegionBody(name="bank", first_vertex=0, vertex_count=4)
    return m.OpenReply(
        protocol=(1, 0),
        server=SERVER,
        run="channel",
        lease=LEASE,
        step=1,
        time=0.0,
        sample_time=0.0025,
        units=m.UNITS,
        regions=(
            m.Region(name="bank", vertex_count=4, triangle_count=4, moves=False, bodies=(bank,)),
            m.Region(name="ice", vertex_count=4, triangle_count=4, moves=True, bodies=(body,)),
        ),
        digest="d1" * 32,
        plan=(m.PlanLine(stage="collisions", kept=True, reason="1 pair may collide"),),
        limits=m.Limits(header_bytes=1 << 20, bulk_bytes=1 << 29, blocks=4096, idle_time=600.0),
        vertices={"bank": VERTICES, "ice": VERTICES + 2.0},
        triangles={"bank": TRIANGLES, "ice": TRIANGLES},
        poses=np.arange(14.0).reshape(2, 7),
    )


def _step_reply() -> m.StepReply:
    impact = m.Impact(
        time=0.004,
        body_a="bank",
        body_b="floe-1",
        point=(1.0, 2.0, 3.0),
        normal=(0.0, 0.0, 1.0),
        impulse=0.5,
        approach_speed=0.25,
        restitution=0.3,
        law="ordinary",
    )
    return m.StepReply(
        step=1,
        attempt=2,
        time=0.005,
        dt=0.005,
        sample_time=0.0075,
        status="ok",
        sums=SUMS,
        dt_advice=0.0025,
        budget=m.Budget(limit=10000, used=1, exhausted=False),
        books=_books(1),
        impacts=(impact,),
        contacts=(m.Contact(body_a="bank", body_b="floe-1", impulse=(0.0, 0.0, 0.5), count=1),),
        wear=(
            m.Wear(
                time=0.00125,
                body="floe-1",
                scale=0.875,
                depth=0.0625,
                mass=0.5,
                momentum=(0.25, 0.0, 0.0),
                angular_momentum=(0.0, 0.0, -0.125),
                energy=0.0625,
            ),
        ),
        vertices={"ice": VERTICES + 3.0},
        velocities={"ice": -VERTICES},
        poses=np.arange(14.0).reshape(2, 7),
        twists=np.arange(12.0).reshape(2, 6),
    )


def _blocked_reply() -> m.StepReply:
    hull_and_floe, floe_and_bank = m.Pair(body_a="floe-1", body_b="hull"), m.Pair(body_a="bank", body_b="floe-1")
    impact = m.Impact(
        time=0.5,
        body_a="floe-1",
        body_b="hull",
        point=(0.0, 1.0, 0.0),
        normal=(0.0, 1.0, 0.0),
        impulse=2.0,
        approach_speed=0.5,
        restitution=0.0,
        law="together",
        friction=(0.25, 0.0, -0.25),
    )
    return m.StepReply(
        step=100,
        attempt=0,
        time=0.5,
        dt=0.005,
        sample_time=0.5,
        status="blocked",
        sums=SUMS,
        budget=m.Budget(limit=10000, used=1, exhausted=False, capped=1, fallback=0.125),
        books=m.Books(
            momentum=0.0,
            angular_momentum=0.0,
            energy=0.0,
            overlaps=0,
            overlap_max=0.0,
            impacts=1,
            rest_energy=1e-9,
            shift_work=-1e-12,
        ),
        blocked=(m.Blocked(time=0.499, bodies=("hull",), contacts=(floe_and_bank, hull_and_floe)),),
        impacts=(impact,),
        contacts=(m.Contact(body_a="floe-1", body_b="hull", impulse=(0.5, 3.0, 0.0), count=1, held=(0.25, 1.0, 0.25)),),
        vertices={"ice": VERTICES},
    )


def refused() -> dict[str, tuple[str, bytes, bytes, str, str]]:
    """Name of the case: message, header and bulk of a request, and the code and rule of its refusal."""
    step = {"lease": LEASE, "step": 1, "attempt": 0, "dt": 0.1}
    block = {"name": "ice/forces", "dtype": "<f8", "shape": [1, 3]}
    one = bytes(24)

    def with_blocks(*blocks: Any) -> bytes:
        return pack(step | {"blocks": list(blocks)})

    return {
        "no header": ("step", b"", b"", "malformed", "B1"),
        "header cut short": ("step", pack(step)[:-1], b"", "malformed", "B1"),
        "two values": ("step", pack(step) + b"\x00", b"", "malformed", "B1"),
        "a list": ("step", b"\x90", b"", "malformed", "B1"),
        "a number as key": ("step", b"\x81\x01\x01", b"", "malformed", "B1"),
        "a key twice": ("close", b"\x82\xa4step\x01\xa4step\x01", b"", "malformed", "B1"),
        "blocks is no list": ("step", pack(step | {"blocks": 1}), b"", "wrong_type", "B2"),
        "bulk without blocks": ("step", pack(step), one, "malformed", "B3"),
        "bulk too short": ("step", with_blocks(block), one[:-1], "malformed", "B3"),
        "unknown dtype": ("step", with_blocks(block | {"dtype": "<f4"}), one, "out_of_range", "B4"),
        "shape of one number": ("step", with_blocks(block | {"shape": [3]}), one, "wrong_type", "B5"),
        "negative shape": ("step", with_blocks(block | {"shape": [-1, 3]}), one, "out_of_range", "B5"),
        "a block twice": ("step", with_blocks(block, block), one * 2, "malformed", "B6"),
        "forces in the header": ("step", pack(step | {"forces": [0.0, 0.0, 0.0]}), b"", "wrong_type", "B7"),
        "no lease": ("close", pack({"step": 1}), b"", "missing", "B8"),
        "an integer for a float": ("step", pack(step | {"dt": 1}), b"", "wrong_type", "B8"),
        "a boolean for an integer": ("close", pack({"lease": LEASE, "step": True}), b"", "wrong_type", "B8"),
        "a moment that is NaN": (
            "step",
            pack(step | {"sums": {"force": [0.0, 0.0, 0.0], "moment": [0.0, float("nan"), 0.0]}}),
            b"",
            "not_finite",
            "B9",
        ),
        "a lease too long": ("close", pack({"lease": "x" * 129, "step": 1}), b"", "out_of_range", "B10"),
        "an integer too large": ("close", pack({"lease": LEASE, "step": 2**53}), b"", "out_of_range", "B11"),
        "step 0": ("step", pack(step | {"step": 0}), b"", "out_of_range", "B11"),
        "an id with a slash": (
            "open",
            pack({"protocol": [1, 0], "client": {"name": "c", "version": "1", "id": "a/b"}}),
            b"",
            "out_of_range",
            "K2",
        ),
        "another major version": (
            "open",
            pack({"protocol": [2, 0], "client": {"name": "c", "version": "1"}}),
            b"",
            "protocol_version",
            "M2",
        ),
        "resume": (
            "open",
            pack({"protocol": [1, 0], "client": {"name": "c", "version": "1"}, "resume": {"step": 3}}),
            b"",
            "not_supported",
            "M6",
        ),
        "a block nobody knows": ("step", with_blocks(block | {"name": "ice/heat"}), one, "unknown_block", "F1"),
    }


def plain(value: Any) -> Any:
    """A message as JSON can hold it."""
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, np.ndarray):
        return {"dtype": value.dtype.str, "shape": list(value.shape), "values": value.ravel().tolist()}
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    return value


def files() -> dict[str, list[dict[str, Any]]]:
    """All vectors by file."""
    return {
        "requests.json": [
            _golden(name, message, request, codec.encode_request(request))
            for name, (message, request) in requests().items()
        ],
        "replies.json": [
            _golden(name, message, reply, codec.encode_reply(reply)) for name, (message, reply) in replies().items()
        ],
        "news.json": [
            _golden(name, kind, meaning, codec.encode_news(meaning)) for name, (kind, meaning) in news().items()
        ],
        "errors.json": [
            {"payload": codec.encode_error(error).hex()}
            | {"code": error.code, "rule": error.rule, "message": error.message, "detail": error.detail}
            for error in (RemoteProtocolError(code, "E2", text, {"got": 1}) for code, text in CODES.items())
        ],
        "refused.json": [
            {"name": name, "message": message, "header": header.hex(), "bulk": bulk.hex(), "code": code, "rule": rule}
            for name, (message, header, bulk, code, rule) in refused().items()
        ],
    }


def _golden(name: str, message: str, meaning: Any, frame: Any) -> dict[str, Any]:
    return {
        "name": name,
        "message": message,
        "header": frame.header.hex(),
        "bulk": bytes(frame.bulk()).hex(),
        "meaning": plain(meaning),
    }


def text(cases: list[dict[str, Any]]) -> str:
    """A file's text: one case per line."""
    return "[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n"


def main(folder: Path) -> None:
    """Write all files."""
    folder.mkdir(exist_ok=True)
    for name, cases in files().items():
        (folder / name).write_text(text(cases))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
