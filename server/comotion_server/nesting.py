"""Which bodies start inside others.

Distances compare surfaces, so a body in the solid of another one overlaps it without being near its surface. A cavity
is no solid: its walls run the other way round. An open surface has no inside. All of a body's corners are asked: one
of a body that lies on another one may be on its surface.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.mesh_arrays import MeshArrays
from comotion_server.kernels.ray import way_out, winding_number

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

INSIDE = "the first is inside the second at the start; expected bodies outside each other"
WHOLE = 1e-6  # how far a winding number may be from a whole one; an open surface is farther off


def nested(m: MeshArrays, shape: Rows, pairs: Rows, x: Array, R: Array) -> Iterator[tuple[int, int]]:
    """(inner, outer) of all pairs whose surfaces do not cross and of which one body is in the other.

    Args:
        m: all shapes.
        shape: (n,) of each body among them; -1 for what is round.
        pairs: (k, 2) the bodies to be compared.
        x: (n, 3) their places [m].
        R: (n, 3, 3) their attitudes, body to world.
    """
    ways = np.vstack([pairs, pairs[:, ::-1]])
    ways = ways[shape[ways[:, 1]] >= 0]
    inner, outer = ways[:, 0], ways[:, 1]
    point = np.array([_points_of(m, s)[0] for s in shape[inner]]).reshape(-1, 3)
    point = np.einsum("kij,kj->ki", R[inner], point) + x[inner]  # any one of the inner body's: most pairs end here
    point = np.einsum("kji,kj->ki", R[outer], point - x[outer])
    root = m.root[shape[outer]]
    seen = np.einsum("kij,kj->ki", m.axes[root], point - m.centre[root])
    for k in np.flatnonzero((np.abs(seen) < m.half[root]).all(axis=1)).tolist():
        i, o = int(inner[k]), int(outer[k])
        if all(
            _is_inside(m, int(shape[o]), point) for point in (_points_of(m, shape[i]) @ R[i].T + x[i] - x[o]) @ R[o]
        ):
            yield i, o


def _points_of(m: MeshArrays, shape: int) -> Array:
    """What of a body (k,3) [m] tells whether all of it is inside another one; of a round body its centre."""
    return m.vertices[m.vertex_start[shape] : m.vertex_start[shape + 1]] if shape >= 0 else np.zeros((1, 3))


def _is_inside(m: MeshArrays, shape: int, point: Array) -> bool:
    """Whether a point (3,) [m], frame of a body, is in its solid; either may be said of one on its surface."""
    p = tuple(point.tolist())
    if way_out(m, shape, p, (0.0, 0.0, 1.0), np.empty((STACK_SIZE, 2), dtype=np.int64)) < 0.0:
        return False
    turns = winding_number(m, shape, p)
    return bool(turns > 0.5 and abs(turns - round(turns)) < WHOLE)
