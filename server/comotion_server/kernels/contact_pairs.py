"""All pairs of triangles of two meshes within a distance, and the directions of contact: one walk down both trees.

Once a direction is known most pairs need no distance of their own: along it they are too far apart, or the corner of
one that is nearest along it lies over a level face of the other, so that the gap along it *is* the distance.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.boxes import box_gap, divides_a, highest
from comotion_server.kernels.contact_normals import (
    Nearest,
    are_tops,
    direction_of,
    explained_by,
    gap_along,
    note_direction,
    two_triangles,
)
from comotion_server.kernels.contact_overlap import lies_over
from comotion_server.kernels.contacts import FULL
from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.level_faces import is_level
from comotion_server.kernels.triangle_distance import closer_points
from comotion_server.kernels.vectors import ZERO, cross, dot, row, sub

PAIRS_AT_FIRST = 32768
NEAR, FAR, UNKNOWN = 0, 1, 2  # what a direction says of two triangles


class Tree(NamedTuple):
    """What of `MeshArrays` a walk asks: few arrays, because each one costs time at every call."""

    centre: np.ndarray
    axes: np.ndarray
    half: np.ndarray
    child: np.ndarray
    first: np.ndarray
    entries: np.ndarray
    leaf_triangles: np.ndarray


@jit
def tree_of(m):
    """`Tree` of `MeshArrays`."""
    return Tree(m.centre, m.axes, m.half, m.child, m.first, m.entries, m.leaf_triangles)


@lean_jit
def _top(points, n):
    """The corner that reaches farthest along n."""
    top = points[0]
    if dot(n, points[1]) > dot(n, top):
        top = points[1]
    if dot(n, points[2]) > dot(n, top):
        top = points[2]
    return top


@lean_jit
def _are_beside(ones, others, n, limit):
    """Whether an edge of one triangle, looking along n, keeps the other aside by more than `limit` [m]."""
    for k in range(3):
        u = sub(ones[(k + 1) % 3], ones[k])
        across = cross(u, n)
        low = min(dot(across, ones[0]), dot(across, ones[1]), dot(across, ones[2]))
        high = max(dot(across, ones[0]), dot(across, ones[1]), dot(across, ones[2]))
        least = min(dot(across, others[0]), dot(across, others[1]), dot(across, others[2]))
        most = max(dot(across, others[0]), dot(across, others[1]), dot(across, others[2]))
        apart = max(least - high, low - most)
        if apart > 0.0 and apart * apart > limit * limit * dot(u, u):
            return True
    return False


@lean_jit
def _judged(n, level_a, level_b, c, limit):
    """What the direction n, along which two triangles have a gap of at most `limit` [m], says of them."""
    back = (-n[0], -n[1], -n[2])
    if (level_b and lies_over(_top(c.a, n), c.b, back, 0.0)) or (level_a and lies_over(_top(c.b, back), c.a, n, 0.0)):
        return NEAR
    if (level_a or level_b) and (_are_beside(c.a, c.b, n, limit) or _are_beside(c.b, c.a, n, limit)):
        return FAR
    return UNKNOWN


@lean_jit
def _what_is_known(normals, normal, normal_b, least, i, j, c, slope, limit, found):
    """What the directions found so far say of triangles i and j; arrays as in `Surface` and `Directions`."""
    answer, d = UNKNOWN, 0
    while d < found and answer == UNKNOWN:
        n = row(normal, d)
        gap = gap_along(n, c)
        if gap > limit:
            answer = FAR
        elif gap > 0.0:
            level_a = is_level(row(normals, i), n, slope)
            level_b = is_level(row(normals, j), row(normal_b, d), slope)
            answer = _judged(n, level_a, level_b, c, limit)
            if answer == NEAR:
                least[d] = min(least[d], gap)
        d += 1
    return answer


@lean_jit
def _is_explained(distance, c, normal, found):
    """Whether a direction found so far explains the distance of two triangles."""
    enough, d = explained_by(distance, c), 0
    while d < found and gap_along(row(normal, d), c) < enough:
        d += 1
    return d < found


@lean_jit
def _nearest_points(i, j, c, limit):
    """`Nearest` of two triangles."""
    distance, p, q, n = closer_points(limit, c.a[0], c.a[1], c.a[2], c.b[0], c.b[1], c.b[2])
    return Nearest(distance, p, q, n, i, j)


@lean_jit
def _surely_nearest(m, shape_a, shape_b, R, t, slope, directions, state):
    """Add the direction of the nearest pair of all: no rounding can leave bodies in contact without one."""
    count, found, nearest = state
    for d in range(found):
        if directions.least[d] <= nearest.distance:
            return count, found
    if nearest.distance < inf:
        c = two_triangles(m.vertices, m.triangles, nearest.i, nearest.j, R, t)
        n, owner = direction_of(m, shape_a, shape_b, R, t, nearest, c)
        found = note_direction(R, nearest, n, owner, slope, directions, found)
    return count, found


@lean_jit
def _compare(m, shape_a, shape_b, leaf_a, leaf_b, tree, R, t, reach, limit, slope, pairs, directions, state):
    """(number of pairs, of directions, nearest pair without a direction) after all pairs of two leaves."""
    count, found, nearest = state
    vertices, triangles, order = m.vertices, m.triangles, tree.leaf_triangles
    normal, normal_b, least = directions.normal, directions.normal_b, directions.least
    for k in range(tree.first[leaf_a], tree.first[leaf_a] + tree.entries[leaf_a]):
        for l in range(tree.first[leaf_b], tree.first[leaf_b] + tree.entries[leaf_b]):
            i, j = order[k], order[l]
            c = two_triangles(vertices, triangles, i, j, R, t)
            answer = _what_is_known(m.normals, normal, normal_b, least, i, j, c, slope, limit, found)
            if answer == UNKNOWN:
                pair = _nearest_points(i, j, c, limit)
                answer = NEAR if pair.distance <= limit else FAR
                if 0.0 < pair.distance <= reach and not _is_explained(pair.distance, c, normal, found):
                    n, owner = direction_of(m, shape_a, shape_b, R, t, pair, c)
                    if are_tops(m, shape_a, shape_b, R, t, pair, n, slope):
                        found = note_direction(R, pair, n, owner, slope, directions, found)
                    elif pair.distance < nearest.distance:
                        nearest = pair
            if answer == NEAR:
                if count == len(pairs) or found == FULL:
                    return FULL, FULL, nearest
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return count, found, nearest


@lean_jit
def touching_pairs(m, tree, shape_a, shape_b, roots, R, t, reach, limit, slope, nodes, pairs, directions):
    """(number of pairs, of directions): pairs of triangles within `limit` [m], directions of those within `reach`.

    m, tree: `Surface`, `Tree`; roots: of both trees; R (3, 3) and t turn points of b's frame into a's; slope: sine
    below which directions are alike; nodes (STACK_SIZE, 2) int64. Out: pairs (p, 2) int64 of a, of b, over all
    shapes; directions. Both numbers are FULL where there is no room.
    """
    top, none = 1, np.int64(0)  # of the type it will have: else what it goes to is compiled twice
    state = (none, none, Nearest(inf, ZERO, ZERO, ZERO, none, none))
    nodes[0, 0], nodes[0, 1] = roots
    while top > 0:
        top -= 1
        node_a, node_b = nodes[top, 0], nodes[top, 1]
        if state[1] > 0:
            n, n_b = row(directions.normal, 0), row(directions.normal_b, 0)
            if dot(n, t) - highest(tree, node_b, n_b) - highest(tree, node_a, n) > limit:
                continue
        if box_gap(tree, node_a, node_b, R, t, limit) > limit:
            continue
        if tree.child[node_a] < 0 and tree.child[node_b] < 0:
            state = _compare(
                m, shape_a, shape_b, node_a, node_b, tree, R, t, reach, limit, slope, pairs, directions, state
            )
            if state[0] == FULL:
                return FULL, FULL
        elif divides_a(tree, node_a, node_b):
            nodes[top, 0], nodes[top, 1] = tree.child[node_a], node_b
            nodes[top + 1, 0], nodes[top + 1, 1] = tree.child[node_a] + 1, node_b
            top += 2
        else:
            nodes[top, 0], nodes[top, 1] = node_a, tree.child[node_b]
            nodes[top + 1, 0], nodes[top + 1, 1] = node_a, tree.child[node_b] + 1
            top += 2
    return _surely_nearest(m, shape_a, shape_b, R, t, slope, directions, state)


@jit
def new_pairs():
    """Room for the pairs of any two meshes, and for a walk."""
    return np.empty((PAIRS_AT_FIRST, 2), np.int64), np.empty((STACK_SIZE, 2), np.int64)
