"""Volume, centre and inertia of the solid inside a closed surface, exact for the polyhedron.

The solid is the signed sum of the tetrahedra that a *local* origin makes with every facet (divergence theorem).
With a, b, c the corners and V = a . (b x c) / 6 the signed volume of one tetrahedron:

    integral of 1    = V
    integral of x    = V (a + b + c) / 4
    integral of x x' = V / 20 (a a' + b b' + c c' + s s'),   s = a + b + c

(D. Eberly, "Polyhedral Mass Properties (Revisited)", 2009; F. Tonon, J. Math. Stat. 1 (2005) 8-11.) The origin lies at
the middle of the bounding box, so that a unit cube 1e6 m away still has volume 1 and inertia 1/6 to 1e-12. Second
moments are taken about the centre in a second pass: moving them by parallel axes would subtract large numbers.
Sums run along the last axis, where numpy adds pairwise: the error grows with the logarithm of the facet count.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Iterator

Floats = npt.NDArray[np.float64]

FACETS_AT_ONCE = 1 << 17
"""Facets per block: bounds the memory of the pass at about 20 MB, whatever the size of the mesh."""


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Of a solid of density 1 kg/m3.

    Attributes:
        volume: [m3], negative when the facets are seen clockwise from outside.
        centre: centre of volume [m], shape (3,), in the frame of the vertices.
        inertia: about the centre, axes of the vertices [m5], shape (3, 3): times a density it is in kg m2.
    """

    volume: float
    centre: Floats
    inertia: Floats


def mass_properties(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> MassProperties:
    """Mass properties of the solid bounded by a closed surface.

    Args:
        vertices: positions [m], shape (n, 3).
        triangles: indices, shape (m, 3).

    Returns:
        The properties; a surface without volume gives volume 0, its vertices' middle as centre, and inertia 0.
    """
    points = np.asarray(vertices, dtype=np.float64)
    facets = np.asarray(triangles)
    origin = 0.5 * (points.min(axis=0) + points.max(axis=0))
    blocks = range(0, len(facets), FACETS_AT_ONCE)
    first = np.array([_volume_and_moment(block) for block in _corners(points, facets, origin)]).reshape(len(blocks), 4)
    volume = float(np.sum(first[:, 0]))
    offset = np.sum(first[:, 1:], axis=0) / volume if volume != 0.0 else np.zeros(3)
    second = [_second_moments(block) for block in _corners(points, facets, origin, offset)]
    moments = np.sum(np.array(second), axis=0)
    inertia = np.trace(moments) * np.eye(3) - moments
    return MassProperties(volume, origin + offset, inertia)


def centred(vertices: npt.ArrayLike, centre: npt.ArrayLike) -> Floats:
    """Vertices [m], shape (n, 3), about a centre [m], shape (3,).

    Both are first taken about the middle of the bounding box. That difference is exact or nearly so wherever the mesh
    lies, and it is the same local origin that the centre was computed about.
    """
    points = np.asarray(vertices, dtype=np.float64)
    origin = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return np.ascontiguousarray((points - origin) - (np.asarray(centre) - origin))


def surface_centre(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> Floats:
    """Centre of area [m], shape (3,), of any surface with an area."""
    points = np.asarray(vertices, dtype=np.float64)
    corners = points[np.asarray(triangles)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weights = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    origin = 0.5 * (points.min(axis=0) + points.max(axis=0))
    middles = np.ascontiguousarray((corners.mean(axis=1) - origin).T)
    centre: Floats = origin + np.sum(middles * weights, axis=1) / np.sum(weights)
    return centre


def _corners(
    points: Floats, facets: npt.NDArray[np.integer], origin: Floats, offset: Floats | None = None
) -> Iterator[Floats]:
    """Blocks of facet corners about `origin` (+ `offset`), shape (corner, axis, facet): sums run over the last axis."""
    for start in range(0, len(facets), FACETS_AT_ONCE):
        local = points[facets[start : start + FACETS_AT_ONCE]] - origin
        if offset is not None:
            local -= offset
        yield np.ascontiguousarray(local.transpose(1, 2, 0))


def _signed_volumes(corners: Floats) -> Floats:
    a, b, c = corners
    return np.asarray(
        (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]))
        / 6.0
    )


def _volume_and_moment(corners: Floats) -> Floats:
    volumes = _signed_volumes(corners)
    return np.array([np.sum(volumes), *(np.sum(volumes * axis) for axis in corners.sum(axis=0) / 4.0)])


def _second_moments(corners: Floats) -> Floats:
    volumes = _signed_volumes(corners) / 20.0
    points = (*corners, corners.sum(axis=0))
    moments = np.empty((3, 3))
    for i in range(3):
        for j in range(i, 3):
            products = sum(point[i] * point[j] for point in points)
            moments[i, j] = moments[j, i] = np.sum(volumes * products)
    return moments
