"""P6: the distance of two meshes and its closest points, by a walk down both trees of boxes.

Everything is computed in the frame of body a, with the relative pose taken from the difference of the positions, so a
scene far from the world's origin keeps its digits. The walk starts from an upper bound (the last witness pair, or a
first descent) and drops every pair of nodes whose proven lower bound is not below it. The cheapest bound comes first:
for *any* unit vector n the boxes are at least n . (c_b - c_a) - r_a(n) - r_b(n) apart; n is the direction of the best
pair so far. Only what passes is tested on the fifteen separating axes of two boxes.

Legend: R (3, 3) and t turn points y of body b's frame into body a's: R y + t. `best` is (distance, point on a, point on
b, unit direction from a to b, triangle of a, triangle of b), all in body a's frame.
"""

from math import inf

import numpy as np

from comotion_server.kernels.boxes import box_gap, divides_a, highest, lowest
from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.jit import jit
from comotion_server.kernels.triangle_distance import closer_points, triangle_points
from comotion_server.kernels.vectors import ZERO, add, along, dot, rotated, rotated_back, row, scaled, sub, unit

GAP, HIGH, LOW = 0, 1, 2  # of a pair on the stack: its bound; the most of n . x in a's box, the least in b's
DESCENTS = 4  # tries to better the first pair; each costs about as much as two pairs of triangles
SLACK = 2e-15  # of the bodies' sizes: rounding of a bound or a distance; surfaces nearer than this touch


@jit
def relative_rotation(rotation_a, rotation_b, R):
    """R = rotation_a^T rotation_b: from body b's frame to body a's."""
    for i in range(3):
        for j in range(3):
            R[i, j] = (
                rotation_a[0, i] * rotation_b[0, j]
                + rotation_a[1, i] * rotation_b[1, j]
                + rotation_a[2, i] * rotation_b[2, j]
            )


@jit
def corners(m, triangle):
    """The three corners of a triangle in its body's frame."""
    return (
        row(m.vertices, m.triangles[triangle, 0]),
        row(m.vertices, m.triangles[triangle, 1]),
        row(m.vertices, m.triangles[triangle, 2]),
    )


@jit
def corners_moved(m, triangle, R, t):
    """The three corners of a triangle of body b in body a's frame."""
    a, b, c = corners(m, triangle)
    return add(rotated(R, a), t), add(rotated(R, b), t), add(rotated(R, c), t)


@jit
def _triangle_pair(m, triangle_a, triangle_b, R, t):
    """`best` of one pair of triangles."""
    a0, a1, a2 = corners(m, triangle_a)
    b0, b1, b2 = corners_moved(m, triangle_b, R, t)
    distance, p, q, n = triangle_points(a0, a1, a2, b0, b1, b2)
    return distance, p, q, n, triangle_a, triangle_b


@jit
def _descent(m, node_a, node_b, n, R, t):
    """`best` of one triangle pair of the leaves that lie farthest towards each other along n."""
    n_b = rotated_back(R, n)
    while m.child[node_a] >= 0 or m.child[node_b] >= 0:
        if divides_a(m, node_a, node_b):
            one = m.child[node_a]
            node_a = one if highest(m, one, n) >= highest(m, one + 1, n) else one + 1
        else:
            one = m.child[node_b]
            node_b = one if lowest(m, one, n_b) <= lowest(m, one + 1, n_b) else one + 1
    return _triangle_pair(m, m.leaf_triangles[m.first[node_a]], m.leaf_triangles[m.first[node_b]], R, t)


@jit
def _first_pair(m, root_a, root_b, R, t):
    """`best` of a triangle pair to start from: by descents along the centres' and then along the found directions."""
    best = _descent(
        m, root_a, root_b, unit(sub(add(rotated(R, row(m.centre, root_b)), t), row(m.centre, root_a))), R, t
    )
    for _ in range(DESCENTS):
        other = _descent(m, root_a, root_b, best[3], R, t)
        if not other[0] < best[0]:
            break
        best = other
    return best


@jit
def _worth(reach, slack, distance):
    """What a bound must be below to be worth a look: the reach, or clearly below the best distance so far."""
    return min(reach, max(distance - slack, 0.5 * distance))


@jit
def _touching(best):
    """`best` of surfaces that meet, to rounding: distance 0 and one common point; not a number stays what it is."""
    middle = scaled(add(best[1], best[2]), 0.5)
    return 0.0 * best[0], middle, middle, ZERO, best[4], best[5]


@jit
def _leaf_pair(m, node_a, node_b, R, t, reach, slack, lower, best):
    """(lower bound of what was passed over, best) after all triangle pairs of two leaves."""
    for j in range(m.first[node_b], m.first[node_b] + m.entries[node_b]):
        b0, b1, b2 = corners_moved(m, m.leaf_triangles[j], R, t)
        for i in range(m.first[node_a], m.first[node_a] + m.entries[node_a]):
            a0, a1, a2 = corners(m, m.leaf_triangles[i])
            n, limit = best[3], _worth(reach, slack, best[0])
            gap = min(dot(n, b0), dot(n, b1), dot(n, b2)) - max(dot(n, a0), dot(n, a1), dot(n, a2))
            if gap >= limit:
                lower = min(lower, gap)
                continue
            distance, p, q, n = closer_points(limit, a0, a1, a2, b0, b1, b2)
            if distance == inf:
                lower = min(lower, limit)
            if distance < best[0]:
                best = (distance, p, q, n, m.leaf_triangles[i], m.leaf_triangles[j])
                if distance <= slack:
                    return lower, best
    return lower, best


@jit
def closest_points(m, shape_a, shape_b, R, t, reach, witness_a, witness_b, nodes, bounds):
    """`best` of two meshes, exact if its distance is below `reach` [m].

    Otherwise the distance is a proven lower bound, at least `reach`, and points and triangles are those of a pair seen
    on the way. witness_a, witness_b: a triangle pair to begin with (indices over all shapes; -1: none). Work space:
    nodes (STACK_SIZE, 2) int64 and bounds (STACK_SIZE, 3). A distance 0 ends the walk: the triangles intersect.
    """
    root_a, root_b = m.root[shape_a], m.root[shape_b]
    if witness_a >= 0 and witness_b >= 0:
        best = _triangle_pair(m, witness_a, witness_b, R, t)
    else:
        best = _first_pair(m, root_a, root_b, R, t)
    slack = SLACK * (m.size[shape_a] + m.size[shape_b])
    if not best[0] > slack:
        return _touching(best)
    limit = _worth(reach, slack, best[0])
    nodes[0, 0], nodes[0, 1], bounds[0, GAP] = root_a, root_b, -inf
    lower, top, stale = inf, 1, 1
    n = best[3]
    n_b, n_t = rotated_back(R, n), dot(n, t)
    while top > 0:
        top -= 1
        node_a, node_b = nodes[top, 0], nodes[top, 1]
        if top < stale:  # these bounds are of an earlier direction
            stale = top
            high, low = highest(m, node_a, n), lowest(m, node_b, n_b) + n_t
            bounds[top, HIGH], bounds[top, LOW], bounds[top, GAP] = high, low, max(bounds[top, GAP], low - high)
        bound = bounds[top, GAP]
        if bound < limit:
            bound = max(bound, box_gap(m, node_a, node_b, R, t, limit))
        if bound >= limit:
            lower = min(lower, bound)
        elif m.child[node_a] < 0 and m.child[node_b] < 0:
            before = best[0]
            lower, best = _leaf_pair(m, node_a, node_b, R, t, reach, slack, lower, best)
            if best[0] <= slack:
                return _touching(best)
            if best[0] < before:
                n = best[3]
                n_b, n_t = rotated_back(R, n), dot(n, t)
                limit, stale = _worth(reach, slack, best[0]), top
        else:
            top, lower = _push_children(m, node_a, node_b, n, n_b, n_t, bound, limit, lower, nodes, bounds, top)
    if best[0] < reach:
        return best
    return min(best[0], lower), best[1], best[2], best[3], best[4], best[5]


@jit
def _push(node_a, node_b, bound, high, low, limit, lower, nodes, bounds, top):
    """Put a pair of nodes on the stack unless its bound is beyond the limit; (height of the stack, lower)."""
    bound = max(bound, low - high)
    if bound >= limit:
        return top, min(lower, bound)
    nodes[top, 0], nodes[top, 1] = node_a, node_b
    bounds[top, GAP], bounds[top, HIGH], bounds[top, LOW] = bound, high, low
    return top + 1, lower


@jit
def _push_children(m, node_a, node_b, n, n_b, n_t, bound, limit, lower, nodes, bounds, top):
    """Put the pairs that the larger node's children form on the stack, the nearer on top; (height, lower)."""
    high, low = bounds[top, HIGH], bounds[top, LOW]
    if divides_a(m, node_a, node_b):
        one, two = m.child[node_a], m.child[node_a] + 1
        high_one, high_two = highest(m, one, n), highest(m, two, n)
        if high_one > high_two:
            one, two, high_one, high_two = two, one, high_two, high_one
        top, lower = _push(one, node_b, bound, high_one, low, limit, lower, nodes, bounds, top)
        return _push(two, node_b, bound, high_two, low, limit, lower, nodes, bounds, top)
    one, two = m.child[node_b], m.child[node_b] + 1
    low_one, low_two = lowest(m, one, n_b) + n_t, lowest(m, two, n_b) + n_t
    if low_one < low_two:
        one, two, low_one, low_two = two, one, low_two, low_one
    top, lower = _push(node_a, one, bound, high, low_one, limit, lower, nodes, bounds, top)
    return _push(node_a, two, bound, high, low_two, limit, lower, nodes, bounds, top)


@jit
def closest_points_of_pairs(
    m, shape_of_body, positions, rotations, pairs, reach, witness, distance, point_a, point_b, normal
):
    """Distance and closest points of many pairs of bodies (P6).

    m: MeshArrays; shape_of_body (bodies,) int64; positions (bodies, 3) [m]; rotations (bodies, 3, 3) body to world;
    pairs (k, 2) int64 body indices; reach (k,) [m]: the result is exact if the distance is below it (inf: always).
    In and out: witness (k, 2) int64, the triangle (index within its shape) of either body that holds its closest
    point; the walk starts from it; -1 where there is none yet.
    Out: distance (k,) [m], exactly 0 if and only if the surfaces intersect (P7), then the witness is a pair of
    triangles that does; where the distance is not below reach, a proven lower bound of it, not below reach either;
    point_a, point_b (k, 3) world [m]; normal (k, 3) world, unit vector from a to b, zero for distance 0. Beyond reach
    points, normal and witness belong to some pair of triangles, good to start from.
    """
    nodes, bounds, R = np.empty((STACK_SIZE, 2), np.int64), np.empty((STACK_SIZE, 3)), np.empty((3, 3))
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        shape_a, shape_b = shape_of_body[a], shape_of_body[b]
        start_a, start_b = m.triangle_start[shape_a], m.triangle_start[shape_b]
        relative_rotation(rotations[a], rotations[b], R)
        t = rotated_back(rotations[a], sub(row(positions, b), row(positions, a)))
        known = witness[k, 0] >= 0 and witness[k, 1] >= 0
        witness_a = start_a + witness[k, 0] if known else -1
        witness_b = start_b + witness[k, 1] if known else -1
        d, p, q, n, i, j = closest_points(m, shape_a, shape_b, R, t, reach[k], witness_a, witness_b, nodes, bounds)
        distance[k] = d
        point_a[k] = along(row(positions, a), 1.0, rotated(rotations[a], p))
        point_b[k] = along(row(positions, a), 1.0, rotated(rotations[a], q))
        normal[k] = rotated(rotations[a], n)
        witness[k, 0], witness[k, 1] = i - start_a, j - start_b
