r"""The wetted part of a triangulated surface: whole facets below the water, and pieces of facets cut by it.

              c                 one corner wet: one piece  (a, ab, ac)
             / \
    ~ ~ ~ ~ac~ ~ab~ ~ ~ level   two corners wet: two pieces (ab, b, c) and (ab, c, ac), where a is the dry corner
           /     \
          ...                   a piece keeps the facet's own linear shape functions, given at the piece's corners

A piece carries the shape functions of its *unclipped* facet. Whatever is lumped to the facet's vertices with them has
the force and the moment of the integral over the wetted part, because they reproduce every linear field, positions too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.integer]

# A cut facet is turned so that its odd corner (the only wet or the only dry one) comes first.
TURNS = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1]])


@dataclass(frozen=True)
class WetSurface:
    """What of a surface is under water. Vertex positions [m], world frame, z up."""

    vertices: Floats
    """Vertex positions [m], shape (n, 3), world."""
    depth: Floats
    """Depth of every vertex below the level [m], shape (n,); negative in the air."""
    whole: Indices
    """Vertex indices of the facets that are wet all over, shape (w, 3)."""
    cut: Indices
    """Vertex indices of the facet that each piece belongs to, shape (p, 3)."""
    shape: Floats
    """Shape function of facet corner i at piece corner c, shape (p, c, i) = (p, 3, 3)."""

    @cached_property
    def whole_area(self) -> Floats:
        """Outward area vectors of the whole facets [m2], shape (w, 3)."""
        return area_vectors(self.vertices, self.whole)

    @cached_property
    def cut_area(self) -> Floats:
        """Outward area vectors of the pieces [m2], shape (p, 3): the facet's, times the piece's share of it."""
        share = np.linalg.det(self.shape)  # the area of a triangle in barycentric coordinates, relative to the facet
        area: Floats = area_vectors(self.vertices, self.cut) * share[:, None]
        return area


def wet_surface(vertices: Floats, triangles: Indices, level: float) -> WetSurface:
    """Clip a surface at the plane z = level.

    Args:
        vertices: positions [m], shape (n, 3), world.
        triangles: vertex indices, shape (m, 3), counter-clockwise seen from outside.
        level: height of the free surface [m].
    """
    depth = level - vertices[:, 2]
    wet_vertex = depth > 0.0
    wet = wet_vertex[triangles]
    wet_count = wet[:, 0].astype(np.int8) + wet[:, 1] + wet[:, 2]
    is_cut = (wet_count == 1) | (wet_count == 2)
    cut, shape = _cut_pieces(triangles[is_cut], wet[is_cut], depth)
    return WetSurface(vertices, depth, triangles[wet_count == 3], cut, shape)


def area_vectors(vertices: Floats, triangles: Indices) -> Floats:
    """Area times outward normal [m2], shape (m, 3), of counter-clockwise triangles; exact for thin ones, too."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


def _cut_pieces(triangles: Indices, wet: NDArray[np.bool_], depth: Floats) -> tuple[Indices, Floats]:
    """Pieces of the facets that the level cuts: vertex indices (p, 3) and shape functions at the corners (p, 3, 3)."""
    one_wet = wet.sum(axis=1) == 1
    odd = np.where(one_wet, np.argmax(wet, axis=1), np.argmin(wet, axis=1))
    turned = np.take_along_axis(triangles, TURNS[odd], axis=1)
    a, b, c = (depth[turned[:, i]] for i in range(3))
    corner = np.broadcast_to(np.eye(3), (len(turned), 3, 3))
    at_ab = _crossing(corner[:, 0], corner[:, 1], a / (a - b))  # a and b lie on two sides of the level: a - b is not 0
    at_ac = _crossing(corner[:, 0], corner[:, 2], a / (a - c))
    tips = np.stack([corner[:, 0], at_ab, at_ac], axis=1)[one_wet]
    near = np.stack([at_ab, corner[:, 1], corner[:, 2]], axis=1)[~one_wet]
    far = np.stack([at_ab, corner[:, 2], at_ac], axis=1)[~one_wet]
    pieces = np.concatenate([turned[one_wet], turned[~one_wet], turned[~one_wet]])
    return pieces, np.concatenate([tips, near, far])


def _crossing(start: Floats, end: Floats, fraction: Floats) -> Floats:
    """Shape functions where an edge crosses the level, shape (k, 3)."""
    return start + (end - start) * fraction[:, None]
