"""The hull of the scene `channel`: Wigley's parabolic hull with a raked ice bow.

`python -m comotion_mock_cfd.hull_form OUT.stl` writes it.

Frame: x forward, y to port, z up; x = 0 amidships of the design waterline, z = 0 at it. Half-breadth

    y(x, z) = B/2 (1 - xi^2) (1 - (z/T)^2) for z <= 0,    y = B/2 (1 - xi^2) above the waterline,
    xi = x / (L/2) abaft amidships,    xi = x / (L/2 + z cot(phi)) before it.

The first line is the parabolic hull of Wigley (1934, *A comparison of experiment and calculated wave profiles and wave
resistances for a form having parabolic waterlines*), wall-sided above the waterline as usual. The second is the ice
bow: every waterline keeps its parabola, but ends at a straight stem that rises at phi to the waterline plane, below it
and above it, so that the bow presses ice down. 20 to 30 degrees are usual on icebreakers.

Displaced volume up to z = 0, by integration: 4/9 L B T - 1/6 B T^2 cot(phi). With the numbers below: 0.1254 m3 of the
form and, because the mesh's facets are chords, 0.1250 m3 of the mesh. So 125 kg float at the design draught in fresh
water (1000 kg/m3); block coefficient 0.41. The transom is sharp, the deck flat and closed.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.stl_file import binary_stl

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from comotion_mock_cfd.water_line import Floats

LENGTH = 2.0
"""L of the design waterline [m]."""
BEAM = 0.614
"""B at the waterline amidships [m]."""
DRAUGHT = 0.25
"""T by design [m]."""
FREEBOARD = 0.10
"""Height of the deck above the waterline [m]; depth 0.35 m."""
STEM_ANGLE = math.radians(30.0)
"""phi between stem and waterline [rad]."""

STATIONS = 24
"""Strips along a waterline, even: half of them on each side of amidships."""
WATERLINES = (10, 2)
"""Strips below and above the design waterline."""


def form_volume() -> float:
    """Displaced volume of the form at its design draught [m3]."""
    return 4 / 9 * LENGTH * BEAM * DRAUGHT - BEAM * DRAUGHT**2 / math.tan(STEM_ANGLE) / 6


def hull_mesh(stations: int = STATIONS, waterlines: tuple[int, int] = WATERLINES) -> tuple[Floats, NDArray[np.uint32]]:
    """Vertices [m], shape (n, 3), in the hull's frame and triangles (m, 3): closed, counter-clockwise from outside."""
    port = _port_side(stations, waterlines)
    rows, columns, _ = port.shape
    points = np.stack([port, port * (1.0, -1.0, 1.0)]) + 0.0  # + 0.0 turns -0.0 on the centre line into 0.0
    index = np.arange(points[..., 0].size).reshape(2, rows, columns)
    triangles = np.concatenate([_side(index[0]), _side(index[1])[:, ::-1], _deck(index[:, -1])])
    vertices, first = np.unique(points.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, first.reshape(-1)[triangles].astype(np.uint32)


def _port_side(stations: int, waterlines: tuple[int, int]) -> Floats:
    """Points [m] of the port side, shape (waterlines, stations, 3), from keel to deck and from stern to stem."""
    below, above = waterlines
    z = np.concatenate([np.linspace(-DRAUGHT, 0.0, below + 1), np.linspace(0.0, FREEBOARD, above + 1)[1:]])
    xi = np.linspace(-1.0, 1.0, stations + 1)
    z, xi = np.meshgrid(z, xi, indexing="ij")
    x = xi * np.where(xi < 0.0, LENGTH / 2, LENGTH / 2 + z / math.tan(STEM_ANGLE))
    y = BEAM / 2 * (1.0 - xi**2) * (1.0 - (np.minimum(z, 0.0) / DRAUGHT) ** 2)
    return np.stack([x, y, z], axis=-1)


def _side(index: NDArray[np.integer]) -> NDArray[np.integer]:
    """Triangles (m, 3) of a port side from its grid of point indices (waterlines, stations).

    Abaft amidships the diagonals rise forward, before it they rise aft. The other way round the corner facets, keel
    with stern post and keel with stem, would lie in the centre plane, twice.
    """
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    half = index.shape[1] // 2
    aft = [(a, c, b), (a, d, c)]
    fore = [(a, d, b), (b, d, c)]
    parts = [np.stack(facet, axis=-1)[:, :half] for facet in aft] + [
        np.stack(facet, axis=-1)[:, half:] for facet in fore
    ]
    return np.concatenate([part.reshape(-1, 3) for part in parts])


def _deck(edge: NDArray[np.integer]) -> NDArray[np.integer]:
    """Triangles (m, 3) of the deck from the point indices of its port and starboard edges (2, stations)."""
    port, starboard = edge
    first = np.stack([starboard[:-1], starboard[1:], port[1:]], axis=-1)[
        :-1
    ]  # the last one has two corners at the stem
    second = np.stack([starboard[:-1], port[1:], port[:-1]], axis=-1)[1:]  # and the first one two at the stern
    return np.concatenate([first, second])


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(binary_stl(*hull_mesh(), "Wigley hull with raked ice bow, L 2.0 m"))
