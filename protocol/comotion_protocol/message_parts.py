"""What requests and replies are made of: header and blocks, read with distrust (SPEC, section B)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from comotion_protocol import messages as m
from comotion_protocol.blocks import Frame, describe, split
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.fields import Fields, refusal
from comotion_protocol.header import pack, unpack

Arrays = Mapping[str, np.ndarray[Any, Any]]

BULK_KEYS = frozenset({"forces", "wrenches", "vertices", "velocities", "triangles", "poses", "twists", "scales"})
"""Keys that never hold a list: arrays travel as blocks (SPEC B7)."""


def given(**values: Any) -> dict[str, Any]:
    """Without what is None: an optional key that does not apply is left out (SPEC B8)."""
    return {key: value for key, value in values.items() if value is not None}


def frame(values: dict[str, Any], arrays: Mapping[str, np.ndarray[Any, Any]]) -> Frame:
    """A message of these header values and blocks."""
    if arrays:
        values["blocks"] = [describe(name, array) for name, array in arrays.items()]
    return Frame(pack(values), tuple(arrays.values()))


def read(header: bytes, bulk: bytes, largest: int) -> tuple[Fields, Arrays]:
    """The header's map and the bulk's blocks."""
    values = unpack(header, largest)
    if not BULK_KEYS.isdisjoint(values):
        key = next(key for key in values if key in BULK_KEYS)
        raise RemoteProtocolError("wrong_type", "B7", f"{key}: arrays travel as blocks of the bulk", {"field": key})
    return Fields(values, ""), split(values.get("blocks", []), bulk)


def motion_arrays(reply: m.OpenReply | m.StepReply) -> dict[str, Any]:
    """The blocks that open and step replies share, but for the vertices."""
    arrays: dict[str, Any] = {f"{name}/velocities": array for name, array in reply.velocities.items()}
    return arrays | {
        name: array for name, array in (("poses", reply.poses), ("twists", reply.twists)) if array is not None
    }


def scale_block(scales: np.ndarray[Any, Any] | None) -> dict[str, Any]:
    """The block of scales, if there is one (SPEC W7)."""
    return {} if scales is None else {"scales": scales}


def by_region(arrays: Arrays, kind: str) -> dict[str, Any]:
    """The blocks `<region>/<kind>` by region, each with three columns."""
    names = [name for name in arrays if name.endswith(f"/{kind}")]
    return {name.rpartition("/")[0]: rows_of(arrays, name, 3) for name in names}


def rows_of(arrays: Arrays, name: str, columns: int, dtype: str = "<f8") -> Any:
    """A block with this many columns, or None if it did not come."""
    array = arrays.get(name)
    if array is not None and (array.shape[1] != columns or array.dtype.str != dtype):
        raise refusal("wrong_shape", "B5", f"block {name!r}", f"{dtype} in {columns} columns", array.shape)
    return array


def block(arrays: Arrays, name: str, rows: int, columns: int, dtype: str = "<f8") -> Any:
    """A block that must be there, with this shape."""
    array = rows_of(arrays, name, columns, dtype)
    if array is None:
        raise RemoteProtocolError("missing", "B8", f"block {name!r} is missing", {"block": name})
    if array.shape[0] != rows:
        raise refusal("wrong_shape", "B5", f"block {name!r}", f"{rows} rows", array.shape)
    return array
