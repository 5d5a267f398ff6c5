"""Binary STL: the same mesh gives the same bytes."""

from __future__ import annotations

import numpy as np

from comotion_mock_cfd.water_line import Floats, Indices, area_vectors

HEADER_BYTES = 80
FACET = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
)  # 50 bytes, as the format says


def binary_stl(vertices: Floats, triangles: Indices, title: str) -> bytes:
    """A binary STL file of a mesh: vertices [m], shape (n, 3), rounded to float32; triangles (m, 3)."""
    area = area_vectors(vertices, triangles)
    facets = np.zeros(len(triangles), FACET)
    facets["normal"] = area / np.linalg.norm(area, axis=1, keepdims=True)
    facets["corners"] = vertices[triangles]
    header = title.encode("ascii").ljust(HEADER_BYTES)[:HEADER_BYTES]
    return header + len(triangles).to_bytes(4, "little") + facets.tobytes()
