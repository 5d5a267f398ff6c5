"""Arrays on the wire: a header and, back to back, the raw bytes of its blocks (SPEC B1 to B7)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from comotion_protocol import limits
from comotion_protocol.errors import RemoteProtocolError

Description: TypeAlias = tuple[str, np.dtype[Any], tuple[int, int]]

DTYPES: dict[str, np.dtype[Any]] = {"<f8": np.dtype("<f8"), "<u4": np.dtype("<u4")}
"""The element types of blocks (SPEC B4)."""


@dataclass(frozen=True, eq=False)
class Frame:
    """An encoded message: the header's bytes and the arrays of the bulk, each contiguous and not yet copied."""

    header: bytes
    arrays: tuple[np.ndarray[Any, Any], ...] = ()

    @property
    def size(self) -> int:
        """Bytes of the bulk."""
        return sum(array.nbytes for array in self.arrays)

    def bulk(self) -> bytes:
        """The bulk in one piece: the only copy on the sender's side."""
        return b"".join(array.reshape(-1).view(np.uint8).data for array in self.arrays)


def describe(name: str, array: np.ndarray[Any, Any]) -> dict[str, Any]:
    """The header's entry for one block."""
    return {"name": name, "dtype": array.dtype.str, "shape": list(array.shape)}


def _refuse(code: str, rule: str, message: str, **detail: object) -> RemoteProtocolError:
    return RemoteProtocolError(code, rule, message, detail)


def split(blocks: Any, bulk: bytes, largest: int = limits.BULK_BYTES) -> dict[str, np.ndarray[Any, Any]]:
    """The blocks of a bulk by name, as read-only views into it. Raises RemoteProtocolError."""
    if len(bulk) > largest:
        raise _refuse("too_large", "B10", f"bulk of {len(bulk)} bytes: at most {largest}", got=len(bulk), limit=largest)
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    start = 0
    for name, dtype, shape in _descriptions(blocks):
        if name in arrays:
            raise _refuse("malformed", "B6", f"block {name!r} comes twice", block=name)
        count = shape[0] * shape[1]
        if start + count * dtype.itemsize > len(bulk):
            raise _refuse("malformed", "B3", f"block {name!r} of shape {shape} reaches beyond the bulk", block=name)
        arrays[name] = np.frombuffer(bulk, dtype, count, start).reshape(shape)
        start += count * dtype.itemsize
    if start != len(bulk):
        raise _refuse(
            "malformed", "B3", f"blocks take {start} bytes, the bulk has {len(bulk)}", blocks=start, bulk=len(bulk)
        )
    return arrays


def _descriptions(blocks: Any) -> Sequence[Description]:
    """Name, element type and shape of every block, checked (SPEC B2, B4, B5)."""
    if not isinstance(blocks, list):
        raise _refuse("wrong_type", "B2", f"blocks: expected a list, got {type(blocks).__name__}")
    if len(blocks) > limits.BLOCKS:
        raise _refuse("too_large", "B10", f"{len(blocks)} blocks: at most {limits.BLOCKS}", got=len(blocks))
    return [_description(block) for block in blocks]


def _description(block: Any) -> Description:
    if not isinstance(block, dict):
        raise _refuse("wrong_type", "B2", f"block: expected a map, got {type(block).__name__}")
    name, dtype, shape = block.get("name"), block.get("dtype"), block.get("shape")
    if not isinstance(name, str) or not 0 < len(name) <= limits.BLOCK_NAME_LENGTH:
        raise _refuse("wrong_type", "B2", f"block: name must be a string of 1 to {limits.BLOCK_NAME_LENGTH} characters")
    if not isinstance(dtype, str) or dtype not in DTYPES:
        raise _refuse("out_of_range", "B4", f"block {name!r}: dtype must be one of {sorted(DTYPES)}", block=name)
    if not isinstance(shape, list) or len(shape) != 2 or type(shape[0]) is not int or type(shape[1]) is not int:
        raise _refuse("wrong_type", "B5", f"block {name!r}: shape must be two integers", block=name)
    if not (0 <= shape[0] <= limits.BULK_BYTES and 0 <= shape[1] <= limits.BULK_BYTES):
        raise _refuse("out_of_range", "B5", f"block {name!r}: shape {shape} is negative or too large", block=name)
    return name, DTYPES[dtype], (shape[0], shape[1])
