"""The directions along which two meshes touch: one for every patch of contact.

Of each pair of triangles within reach it is the separating axis of largest gap, the normal of a face wherever that
explains the distance. It counts where both closest points are local tops of their bodies along it (the normal cones of
Johnson and Willemsen, Haptics Symposium 2004): else the triangles merely neighbour those that touch.
"""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.contact_pairs import FULL
from comotion_server.kernels.features import EDGE, feature_at
from comotion_server.kernels.jit import jit
from comotion_server.kernels.level_faces import is_level, is_top
from comotion_server.kernels.mesh_pair import corners, corners_moved
from comotion_server.kernels.pair_impact import EXPLAINS, ROUNDING, contact_normal
from comotion_server.kernels.pair_impact_bounds import Points
from comotion_server.kernels.vectors import along, dot, length, rotated, rotated_back, row, scaled, sub, unit

MOST_PATCHES = 256
OF_A, OF_B, OF_NONE = 0, 1, 2  # whose face gives a direction


class TwoTriangles(NamedTuple):
    """A triangle of each body in the axes of a, from its centre."""

    a: Points
    b: Points


class Directions(NamedTuple):
    """Directions of contact in the axes of a."""

    normal: np.ndarray  # (d,3) unit, from a to b
    owner: np.ndarray  # (d,) int64 OF_A, OF_B or OF_NONE
    triangle: np.ndarray  # (d,) int64 with that normal; of the owner
    least: np.ndarray  # (d,) least distance of a pair with this direction [m]


@jit
def new_directions():
    """Room for the directions of two bodies."""
    return Directions(
        np.empty((MOST_PATCHES, 3)),
        np.empty(MOST_PATCHES, np.int64),
        np.empty(MOST_PATCHES, np.int64),
        np.empty(MOST_PATCHES),
    )


@jit
def two_triangles(m, i, j, R, t):
    """`TwoTriangles` i of a and j of b."""
    return TwoTriangles(corners(m, i), corners_moved(m, j, R, t))


@jit
def gap_along(n, c):
    """Gap [m] of two triangles along n, negative where it does not separate them."""
    a, b = c.a, c.b
    return min(dot(n, b[0]), dot(n, b[1]), dot(n, b[2])) - max(dot(n, a[0]), dot(n, a[1]), dot(n, a[2]))


@jit
def _upright(m, shape, t, p, n):
    """The direction n, in the body's axes, made normal to the edge of triangle t that p lies on, if it lies on one."""
    feature, k = feature_at(m, shape, t, p)
    if feature != EDGE:
        return n
    points = corners(m, t)
    e = unit(sub(points[(k + 1) % 3], points[k]))
    return unit(along(n, -dot(n, e), e))


@jit
def _direction(m, shape_a, shape_b, i, j, R, t, near, k, c):
    """(normal, owner) of pair k of `near`, triangles i and j."""
    distance = near.distance[k]
    enough = distance * (1.0 - EXPLAINS) - ROUNDING * (length(c.a[0]) + length(c.b[0]))
    n = row(m.normals, i)
    if gap_along(n, c) >= enough:
        return n, OF_A
    n = scaled(rotated(R, row(m.normals, j)), -1.0)
    if gap_along(n, c) >= enough:
        return n, OF_B
    n = contact_normal(distance, row(near.direction, k), c)
    n = _upright(m, shape_a, i, row(near.point_a, k), n)
    q = rotated_back(R, sub(row(near.point_b, k), t))
    return rotated(R, _upright(m, shape_b, j, q, rotated_back(R, n))), OF_NONE


@jit
def _are_tops(m, shape_a, shape_b, i, j, R, t, p, q, n, slope):
    """Whether the closest points p, q of two triangles are tops of their bodies along n."""
    if not is_top(m, shape_a, i, p, n, slope):
        return False
    return is_top(m, shape_b, j, rotated_back(R, sub(q, t)), scaled(rotated_back(R, n), -1.0), slope)


@jit
def _note(directions, count, distance, n, owner, triangle, slope):
    """Put a direction among those found, in the place of one alike if that was found farther off; how many, or FULL."""
    place = count
    for d in range(count):
        if is_level(row(directions.normal, d), n, slope):
            if distance >= directions.least[d]:
                return count
            place = d
            break
    if place == MOST_PATCHES:
        return FULL
    directions.normal[place], directions.owner[place] = n, owner
    directions.triangle[place], directions.least[place] = triangle, distance
    return max(count, place + 1)


@jit
def contact_directions(m, shape_a, shape_b, R, t, reach, slope, near, pairs, directions):
    """How many directions of contact two meshes have; they are written to `directions`; or FULL.

    reach [m] of the pairs, the first `pairs` of `near`, that count; slope: sine below which two directions are one. The
    nearest pair of all always counts: no rounding can leave bodies in contact without one.
    """
    nearest, count = 0, 0
    for k in range(pairs):
        if near.distance[k] < near.distance[nearest]:
            nearest = k
    for turn in range(pairs):
        k = nearest if turn == 0 else 0 if turn == nearest else turn
        distance = near.distance[k]
        if not 0.0 < distance <= reach:
            continue
        i, j = near.triangles[k, 0], near.triangles[k, 1]
        c = two_triangles(m, i, j, R, t)
        enough = distance * (1.0 - EXPLAINS) - ROUNDING * (length(c.a[0]) + length(c.b[0]))
        known = False
        for d in range(count):
            known = known or gap_along(row(directions.normal, d), c) >= enough
        if known:
            continue
        n, owner = _direction(m, shape_a, shape_b, i, j, R, t, near, k, c)
        p, q = row(near.point_a, k), row(near.point_b, k)
        if turn > 0 and not _are_tops(m, shape_a, shape_b, i, j, R, t, p, q, n, slope):
            continue
        count = _note(directions, count, distance, n, owner, i if owner == OF_A else j, slope)
        if count == FULL:
            return FULL
    return count
