"""STL files, binary and text.

A binary file is 80 bytes of anything, the number of facets (uint32), then 50 bytes a facet: normal, three corners
(float32, little-endian), two bytes of anything. Only its length tells it from a text file: many binary ones start with
"solid", too. Normals are not read: the order of the corners says the same, and is what other programs keep right.
Read here and not by trimesh, which takes a text file that breaks off in the middle for a whole one.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mesh_errors import MeshError

if TYPE_CHECKING:
    from pathlib import Path

HEADER = 84
FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: Path) -> npt.NDArray[np.float64]:
    """Corners of all facets [m], shape (facets, 3, 3).

    Raises:
        MeshError: the file is neither a whole binary nor a whole text STL file.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(HEADER)
    count = int.from_bytes(head[80:], "little")
    if size >= HEADER and size == HEADER + FACET.itemsize * count:
        return _read_binary(path)
    if size == 0:
        raise MeshError("the file is empty")
    if head.lstrip().lower().startswith(b"solid") and b"\0" not in head:
        return _read_text(path.read_bytes())
    if size < HEADER:
        raise MeshError(f"neither a text STL file, which starts with 'solid', nor a whole binary one: {size} bytes")
    raise MeshError(
        f"a binary STL file with {count} facets takes {HEADER + FACET.itemsize * count} bytes; "
        f"this one has {size}: it is cut short or not an STL file"
    )


def _read_binary(path: Path) -> npt.NDArray[np.float64]:
    return np.fromfile(path, dtype=FACET, offset=HEADER)["corners"].astype(np.float64)


def _read_text(text: bytes) -> npt.NDArray[np.float64]:
    text = text.lower()
    facets = len(re.findall(rb"\bendfacet\b", text))
    rows = re.findall(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", text)
    starts = len(re.findall(rb"\bfacet\s+normal\b", text))
    if b"endsolid" not in text or starts != facets or len(rows) != 3 * facets:
        raise MeshError(
            f"the text STL file breaks off or is garbled: {starts} facets begin, {facets} end, "
            f"with {len(rows)} vertices and {'an' if b'endsolid' in text else 'no'} 'endsolid'"
        )
    try:
        return np.array(rows).astype(np.float64).reshape(-1, 3, 3)
    except ValueError:
        word = next(word for row in rows for word in row if not _is_number(word))
        raise MeshError(f"not a number among the vertices: {word.decode(errors='replace')!r}") from None


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
