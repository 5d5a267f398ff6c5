"""The simplified frame of the hull (P17, P22): the same form with an eighth of the facets, a little larger all round.

`python -m comotion_mock_cfd.hull_frame_form OUT.stl` writes it. Its facets are chords of the enlarged form, so it is
enlarged by more than the clearance wanted: 4 mm of breadth go to the chords between two stations amidships.
`comotion check channel` gives the clearance that is left.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from comotion_mock_cfd.hull_form import hull_mesh
from comotion_mock_cfd.stl_file import binary_stl

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from comotion_mock_cfd.water_line import Floats

STATIONS = 8
WATERLINES = (3, 1)
"""Strips as in `hull_form`, but fewer."""
SCALE = (1.02, 1.09, 1.04)
"""Along x, y, z, about the middle of the design waterline."""


def hull_frame_mesh() -> tuple[Floats, NDArray[np.uint32]]:
    """Vertices [m], shape (n, 3), in the hull's frame and triangles (m, 3): closed, counter-clockwise from outside."""
    vertices, triangles = hull_mesh(STATIONS, WATERLINES)
    return vertices * SCALE, triangles


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(binary_stl(*hull_frame_mesh(), "frame of the Wigley hull with raked ice bow"))
