"""What the page is told: one binary message is a JSON header and arrays behind it.

    4 bytes   length of the JSON text (little-endian)
    JSON      UTF-8, padded with spaces so that what follows lies at a multiple of 8
    arrays    raw little-endian, each padded to a multiple of 8; the header's `arrays` lists name, dtype, shape, offset

Kinds: `scene` (once, first), `state` (a live one), `film` (all states of a recorded run), `progress`, `gone`.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

ALIGNMENT = 8  # [bytes]: JavaScript's typed arrays begin only at multiples of their element
PREFIX = 4  # [bytes]


def page_message(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None) -> bytes:
    """The bytes of a message."""
    entries, blobs, offset = [], [], 0
    for name, array in (arrays or {}).items():
        data = np.ascontiguousarray(array).tobytes()
        entries.append({"name": name, "dtype": array.dtype.str, "shape": list(array.shape), "offset": offset})
        blobs.append(data + bytes(-len(data) % ALIGNMENT))
        offset += len(blobs[-1])
    text = json.dumps({**header, "arrays": entries}, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-(PREFIX + len(text)) % ALIGNMENT)
    return b"".join([np.uint32(len(text)).astype("<u4").tobytes(), text, *blobs])
