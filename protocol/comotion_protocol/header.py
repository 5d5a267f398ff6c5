"""A header's bytes: one msgpack map with string keys, each once (SPEC B1, B10)."""

from typing import Any

import msgpack

from comotion_protocol import limits
from comotion_protocol.errors import RemoteProtocolError


def pack(values: dict[str, Any]) -> bytes:
    """The bytes of a header: keys in the order given, integers in their shortest form, floats as 64 bits (SPEC B12)."""
    return bytes(msgpack.packb(values))


def unpack(data: bytes, largest: int) -> dict[str, Any]:
    """The map in `data`, or RemoteProtocolError. Never allocates more than a few times `largest` bytes."""
    if len(data) > largest:
        raise RemoteProtocolError(
            "too_large", "B10", f"header of {len(data)} bytes: at most {largest}", {"got": len(data), "limit": largest}
        )
    try:
        values = msgpack.unpackb(
            data,
            object_pairs_hook=_map,
            strict_map_key=True,
            max_str_len=limits.TEXT_BYTES,
            max_bin_len=0,
            max_ext_len=0,
            max_array_len=limits.ITEMS,
            max_map_len=limits.ITEMS,
        )
    except RemoteProtocolError:
        raise
    # Whatever msgpack finds wrong (too short, trailing bytes, bad UTF-8, too deep, over a limit) is the peer's fault.
    except (ValueError, RecursionError, msgpack.exceptions.UnpackException) as error:
        reason = str(error) or type(error).__name__
        raise RemoteProtocolError("malformed", "B1", f"header is not one msgpack map: {reason}") from None
    if not isinstance(values, dict):
        raise RemoteProtocolError("malformed", "B1", f"header is a {type(values).__name__}, not a map")
    return values


def _map(pairs: list[tuple[Any, Any]]) -> dict[str, Any]:
    """A map whose keys are strings, each once (SPEC B1)."""
    values = dict(pairs)
    if len(values) < len(pairs):
        raise RemoteProtocolError("malformed", "B1", "a key comes twice in one map of the header")
    for key in values:
        if type(key) is not str:
            raise RemoteProtocolError("malformed", "B1", f"a key of the header is a {type(key).__name__}, not a string")
    return values
