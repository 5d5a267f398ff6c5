"""Meshes for tests that are neither boxes nor convex."""

import numpy as np

from comotion_server.meshes import TriangleMesh


def _grid_surface(points):
    """The closed surface of a grid of points (n, m, 3) that joins its own ends both ways."""
    n, m, _ = points.shape
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return TriangleMesh(points.reshape(-1, 3), triangles)


def torus(around, across, radius=1.0, tube=0.3):
    """A torus about the z axis with `around` x `across` x 2 triangles."""
    u = 2 * np.pi * np.arange(around)[:, None] / around
    v = 2 * np.pi * np.arange(across)[None, :] / across
    ring = radius + tube * np.cos(v)
    return _grid_surface(np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v) + 0 * u], -1))


def l_shape():
    """Two unit squares and the one between them, 1 thick; `in_l_shape` is its inside."""
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]) - 0.8
    vertices = np.vstack([np.column_stack([outline, np.full(6, z)]) for z in (-0.5, 0.5)])
    top = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    side = [[i, (i + 1) % 6, 6 + (i + 1) % 6] for i in range(6)] + [[i, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    return TriangleMesh(vertices, np.vstack([top + 6, top[:, ::-1], side]))


def in_l_shape(point):
    x, y, z = np.add(point, [0.8, 0.8, 0.0])
    return 0 < x < 2 and 0 < y < 2 and not (x >= 1 and y >= 1) and abs(z) < 0.5


def needles(rng, count):
    """Loose triangles, long and thin, in all directions."""
    at, along = 0.5 * rng.normal(size=(count, 1, 3)), rng.normal(size=(count, 3))
    ends = np.stack([along, -along, 0.01 * rng.normal(size=(count, 3))], axis=1)
    return TriangleMesh((at + ends).reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def tetrahedron():
    """Apex down at (0, 0, -0.5), a triangle on top at z = 0.5."""
    vertices = np.array([[0.0, 0.0, -0.5], [0.5, 0.0, 0.5], [-0.3, 0.4, 0.5], [-0.3, -0.4, 0.5]])
    return TriangleMesh(vertices, np.array([[0, 3, 1], [0, 2, 3], [0, 1, 2], [1, 3, 2]]))
