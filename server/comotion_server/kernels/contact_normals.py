"""The directions along which two meshes touch: one for every patch of contact.

Of each pair of triangles within reach it is the separating axis of largest gap, the normal of a face wherever that
explains the distance. It counts where both closest points are local tops of their bodies along it (the normal cones of
Johnson and Willemsen, Haptics Symposium 2004): else the triangles merely neighbour those that touch.
"""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.contacts import FULL
from comotion_server.kernels.features import EDGE, feature_at
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.level_faces import is_level, is_top
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.mesh_room import Directions
from comotion_server.kernels.pair_impact import EXPLAINS, ROUNDING, contact_normal
from comotion_server.kernels.pair_impact_bounds import Points, Vector
from comotion_server.kernels.vectors import add, along, dot, length, rotated, rotated_back, row, scaled, sub, unit

PATCHES_AT_FIRST = 256
OF_A, OF_B, OF_NONE = 0, 1, 2  # whose face gives a direction


class TwoTriangles(NamedTuple):
    """A triangle of each body in the axes of a, from its centre."""

    a: Points
    b: Points


class Nearest(NamedTuple):
    """The closest points of two triangles, in the axes of a."""

    distance: float  # [m]
    p: Vector  # on a [m]
    q: Vector  # on b
    n: Vector  # unit, from a to b
    i: int  # triangle of a
    j: int  # triangle of b


@jit
def new_directions():
    """Room for the directions of two bodies."""
    return Directions(
        np.empty((PATCHES_AT_FIRST, 3)),
        np.empty((PATCHES_AT_FIRST, 3)),
        np.empty(PATCHES_AT_FIRST, np.int64),
        np.empty(PATCHES_AT_FIRST, np.int64),
        np.empty(PATCHES_AT_FIRST),
    )


@lean_jit
def _three_points(vertices, triangles, t):
    return row(vertices, triangles[t, 0]), row(vertices, triangles[t, 1]), row(vertices, triangles[t, 2])


@lean_jit
def two_triangles(vertices, triangles, i, j, R, t):
    """`TwoTriangles` i of a and j of b; R, t turn points of b's frame into a's."""
    b0, b1, b2 = _three_points(vertices, triangles, j)
    b = (add(rotated(R, b0), t), add(rotated(R, b1), t), add(rotated(R, b2), t))
    return TwoTriangles(_three_points(vertices, triangles, i), b)


@lean_jit
def gap_along(n, c):
    """Gap [m] of two triangles along n, negative where it does not separate them."""
    a, b = c.a, c.b
    return min(dot(n, b[0]), dot(n, b[1]), dot(n, b[2])) - max(dot(n, a[0]), dot(n, a[1]), dot(n, a[2]))


@lean_jit
def explained_by(distance, c):
    """The gap along a direction that is enough to explain the distance [m] of two triangles."""
    return distance * (1.0 - EXPLAINS) - ROUNDING * (length(c.a[0]) + length(c.b[0]))


@lean_jit
def _upright(m, shape, t, p, n):
    """The direction n, in the body's axes, made normal to the edge of triangle t that p lies on, if it lies on one."""
    feature, k = feature_at(m, shape, t, p)
    if feature != EDGE:
        return n
    points = corners(m, t)
    e = unit(sub(points[(k + 1) % 3], points[k]))
    return unit(along(n, -dot(n, e), e))


@lean_jit
def direction_of(m, shape_a, shape_b, R, t, pair, c):
    """(direction, whose face gives it) of a pair of triangles within reach, `Nearest` and `TwoTriangles`."""
    enough = explained_by(pair.distance, c)
    n = row(m.normals, pair.i)
    if gap_along(n, c) >= enough:
        return n, OF_A
    n = scaled(rotated(R, row(m.normals, pair.j)), -1.0)
    if gap_along(n, c) >= enough:
        return n, OF_B
    n = contact_normal(pair.distance, pair.n, c)
    n = _upright(m, shape_a, pair.i, pair.p, n)
    q = rotated_back(R, sub(pair.q, t))
    return rotated(R, _upright(m, shape_b, pair.j, q, rotated_back(R, n))), OF_NONE


@lean_jit
def are_tops(m, shape_a, shape_b, R, t, pair, n, slope):
    """Whether the closest points of two triangles are tops of their bodies along n."""
    if not is_top(m, shape_a, pair.i, pair.p, n, slope):
        return False
    return is_top(m, shape_b, pair.j, rotated_back(R, sub(pair.q, t)), scaled(rotated_back(R, n), -1.0), slope)


@lean_jit
def note_direction(R, pair, n, owner, slope, directions, count):
    """Put a direction among those found, in the place of one alike if that is worse; how many, or FULL.

    Faces give better ones than closest points, whose rounding counts as much as they are near; then the nearer pair.
    slope: sine below which two directions are one.
    """
    place, least = count, pair.distance
    for d in range(count):
        if is_level(row(directions.normal, d), n, slope):
            of_faces, before = owner != OF_NONE, directions.owner[d] != OF_NONE
            if before > of_faces or (before == of_faces and pair.distance >= directions.least[d]):
                return count
            place, least = d, min(least, directions.least[d])
            break
    if place == len(directions.least):
        return FULL
    directions.normal[place], directions.normal_b[place] = n, scaled(rotated_back(R, n), -1.0)
    directions.owner[place], directions.least[place] = owner, least
    directions.triangle[place] = pair.i if owner == OF_A else pair.j
    return max(count, place + 1)
