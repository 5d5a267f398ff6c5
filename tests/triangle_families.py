"""Random pairs of triangles, each family hard in its own way; a family is a function of a random generator."""

import numpy as np


def turn(rng):
    """A random rotation (3, 3)."""
    w, x, y, z = (q := rng.normal(size=4)) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _triangle(rng):
    return rng.normal(size=(3, 3))


def _flat(rng, height, spread):
    """A triangle nearly at z = height, moved by `spread` in its plane."""
    return np.column_stack([rng.normal(size=(3, 2)) + spread * rng.normal(size=2), height * np.ones(3)])


def _unit(v):
    return v / np.linalg.norm(v)


def _turned(rng, a, b):
    """Both turned half of the time: exact coordinates and rounded ones."""
    R = turn(rng) if rng.random() < 0.5 else np.eye(3)
    return a @ R.T, b @ R.T


def _sliver(rng):
    width = 10.0 ** rng.uniform(-16, -2)
    flat = np.array([[-0.5, 0, 0], [0.5, 0, 0], [rng.uniform(-0.6, 0.6), width, 0]])
    return flat @ turn(rng).T + 0.1 * rng.normal(size=3)


def random(rng):
    return _triangle(rng), _triangle(rng) + 2 * rng.normal(size=3)


def overlapping(rng):
    return _triangle(rng), _triangle(rng)


def micro_gap(rng):
    """Vertex over face, 1e-6 apart."""
    a, p = _flat(rng, 0.0, 0.0), _triangle(rng)
    p[:, 2] = np.abs(p[:, 2])
    p[0] = [*(rng.dirichlet([1, 1, 1]) @ a[:, :2]), 0.0]
    return _turned(rng, a, np.add(p, [0, 0, 1e-6]))


def micro_gap_edges(rng):
    """Edge over edge, 1e-6 apart."""
    a, b = _triangle(rng), _triangle(rng)
    a[:2] = [[-rng.random(), 0, 0], [rng.random(), 0, 0]]
    b[:2] = [[0, -rng.random(), 1e-6], [0, rng.random(), 1e-6]]
    a[2, 2], b[2, 2] = -abs(a[2, 2]), 1e-6 + abs(b[2, 2])
    return _turned(rng, a, b)


def coplanar(rng):
    return _turned(rng, _flat(rng, 0.0, 0.0), _flat(rng, 0.0, 1.5))


def nearly_coplanar(rng):
    a, b = _flat(rng, 0.0, 0.0), _flat(rng, 0.0, 1.2)
    b[:, 2] = rng.normal(size=3) * 10.0 ** rng.uniform(-17, -3)
    return _turned(rng, a, b)


def parallel(rng):
    a, b = _flat(rng, 0.0, 0.0), _flat(rng, 10.0 ** rng.uniform(-6, 0), 0.5)
    if rng.random() < 0.3:
        b[:2, :2] = 2 * a[:2, :2] + 0.3  # parallel edges, too
    return _turned(rng, a, b)


def nearly_parallel_crossing(rng):
    """Edges that cross at angles down to 1e-15, at distances down to zero."""
    angle = 10.0 ** rng.uniform(-15, -1)
    gap = 10.0 ** rng.uniform(-16, 0) if rng.random() < 0.6 else 0.0
    at, u = 0.3 * rng.normal(size=3), _unit(rng.normal(size=3))
    w = _unit(np.cross(u, rng.normal(size=3)))
    n, v = np.cross(u, w), u + angle * w
    a = np.array([at - u * rng.random(), at + u * rng.random(), at - n * (rng.random() + 0.2) + w * rng.normal()])
    b = np.array([at - v * rng.random(), at + v * rng.random(), at + n * (rng.random() + 0.2) + w * rng.normal()])
    return a, b + n * gap


def slivers(rng):
    return _sliver(rng), _sliver(rng) if rng.random() < 0.5 else _triangle(rng)


def zero_area(rng):
    """A point, an edge, or three points in a line against a triangle or an edge."""
    a, b = _triangle(rng), 0.7 * _triangle(rng)
    kind = rng.integers(3)
    if kind == 0:
        a[2] = a[1]
    elif kind == 1:
        a[:] = a[0]
    else:
        a[2] = a[0] + (a[1] - a[0]) * rng.integers(0, 3) / 2
    if rng.random() < 0.3:
        b[2] = b[0]
    return (a, b) if rng.random() < 0.5 else (b, a)


def shared_vertex(rng):
    a, b = _triangle(rng), _triangle(rng)
    b[rng.integers(3)] = a[rng.integers(3)]
    return a, b


def touching(rng):
    """A vertex of one on the face, an edge or a vertex of the other, up to rounding."""
    a, b = _triangle(rng), _triangle(rng)
    weights = rng.dirichlet([1, 1, 1]) * (rng.random(3) < 0.8)
    weights = weights / weights.sum() if weights.any() else np.array([1.0, 0, 0])
    return a, b + weights @ a - b[0]


def far_from_origin(rng):
    a, b = micro_gap(rng) if rng.random() < 0.5 else random(rng)
    away = 1e3 * rng.normal(size=3)
    return a + away, b + away


def _any(rng):
    families = (random, overlapping, micro_gap, micro_gap_edges, nearly_parallel_crossing, slivers)
    return families[rng.integers(len(families))](rng)


def small(rng):
    a, b = _any(rng)
    return 1e-6 * a, 1e-6 * b


def large(rng):
    a, b = _any(rng)
    return 1e4 * a, 1e4 * b


FAMILIES = (
    random,
    overlapping,
    micro_gap,
    micro_gap_edges,
    coplanar,
    nearly_coplanar,
    parallel,
    nearly_parallel_crossing,
    slivers,
    zero_area,
    shared_vertex,
    touching,
    far_from_origin,
    small,
    large,
)
