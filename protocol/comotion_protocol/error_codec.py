"""Errors to bytes and back (SPEC, section E)."""

from comotion_protocol import limits
from comotion_protocol.errors import SERVER_FAULTS, LocalProtocolError, ProtocolError, RemoteProtocolError
from comotion_protocol.fields import Fields, refusal
from comotion_protocol.header import pack, unpack


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
