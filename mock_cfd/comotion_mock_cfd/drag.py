"""Quadratic form drag and skin friction on the wetted facets, against a uniform current.

On a wetted piece of area A with outward normal n, whose centroid moves at u relative to the water:

    form drag  -1/2 rho Cd A (u.n)^2 n      where u.n > 0, that is, where the facet moves into the water
    friction   -1/2 rho Cf A |u_t| u_t      u_t = u - (u.n) n

The first is Newton's sine-squared law: a plate face-on has drag coefficient Cd, a sphere Cd / 2. There is no wake, no
wave and no lift in it: a force of the right kind and size that only takes energy, at the rate of
1/2 rho A (Cd (u.n)^3 + Cf |u_t|^3) relative to the water, no more. It acts at the piece's centroid and is shared among
the facet's vertices by the shape functions there, so that its moment is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.nodal import add_to_vertices

if TYPE_CHECKING:
    from comotion_mock_cfd.water_line import Floats, Indices, WetSurface


def add_drag(nodal: Floats, wet: WetSurface, velocities: Floats, density: float, form: float, friction: float) -> None:
    """Add the drag of all wetted facets to nodal forces [N], shape (n, 3), world, in place.

    Args:
        nodal: the sums to add to.
        wet: the wetted surface.
        velocities: of the vertices relative to the water [m/s], shape (n, 3), world.
        density: of the water [kg/m3].
        form: Cd of a facet moving face-on into the water.
        friction: Cf of a facet moving in its own plane.
    """
    third = np.full((1, 3), 1.0 / 3.0)  # shape functions at the centroid of a whole facet
    _add_to_pieces(nodal, wet.whole, third, wet.whole_area, velocities, density, form, friction)
    _add_to_pieces(nodal, wet.cut, wet.shape.mean(axis=1), wet.cut_area, velocities, density, form, friction)


def _add_to_pieces(
    nodal: Floats,
    facets: Indices,
    shape: Floats,
    area_vector: Floats,
    velocities: Floats,
    density: float,
    form: float,
    friction: float,
) -> None:
    """Add the drag of pieces from the shape functions at their centroids (k or 1, 3) and area vectors (k, 3) [m2]."""
    velocity = np.einsum("ki,kij->kj", np.broadcast_to(shape, facets.shape), velocities[facets])
    force = piece_drag(velocity, area_vector, density, form, friction)
    add_to_vertices(nodal, facets, shape[:, :, None] * force[:, None, :])


def piece_drag(velocity: Floats, area_vector: Floats, density: float, form: float, friction: float) -> Floats:
    """Drag [N], shape (k, 3), world, of plane pieces with area vectors (k, 3) [m2] moving at (k, 3) [m/s]."""
    area = np.linalg.norm(area_vector, axis=1)
    normal = area_vector / np.where(area > 0.0, area, 1.0)[:, None]  # a facet without area has no drag
    into_water = np.einsum("ki,ki->k", velocity, normal)
    tangential = velocity - into_water[:, None] * normal
    form_term = form * np.maximum(into_water, 0.0) ** 2
    friction_term = friction * np.linalg.norm(tangential, axis=1)
    dynamic = -0.5 * density * area
    drag: Floats = (dynamic * form_term)[:, None] * normal + (dynamic * friction_term)[:, None] * tangential
    return drag
