"""Replies to bytes and back (SPEC, section M)."""

from collections.abc import Iterable
from typing import Any

from comotion_protocol import limits
from comotion_protocol import messages as m
from comotion_protocol.blocks import Frame
from comotion_protocol.header import pack
from comotion_protocol.message_parts import (
    Arrays,
    block,
    by_region,
    frame,
    given,
    motion_arrays,
    read,
    rows_of,
    scale_block,
)
from comotion_protocol.records import (
    read_blocked,
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
    read_wear,
    record,
)


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
        case m.LookReply():
            return _look_frame(reply)


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
    return frame(values, _surfaces(reply) | motion_arrays(reply))


def _surfaces(reply: m.OpenReply | m.LookReply) -> dict[str, Any]:
    """Vertices and triangles of all regions."""
    arrays: dict[str, Any] = {}
    for region in reply.regions:
        arrays[f"{region.name}/vertices"] = reply.vertices[region.name]
        arrays[f"{region.name}/triangles"] = reply.triangles[region.name]
    return arrays


def decode_open_reply(header: bytes, bulk: bytes) -> m.OpenReply:
    """The open reply in a header and a bulk."""
    fields, arrays = read(header, bulk, limits.REPLY_HEADER_BYTES)
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
        **_read_surfaces(regions, arrays),
        velocities=by_region(arrays, "velocities"),
        poses=rows_of(arrays, "poses", 7),
        twists=rows_of(arrays, "twists", 6),
    )


def _read_surfaces(regions: Iterable[m.Region], arrays: Arrays) -> dict[str, Any]:
    """Vertices and triangles of all regions, each with its rows."""
    return {
        "vertices": {each.name: block(arrays, f"{each.name}/vertices", each.vertex_count, 3) for each in regions},
        "triangles": {
            each.name: block(arrays, f"{each.name}/triangles", each.triangle_count, 3, "<u4") for each in regions
        },
    }


def _step_reply_frame(reply: m.StepReply) -> Frame:
    values = given(
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
        blocked=None if reply.blocked is None else [record(block) for block in reply.blocked],
        impacts=None if reply.impacts is None else [record(impact) for impact in reply.impacts[: limits.IMPACTS]],
        contacts=None if reply.contacts is None else [record(contact) for contact in reply.contacts],
        wear=None if reply.wear is None else [record(wear) for wear in reply.wear],
    )
    vertices = {f"{name}/vertices": array for name, array in reply.vertices.items()}
    return frame(values, vertices | motion_arrays(reply))


def decode_step_reply(header: bytes, bulk: bytes) -> m.StepReply:
    """The step reply in a header and a bulk."""
    fields, arrays = read(header, bulk, limits.REPLY_HEADER_BYTES)
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
        blocked=tuple(map(read_blocked, fields.maps("blocked"))) if fields.has("blocked") else None,
        impacts=tuple(map(read_impact, fields.maps("impacts"))) if fields.has("impacts") else None,
        contacts=tuple(map(read_contact, fields.maps("contacts"))) if fields.has("contacts") else None,
        wear=tuple(map(read_wear, fields.maps("wear"))) if fields.has("wear") else None,
        vertices=by_region(arrays, "vertices"),
        velocities=by_region(arrays, "velocities"),
        poses=rows_of(arrays, "poses", 7),
        twists=rows_of(arrays, "twists", 6),
    )


def decode_close_reply(header: bytes, bulk: bytes) -> m.CloseReply:
    """The close reply in a header and a bulk."""
    fields, _ = read(header, bulk, limits.REPLY_HEADER_BYTES)
    return m.CloseReply(steps=fields.count("steps"), time=fields.finite("time"))


def _look_frame(reply: m.LookReply) -> Frame:
    values = {
        "protocol": list(reply.protocol),
        "server": record(reply.server),
        "run": reply.run,
        "step": reply.step,
        "attempt": reply.attempt,
        "time": reply.time,
        "regions": [record(region) for region in reply.regions],
        "digest": reply.digest,
    }
    return frame(values, _surfaces(reply) | {"poses": reply.poses} | scale_block(reply.scales))


def decode_look_reply(header: bytes, bulk: bytes) -> m.LookReply:
    """The look reply in a header and a bulk."""
    fields, arrays = read(header, bulk, limits.REPLY_HEADER_BYTES)
    regions = tuple(read_region(region) for region in fields.maps("regions"))
    count = sum(len(region.bodies) for region in regions)
    return m.LookReply(
        protocol=fields.version("protocol"),
        server=read_server(fields.map("server")),
        run=fields.text("run"),
        step=fields.count("step"),
        attempt=fields.count("attempt"),
        time=fields.finite("time"),
        regions=regions,
        digest=fields.text("digest"),
        **_read_surfaces(regions, arrays),
        poses=block(arrays, "poses", count, 7),
        scales=block(arrays, "scales", count, 1) if "scales" in arrays else None,
    )


def _status_header(reply: m.StatusReply) -> dict[str, Any]:
    return given(
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
    fields, _ = read(header, bulk, limits.REPLY_HEADER_BYTES)
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
