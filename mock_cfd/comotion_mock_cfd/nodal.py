"""From facets to vertices: sums of facet contributions, and the force and moment of nodal forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from comotion_mock_cfd.water_line import Floats, Indices


def add_to_vertices(nodal: Floats, facets: Indices, forces: Floats) -> None:
    """Add the forces at the three corners of every facet to the vertices' sums.

    Args:
        nodal: nodal forces [N], shape (n, 3); added to in place.
        facets: vertex indices, shape (k, 3).
        forces: force on each corner of each facet [N], shape (k, 3 corners, 3).
    """
    for axis in range(3):  # bincount is several times faster than np.add.at
        for corner in range(3):
            nodal[:, axis] += np.bincount(facets[:, corner], weights=forces[:, corner, axis], minlength=len(nodal))


def wrench_about(centre: Floats, vertices: Floats, forces: Floats) -> Floats:
    """Force [N] and moment [N m] about a point, shape (6,), world, of nodal forces at vertices (n, 3)."""
    return np.concatenate([forces.sum(axis=0), np.cross(vertices - centre, forces).sum(axis=0)])
