"""Hard contacts of a vertex with a face and of two edges, all corners on straight lines, exact in rational numbers.

Every number is a small multiple of a power of two, so that corners at time 0, their velocities and the contact at time
`when` are exact as doubles; that there is a contact then is checked with fractions. An earlier one may exist.
"""

from fractions import Fraction
from typing import NamedTuple

import numpy as np

GRID = 64
STEPS = 12  # times 1 / GRID: parameters on edges and faces


class Query(NamedTuple):
    """Corners (3, 3) of a and b at time 0 and their velocities, and a time at which they touch."""

    a: np.ndarray
    b: np.ndarray
    velocity_a: np.ndarray
    velocity_b: np.ndarray
    when: Fraction


def _dyadic(rng, *shape, spread=2 * GRID, grid=GRID):
    """Fractions on a grid, in an object array."""
    numbers = rng.integers(-spread, spread + 1, size=shape)
    return np.array([Fraction(int(k), grid) for k in numbers.ravel()], dtype=object).reshape(shape)


def _weights(rng, count, place):
    """Convex weights: inside, or with `place` of them zero; they add up to 1."""
    inside = count - place
    parts = rng.integers(1, STEPS, size=inside)
    power = 16
    weights = [Fraction(int(k), power) for k in parts[:-1]]
    while sum(weights) >= 1:
        weights = [w / 2 for w in weights]
    weights = [*weights, 1 - sum(weights), *[Fraction(0)] * place]
    return [weights[k] for k in rng.permutation(count)]


def _when(rng):
    return rng.choice([Fraction(1), Fraction(int(rng.integers(1, GRID)), GRID)], p=[0.2, 0.8])


def _mixed(weights, points):
    return sum(w * p for w, p in zip(weights, points, strict=True))


def _along(rng, *directions):
    """A combination of directions, with dyadic factors."""
    return sum(f * d for f, d in zip(_dyadic(rng, len(directions)), directions, strict=True))


def _from_contact(corners, velocities, when, split):
    """The query whose corners are where they are given at `when`; the first `split` make up a."""
    start = corners - when * velocities

    def padded(points):
        points = list(points)
        return np.array([*points, *[points[-1]] * (3 - len(points))], dtype=float)

    parts = [padded(part) for part in (start[:split], start[split:], velocities[:split], velocities[split:])]
    exact = np.array([*start.ravel(), *velocities.ravel()], dtype=object)
    assert all(Fraction(float(value)) == value for value in exact)
    return Query(*parts, when)


def _vertex_face(rng, place=0, *, grazing=False):
    face, weights = _dyadic(rng, 3, 3), _weights(rng, 3, place)
    v = _dyadic(rng, 3, 3)
    moving = _dyadic(rng, 3)
    if grazing:  # no normal speed against the face: a double root
        moving = _mixed(weights, v) + _along(rng, face[1] - face[0], face[2] - face[0])
    corners = np.vstack([face, _mixed(weights, face)[None]])
    return _from_contact(corners, np.vstack([v, moving[None]]), _when(rng), 3)


def _edges(rng, place=0, *, grazing=False):
    one, s = _dyadic(rng, 2, 3), _weights(rng, 2, place)
    direction, t = _dyadic(rng, 3), _weights(rng, 2, 0)
    at = _mixed(s, one)
    other = np.array([at - t[1] * direction, at + t[0] * direction])
    v = _dyadic(rng, 4, 3)
    if grazing:
        # the second edge's point gets the velocity of the first one's, up to a slide along both
        slip = _mixed(s, v[:2]) + _along(rng, one[1] - one[0], direction) - _mixed(t, v[2:])
        v[2:] += slip
    return _from_contact(np.vstack([one, other]), v, _when(rng), 2)


def vertex_face(rng):
    return _vertex_face(rng)


def vertex_on_edge_of_face(rng):
    return _vertex_face(rng, 1)


def vertex_on_vertex(rng):
    return _vertex_face(rng, 2)


def vertex_grazes_face(rng):
    return _vertex_face(rng, grazing=True)


def edge_edge(rng):
    return _edges(rng)


def edge_on_end_of_edge(rng):
    return _edges(rng, 1)


def edges_graze(rng):
    return _edges(rng, grazing=True)


def coplanar_slide(rng):
    """A vertex and a face that move and change in one plane, until the vertex is on an edge."""
    e, f, at = _dyadic(rng, 3), _dyadic(rng, 3), _dyadic(rng, 3)
    face = np.array([at + _along(rng, e, f) for _ in range(3)])
    v = np.array([_along(rng, e, f) / 64 for _ in range(4)])
    corners = np.vstack([face, _mixed(_weights(rng, 3, 1), face)[None]])
    return _from_contact(corners, v, _when(rng), 3)


def parallel_edges(rng):
    """Edges of one direction that keep it and meet side by side."""
    direction, at = _dyadic(rng, 3), _dyadic(rng, 3)
    first, second = sorted(_dyadic(rng, 2)), sorted(_dyadic(rng, 2, spread=GRID))
    corners = np.array([at + k * direction for k in (first[0] - 2, first[1] + 2, second[0] - 1, second[1] + 1)])
    v, w = _dyadic(rng, 3), _dyadic(rng, 3)
    return _from_contact(corners, np.array([v, v, w, w]), _when(rng), 2)


def collinear_edges(rng):
    """Edges on one line that come together end to end."""
    direction, at = _dyadic(rng, 3), _dyadic(rng, 3)
    one, other = np.array([at - 2 * direction, at]), np.array([at, at + direction])
    v, towards = _dyadic(rng, 3), Fraction(int(rng.integers(1, GRID)), GRID)
    velocities = np.array([v, v, v - towards * direction, v - towards * direction])
    return _from_contact(np.vstack([one, other]), velocities, _when(rng), 2)


def nearly_parallel_edges(rng):
    """Edges that meet at an angle of some 1e-6."""
    one, s, t = _dyadic(rng, 2, 3), _weights(rng, 2, 0), _weights(rng, 2, 0)
    direction, at = one[1] - one[0] + _dyadic(rng, 3) / 2**20, _mixed(s, one)
    other = np.array([at - t[1] * direction, at + t[0] * direction])
    return _from_contact(np.vstack([one, other]), _dyadic(rng, 4, 3), _when(rng), 2)


def just_inside(rng):
    """A vertex that meets a face 1e-12 from its edge."""
    face, v, little = _dyadic(rng, 3, 3), _dyadic(rng, 4, 3), Fraction(1, 2**40)
    weights = [Fraction(3, 4) - little, Fraction(1, 4), little]
    return _from_contact(np.vstack([face, _mixed(weights, face)[None]]), v, _when(rng), 3)


FAMILIES = {
    family.__name__.replace("_", " "): family
    for family in (
        vertex_face, vertex_on_edge_of_face, vertex_on_vertex, vertex_grazes_face, edge_edge, edge_on_end_of_edge,
        edges_graze, coplanar_slide, parallel_edges, collinear_edges, nearly_parallel_edges, just_inside,
    )
}  # fmt: skip


def queries(rng, count):
    """`count` queries, equally many of each family, as arrays (count, 3, 3), contact times, and names of families."""
    names = [name for name, _ in zip(_forever(), range(count), strict=False)]
    made = [FAMILIES[name](rng) for name in names]
    arrays = [np.array([query[k] for query in made]) for k in range(4)]
    return (*arrays, [query.when for query in made], names)


def _forever():
    while True:
        yield from FAMILIES
