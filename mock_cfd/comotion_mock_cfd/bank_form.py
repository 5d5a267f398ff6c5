"""The port bank of the scene `channel`: a wall that is jagged near the start and straight further on, as STL.

`python -m comotion_mock_cfd.bank_form OUT.stl` writes it. Its face looks to starboard; the other bank is the same one,
turned half round about x. Noses reach the channel's face, bays lie up to 0.2 m behind it, and the channel opens aft.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.stl_file import binary_stl

if TYPE_CHECKING:
    from comotion_mock_cfd.water_line import Floats, Indices

FACE = (
    *((-1.2, 1.35), (0.2, 1.2), (0.8, 0.95), (1.1, 0.95), (1.25, 1.1), (1.5, 1.05), (1.6, 0.95), (1.8, 0.97)),
    *((1.95, 1.15), (2.2, 1.15), (2.25, 0.98), (2.5, 0.95), (5.8, 0.95)),
)
"""Corners (x, y) of the face [m], from the stern's end forward."""
BACK = 1.5
"""y of the straight back [m]."""
HEIGHT = 0.2
"""Above and below the waterline [m]."""


def bank_mesh() -> tuple[Floats, Indices]:
    """Vertices [m], shape (n, 3), and triangles (m, 3): a straight wall of one quadrilateral per side of the face."""
    face = np.array(FACE)
    back = np.column_stack([face[:, 0], np.full(len(face), BACK)])
    outline = np.concatenate([face, back[::-1]])  # counter-clockwise from above
    count, n = len(face), len(outline)
    vertices = np.concatenate([np.column_stack([outline, np.full(n, z)]) for z in (-HEIGHT, HEIGHT)])
    strips = [(i, i + 1, n - 2 - i, n - 1 - i) for i in range(count - 1)]
    top = [(a + n, b + n, c + n, d + n) for a, b, c, d in strips]
    bottom = [(d, c, b, a) for a, b, c, d in strips]
    sides = [(i, j, j + n, i + n) for i in range(n) for j in [(i + 1) % n]]
    quads = np.array(bottom + top + sides)
    return vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(binary_stl(*bank_mesh(), "bank, jagged near the start"))
