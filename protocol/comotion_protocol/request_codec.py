"""Requests to bytes and back (SPEC, section M)."""

from typing import Any

import numpy as np

from comotion_protocol import limits
from comotion_protocol import messages as m
from comotion_protocol.blocks import Frame
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.fields import Fields, refusal
from comotion_protocol.header import pack
from comotion_protocol.keys import is_name
from comotion_protocol.message_parts import Arrays, frame, given, read
from comotion_protocol.records import read_client, read_sums, read_wants, record


def encode_request(request: m.Request) -> Frame:
    """The bytes of any request."""
    match request:
        case m.OpenRequest():
            return Frame(pack(_open_header(request)))
        case m.StepRequest():
            return _step_frame(request)
        case m.CloseRequest():
            return Frame(pack({"lease": request.lease, "step": request.step}))
        case m.StatusRequest() | m.LookRequest():
            return Frame(pack({}))


def decode_request(message: str, header: bytes, bulk: bytes) -> m.Request:
    """The request in a header and a bulk that came on the key of `message`."""
    fields, arrays = read(header, bulk, limits.REQUEST_HEADER_BYTES)
    match message:
        case "open":
            return _read_open(fields)
        case "step":
            return _read_step(fields, arrays)
        case "close":
            return m.CloseRequest(lease=fields.text("lease"), step=fields.count("step"))
        case "status":
            return m.StatusRequest()
        case "look":
            return m.LookRequest()
        case _:
            raise RemoteProtocolError("unknown_message", "K1", f"no message is called {message!r}")


def _open_header(request: m.OpenRequest) -> dict[str, Any]:
    return given(
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
    values = given(
        lease=request.lease,
        step=request.step,
        attempt=request.attempt,
        dt=request.dt,
        dt_next=request.dt_next,
        sums=None if request.sums is None else record(request.sums),
    )
    return frame(values, arrays)


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
