"""Messages to bytes and back (SPEC, sections B and M).

Encoding writes what it is given. Decoding trusts nothing and raises only RemoteProtocolError; what takes knowledge of
the run to judge (regions, shapes, finite forces, the lease) is left to the server.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from comotion_protocol import limits
from comotion_protocol import messages as m
from comotion_protocol.blocks import Frame, describe, split
from comotion_protocol.errors import SERVER_FAULTS, LocalProtocolError, ProtocolError, RemoteProtocolError
from comotion_protocol.fields import Fields, refusal
from comotion_protocol.header import pack, unpack
from comotion_protocol.keys import is_name
from comotion_protocol.records import (
    read_books,
    read_budget,
    read_client,
    read_contact,
    read_impact,
    read_limits,
    read_plan_line,
    read_region,
    read_server,
    read_sums,
    read_wants,
    record,
)

Arrays = Mapping[str, np.ndarray[Any, Any]]

BULK_KEYS = frozenset({"forces", "wrenches", "vertices", "velocities", "triangles", "poses", "twists"})
"""Keys that never hold a list: arrays travel as blocks (SPEC B7)."""


# Requests -----------------------------------------------------------------------------------------------------------


def encode_request(request: m.Request) -> Frame:
    """The bytes of any request."""
    match request:
        case m.OpenRequest():
            return Frame(pack(_open_header(request)))
        case m.StepRequest():
            return _step_frame(request)
        case m.CloseRequest():
            return Frame(pack({"lease": request.lease, "step": request.step}))
        case m.StatusRequest():
            return Frame(pack({}))


def decode_request(message: str, header: bytes, bulk: bytes) -> m.Request:
    """The request in a header and a bulk that came on the key of `message`."""
    fields, arrays = _read(header, bulk, limits.REQUEST_HEADER_BYTES)
    match message:
        case "open":
            return _read_open(fields)
        case "step":
            return _read_step(fields, arrays)
        case "close":
            return m.CloseRequest(lease=fields.text("lease"), step=fields.count("step"))
        case "status":
            return m.StatusRequest()
        case _:
            raise RemoteProtocolError("unknown_message", "K1", f"no message is called {message!r}")


def _open_header(request: m.OpenRequest) -> dict[str, Any]:
    return _given(
        protocol=list(request.protocol),
        client=record(request.client),
        wants=record(request.wants),
        dt=request.dt,
        digest=request.digest,
    )


def _read_open(fields: Fields) -> m.OpenRequest:
    protocol = fields.version("protocol")
    if protocol[0] != limits.PROTOCOL[0]:
        raise RemoteProtocolError(
            "protocol_version",
            "M2",
            f"the client speaks protocol {protocol[0]}.{protocol[1]}, this server {limits.PROTOCOL[0]}",
            {"got": list(protocol), "expected": list(limits.PROTOCOL)},
        )
    if fields.has("resume"):
        raise RemoteProtocolError("not_supported", "M6", "resume: not supported by this server", {"field": "resume"})
    client = read_client(fields.map("client"))
    if client.id is not None and not is_name(client.id):
        raise refusal("out_of_range", "K2", "client.id", "a name of the run's alphabet", client.id)
    return m.OpenRequest(
        client=client,
        protocol=protocol,
        wants=read_wants(fields.map("wants")) if fields.has("wants") else m.Wants(),
        dt=fields.optional(fields.real, "dt"),
        digest=fields.optional(fields.text, "digest"),
    )


def _step_frame(request: m.StepRequest) -> Frame:
    arrays: dict[str, Any] = {f"{region}/forces": array for region, array in request.forces.items()}
    if request.wrenches is not None:
        arrays["wrenches"] = request.wrenches
    values = _given(
        lease=request.lease,
        step=request.step,
        attempt=request.attempt,
        dt=request.dt,
        dt_next=request.dt_next,
        sums=None if request.sums is None else record(request.sums),
    )
    return _frame(values, arrays)


def _read_step(fields: Fields, arrays: Arrays) -> m.StepRequest:
    forces = {}
    for name, array in arrays.items():
        region, _, kind = name.rpartition("/")
        if array.dtype != np.float64 or not (name == "wrenches" or (region and kind == "forces")):
            raise RemoteProtocolError(
                "unknown_block",
                "F1",
                f"block {name!r} of {array.dtype.str}: a step takes <region>/forces or wrenches, both <f8",
                {"block": name},
            )
        if name != "wrenches":
            forces[region] = array
    return m.StepRequest(
        lease=fields.text("lease"),
        step=fields.count("step", 1),
        attempt=fields.count("attempt"),
        dt=fields.real("dt"),
        dt_next=fields.optional(fields.real, "dt_next"),
        sums=read_sums(fields.map("sums")) if fields.has("sums") else None,
        forces=forces,
        wrenches=arrays.get("wrenches"),
    )


# Replies ------------------------------------------------------------------------------------------------------------


def encode_reply(reply: m.Reply) -> Frame:
    """The bytes of any reply."""
    match reply:
        case m.OpenReply():
            return _open_frame(reply)
        case m.StepReply():
            return _step_reply_frame(reply)
        case m.CloseReply():
            return Frame(pack({"steps": reply.steps, "time": reply.time}))
        case m.StatusReply():
            return Frame(pack(_status_header(reply)))


def _open_frame(reply: m.OpenReply) -> Frame:
    values = {
        "protocol": list(reply.protocol),
        "server": record(reply.server),
        "run": reply.run,
        "lease": reply.lease,
        "step": reply.step,
        "time": reply.time,
        "sample_time": reply.sample_time,
        "units": dict(reply.units),
        "regions": [record(region) for region in reply.regions],
        "digest": reply.digest,
        "plan": [record(line) for line in reply.plan],
        "limits": record(reply.limits),
    }
    arrays: dict[str, Any] = {}
    for region in reply.regions:
        arrays[f"{region.name}/vertices"] = reply.vertices[region.name]
        arrays[f"{region.name}/triangles"] = reply.triangles[region.name]
    return _frame(values, arrays | _motion_arrays(reply))


def decode_open_reply(header: bytes, bulk: bytes) -> m.OpenReply:
    """The open reply in a header and a bulk."""
    fields, arrays = _read(header, bulk, limits.REPLY_HEADER_BYTES)
    regions = tuple(read_region(region) for region in fields.maps("regions"))
    return m.OpenReply(
        protocol=fields.version("protocol"),
        server=read_server(fields.map("server")),
        run=fields.text("run"),
        lease=fields.text("lease"),
        step=fields.count("step", 1),
        time=fields.finite("time"),
        sample_time=fields.finite("sample_time"),
        units=fields.texts("units"),
        regions=regions,
        digest=fields.text("digest"),
        plan=tuple(read_plan_line(line) for line in fields.maps("plan")),
        limits=read_limits(fields.map("limits")),
        vertices={region.name: _block(arrays, f"{region.name}/vertices", region.vertex_count, 3) for region in regions},
        triangles={
            region.name: _block(arrays, f"{region.name}/triangles", region.triangle_count, 3, "<u4")
            for region in regions
        },
        velocities=_by_region(arrays, "velocities"),
        poses=_rows(arrays, "poses", 7),
        twists=_rows(arrays, "twists", 6),
    )


def _step_reply_frame(reply: m.StepReply) -> Frame:
    values = _given(
        step=reply.step,
        attempt=reply.attempt,
        time=reply.time,
        dt=reply.dt,
        sample_time=reply.sample_time,
        status=reply.status,
        sums=record(reply.sums),
        dt_advice=reply.dt_advice,
        budget=record(reply.budget),
        books=record(reply.books),
        impacts=None if reply.impacts is None else [record(impact) for impact in reply.impacts[: limits.IMPACTS]],
        contacts=None if reply.contacts is None else [record(contact) for contact in reply.contacts],
    )
    vertices = {f"{name}/vertices": array for name, array in reply.vertices.items()}
    return _frame(values, vertices | _motion_arrays(reply))


def decode_step_reply(header: bytes, bulk: bytes) -> m.StepReply:
    """The step reply in a header and a bulk."""
    fields, arrays = _read(header, bulk, limits.REPLY_HEADER_BYTES)
    return m.StepReply(
        step=fields.count("step", 1),
        attempt=fields.count("attempt"),
        time=fields.finite("time"),
        dt=fields.finite("dt"),
        sample_time=fields.finite("sample_time"),
        status=fields.choice("status", ("ok", "blocked")),
        sums=read_sums(fields.map("sums")),
        dt_advice=fields.optional(fields.finite, "dt_advice"),
        budget=read_budget(fields.map("budget")),
        books=read_books(fields.map("books")),
        impacts=tuple(map(read_impact, fields.maps("impacts"))) if fields.has("impacts") else None,
        contacts=tuple(map(read_contact, fields.maps("contacts"))) if fields.has("contacts") else None,
        vertices=_by_region(arrays, "vertices"),
        velocities=_by_region(arrays, "velocities"),
        poses=_rows(arrays, "poses", 7),
        twists=_rows(arrays, "twists", 6),
    )


def decode_close_reply(header: bytes, bulk: bytes) -> m.CloseReply:
    """The close reply in a header and a bulk."""
    fields, _ = _read(header, bulk, limits.REPLY_HEADER_BYTES)
    return m.CloseReply(steps=fields.count("steps"), time=fields.finite("time"))


def _status_header(reply: m.StatusReply) -> dict[str, Any]:
    return _given(
        protocol=list(reply.protocol),
        server=record(reply.server),
        run=reply.run,
        phase=reply.phase,
        phase_seconds=reply.phase_seconds,
        step=reply.step,
        attempt=reply.attempt,
        time=reply.time,
        busy=reply.busy,
        client=None if reply.client is None else record(reply.client),
        held_seconds=reply.held_seconds,
    )


def decode_status_reply(header: bytes, bulk: bytes) -> m.StatusReply:
    """The status reply in a header and a bulk."""
    fields, _ = _read(header, bulk, limits.REPLY_HEADER_BYTES)
    return m.StatusReply(
        protocol=fields.version("protocol"),
        server=read_server(fields.map("server")),
        run=fields.text("run"),
        phase=fields.choice("phase", ("free", "idle", "computing")),
        phase_seconds=fields.finite("phase_seconds"),
        step=fields.count("step"),
        attempt=fields.count("attempt"),
        time=fields.finite("time"),
        busy=fields.finite("busy"),
        client=read_client(fields.map("client")) if fields.has("client") else None,
        held_seconds=fields.optional(fields.finite, "held_seconds"),
    )


# Errors -------------------------------------------------------------------------------------------------------------


def encode_error(error: ProtocolError) -> bytes:
    """The payload of an error reply (SPEC E1); a text too long for a reader is cut."""
    message = error.message.encode()[: limits.TEXT_BYTES].decode(errors="ignore")
    return pack({"code": error.code, "rule": error.rule, "message": message, "detail": dict(error.detail)})


def decode_error(payload: bytes) -> ProtocolError:
    """The error in an error reply: this side's fault, but for the codes that are the server's own (SPEC E3)."""
    fields = Fields(unpack(payload, limits.REQUEST_HEADER_BYTES), "")
    code = fields.text("code")
    kind = RemoteProtocolError if code in SERVER_FAULTS else LocalProtocolError
    detail = fields.raw("detail") if fields.has("detail") else {}
    if not isinstance(detail, dict):
        raise refusal("wrong_type", "E1", "detail", "a map", detail)
    return kind(code, fields.text("rule"), fields.text("message", limits.TEXT_BYTES), detail)


# Parts --------------------------------------------------------------------------------------------------------------


def _given(**values: Any) -> dict[str, Any]:
    """Without what is None: an optional key that does not apply is left out (SPEC B8)."""
    return {key: value for key, value in values.items() if value is not None}


def _frame(values: dict[str, Any], arrays: Mapping[str, np.ndarray[Any, Any]]) -> Frame:
    if arrays:
        values["blocks"] = [describe(name, array) for name, array in arrays.items()]
    return Frame(pack(values), tuple(arrays.values()))


def _read(header: bytes, bulk: bytes, largest: int) -> tuple[Fields, Arrays]:
    """The header's map and the bulk's blocks."""
    values = unpack(header, largest)
    if not BULK_KEYS.isdisjoint(values):
        key = next(key for key in values if key in BULK_KEYS)
        raise RemoteProtocolError("wrong_type", "B7", f"{key}: arrays travel as blocks of the bulk", {"field": key})
    return Fields(values, ""), split(values.get("blocks", []), bulk)


def _motion_arrays(reply: m.OpenReply | m.StepReply) -> dict[str, Any]:
    """The blocks that open and step replies share, but for the vertices."""
    arrays: dict[str, Any] = {f"{name}/velocities": array for name, array in reply.velocities.items()}
    return arrays | {
        name: array for name, array in (("poses", reply.poses), ("twists", reply.twists)) if array is not None
    }


def _by_region(arrays: Arrays, kind: str) -> dict[str, Any]:
    """The blocks `<region>/<kind>` by region, each with three columns."""
    names = [name for name in arrays if name.endswith(f"/{kind}")]
    return {name.rpartition("/")[0]: _rows(arrays, name, 3) for name in names}


def _rows(arrays: Arrays, name: str, columns: int, dtype: str = "<f8") -> Any:
    """A block with this many columns, or None if it did not come."""
    array = arrays.get(name)
    if array is not None and (array.shape[1] != columns or array.dtype.str != dtype):
        raise refusal("wrong_shape", "B5", f"block {name!r}", f"{dtype} in {columns} columns", array.shape)
    return array


def _block(arrays: Arrays, name: str, rows: int, columns: int, dtype: str = "<f8") -> Any:
    """A block that must be there, with this shape."""
    array = _rows(arrays, name, columns, dtype)
    if array is None:
        raise RemoteProtocolError("missing", "B8", f"block {name!r} is missing", {"block": name})
    if array.shape[0] != rows:
        raise refusal("wrong_shape", "B5", f"block {name!r}", f"{rows} rows", array.shape)
    return array
