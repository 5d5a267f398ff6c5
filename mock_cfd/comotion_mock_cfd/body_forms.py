"""Meshes of the smaller bodies of the shipped scenes, as STL: cube, ball, floe, jack and ring.

`python -m comotion_mock_cfd.body_forms FOLDER` writes them all. Lengths are multiples of 1/64 m, so that the corners
that matter (faces that meet, the corner a ball lands on) are the same numbers in float32.
"""

from __future__ import annotations

import itertools
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.box_form import QUADS, box_mesh
from comotion_mock_cfd.stl_file import binary_stl

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from comotion_mock_cfd.water_line import Floats, Indices

    Mesh = tuple[Floats, Indices]

CUBE = 1 / 8
"""Edge of the cube [m]."""
BALL_RADIUS, BALL_HALVINGS = 1 / 8, 2
"""Of the sphere that the ball's corners lie on [m]; every halving of the edges makes four facets of one."""
FLOE_SIDE, FLOE_THICKNESS = 1 / 8, 1 / 64
"""Of the hexagonal plate [m]."""
JACK_CELL = 1 / 16
"""Edge of the seven cubes of the jack [m]."""
RING_RADIUS, TUBE_RADIUS = 1 / 8, 1 / 32
"""Of the ring's centre line, and of its tube [m]."""
RING_FACETS = (24, 12)
"""Quadrilaterals around the axis and around the tube."""


def ball_mesh(radius: float = BALL_RADIUS, halvings: int = BALL_HALVINGS) -> Mesh:
    """An icosahedron with corners at both poles, its edges halved and pushed out to the sphere again and again."""
    ring = 2 * np.pi * np.arange(5) / 5
    low, high = (
        [(2 * math.cos(a + turn), 2 * math.sin(a + turn), z) for a in ring] for turn, z in ((0, -1), (math.pi / 5, 1))
    )
    vertices = np.array([(0, 0, -math.sqrt(5)), *low, *high, (0, 0, math.sqrt(5))]) / math.sqrt(5)
    fans = [facet for i in range(5) for facet in _fifth_of_icosahedron(i, (i + 1) % 5)]
    triangles: Indices = np.array(fans)
    for _ in range(halvings):
        vertices, triangles = _halve_edges(vertices, triangles)
    vertices[0], vertices[11] = (0, 0, -1), (0, 0, 1)
    return vertices * radius, triangles


def _fifth_of_icosahedron(i: int, j: int) -> list[tuple[int, int, int]]:
    """Four facets: corners 0 and 11 are the poles, 1 to 5 the ring below, 6 to 10 the one above."""
    return [(0, 1 + j, 1 + i), (1 + i, 1 + j, 6 + i), (1 + j, 6 + j, 6 + i), (6 + i, 6 + j, 11)]


def _halve_edges(vertices: Floats, triangles: Indices) -> Mesh:
    """Four facets for each, the new corners on the unit sphere."""
    edges = np.sort(triangles[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1)
    ends, index = np.unique(edges, axis=0, return_inverse=True)
    middles = vertices[ends].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    ab, bc, ca = index.reshape(-1, 3).T + len(vertices)
    a, b, c = triangles.T
    facets = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middles]), np.concatenate([np.stack(facet, axis=-1) for facet in facets])


def floe_mesh(side: float = FLOE_SIDE, thickness: float = FLOE_THICKNESS) -> Mesh:
    """A hexagonal plate about its centre: 20 facets."""
    angles = np.pi / 3 * np.arange(6)
    outline = side * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    vertices = np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (-thickness / 2, thickness / 2)])
    top = [(6, 7 + i, 8 + i) for i in range(4)]
    bottom = [(0, 2 + i, 1 + i) for i in range(4)]
    sides = [facet for i in range(6) for j in [(i + 1) % 6] for facet in ((i, j, 6 + j), (i, 6 + j, 6 + i))]
    return vertices, np.array(bottom + top + sides)


def jack_mesh(cell: float = JACK_CELL) -> Mesh:
    """A cube with a cube on each of its six faces: 60 facets, flat faces of many facets, twelve notches."""
    arms = [tuple(sign * (axis == k) for k in range(3)) for axis in range(3) for sign in (-1, 1)]
    return polycube_mesh([(0, 0, 0), *arms], cell)


def polycube_mesh(cells: Sequence[tuple[int, ...]], edge: float) -> Mesh:
    """The outer faces of cubes [m] at whole-numbered places; two of them share a face, or nothing."""
    corners, _ = box_mesh((1.0, 1.0, 1.0))
    outer = [
        np.array(place) + corners[list(quad)]
        for place in cells
        for quad in QUADS
        if tuple(np.add(place, 2 * corners[list(quad)].mean(axis=0)).astype(int)) not in cells
    ]
    vertices, index = np.unique(np.concatenate(outer), axis=0, return_inverse=True)
    a, b, c, d = index.reshape(-1, 4).T
    return vertices * edge, np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])


def ring_mesh(radius: float = RING_RADIUS, tube: float = TUBE_RADIUS, facets: tuple[int, int] = RING_FACETS) -> Mesh:
    """A torus about the z axis."""
    around, across = facets
    u, v = np.meshgrid(2 * np.pi * np.arange(around) / around, 2 * np.pi * np.arange(across) / across, indexing="ij")
    out = radius + tube * np.cos(v)
    vertices = np.stack([out * np.cos(u), out * np.sin(u), tube * np.sin(v)], axis=-1).reshape(-1, 3)
    quads = [
        (i * across + j, k * across + j, k * across + m, i * across + m)
        for i, j in itertools.product(range(around), range(across))
        for k, m in [((i + 1) % around, (j + 1) % across)]
    ]
    a, b, c, d = np.array(quads).T
    return vertices, np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])


FORMS: dict[str, tuple[Callable[[], Mesh], str]] = {
    "ball": (ball_mesh, "icosahedron, edges halved twice, on a sphere of radius 0.125 m"),
    "cube": (lambda: box_mesh((CUBE, CUBE, CUBE)), "cube, edge 0.125 m"),
    "floe": (floe_mesh, "hexagonal plate, side 0.125 m, 15.625 mm thick"),
    "jack": (jack_mesh, "jack of seven cubes, edge 62.5 mm each"),
    "ring": (ring_mesh, "torus, radii 125 mm and 31.25 mm"),
}


if __name__ == "__main__":
    for name, (mesh, title) in FORMS.items():
        (Path(sys.argv[1]) / f"{name}.stl").write_bytes(binary_stl(*mesh(), title))
