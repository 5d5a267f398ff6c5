"""The box of the scenes `float_box` and `drop`: 0.4 x 0.4 x 0.2 m about the origin, as STL.

`python -m comotion_mock_cfd.box_form OUT.stl` writes it. With 16 kg it floats in fresh water at a draught of 0.1 m,
upright: GM = KB + BM - KG = 0.05 + 0.4^2 / (12 x 0.1) - 0.1 = 0.083 m.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.stl_file import binary_stl

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from comotion_mock_cfd.water_line import Floats

SIZE = (0.4, 0.4, 0.2)
"""Edges along x, y, z [m]."""
QUADS = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
"""Corner i lies at (x, y, z) = bits 0, 1, 2 of i; counter-clockwise from outside."""


def box_mesh(size: tuple[float, float, float]) -> tuple[Floats, NDArray[np.uint32]]:
    """Vertices [m], shape (8, 3), about the centre, and triangles (12, 3) of a box with edges along x, y, z [m]."""
    corners = np.array([[(i >> axis) & 1 for axis in range(3)] for i in range(8)])
    triangles = [facet for a, b, c, d in QUADS for facet in ((a, b, c), (a, c, d))]
    return (corners - 0.5) * size, np.array(triangles, dtype=np.uint32)


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(binary_stl(*box_mesh(SIZE), "box 0.4 x 0.4 x 0.2 m"))
