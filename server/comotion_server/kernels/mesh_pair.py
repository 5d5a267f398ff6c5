"""P6: the distance of two meshes and its closest points, by a walk down both trees of boxes.

Everything is computed in the frame of body a, with the relative pose taken from the difference of the positions, so a
scene far from the world's origin keeps its digits. The walk starts from an upper bound (the last witness pair, or a
first descent) and drops every pair of nodes whose proven lower bound is not below it. The cheapest bound comes first:
for *any* unit vector n the boxes are at least n . (c_b - c_a) - r_a(n) - r_b(n) apart; n is the direction of the best
pair so far. Only what passes is tested on the fifteen separating axes of two boxes.

Legend: R (3, 3) and t turn points y of body b's frame into body a's: R y + t. `best` is (distance, point on a, point on
b, unit direction from a to b, triangle of a, triangle of b), all in body a's frame.
"""

from math import inf, sqrt

import numpy as np

from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.jit import jit
from comotion_server.kernels.triangle_distance import closer_points, triangle_points
from comotion_server.kernels.vectors import add, along, dot, rotated, rotated_back, row, sub, unit

SLACK = (
    2e-15  # of the bodies' sizes: rounding of a bound; the features around a vertex all have its distance, up to this
)
PARALLEL = 1e-6  # squared sine of two box axes below which their cross product is not used


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
def _radius_along(m, node, n):
    return (
        m.half[node, 0] * abs(m.axes[node, 0, 0] * n[0] + m.axes[node, 0, 1] * n[1] + m.axes[node, 0, 2] * n[2])
        + m.half[node, 1] * abs(m.axes[node, 1, 0] * n[0] + m.axes[node, 1, 1] * n[1] + m.axes[node, 1, 2] * n[2])
        + m.half[node, 2] * abs(m.axes[node, 2, 0] * n[0] + m.axes[node, 2, 1] * n[1] + m.axes[node, 2, 2] * n[2])
    )


@jit
def _gap_along(m, node_a, node_b, n, n_b, n_t):
    """Gap of two boxes along the unit vector n (body a's frame), n_b = R^T n, n_t = n . t."""
    centres = dot(row(m.centre, node_b), n_b) + n_t - dot(row(m.centre, node_a), n)
    return centres - _radius_along(m, node_a, n) - _radius_along(m, node_b, n_b)


@jit
def _edges_gap(c1, c2, a1, a2, b1, b2, m1, m2, k1, k2, m):
    """Gap along the cross product of one axis of each box: the arguments are those of the two other axes."""
    squared = 1.0 - m * m
    if squared < PARALLEL:
        return -inf
    return (abs(c2 * m1 - c1 * m2) - a1 * abs(m2) - a2 * abs(m1) - b1 * abs(k2) - b2 * abs(k1)) / sqrt(squared)


@jit
def _outside(x, y, z):
    """Distance that the gaps along three orthogonal axes prove."""
    x, y, z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
    return sqrt(x * x + y * y + z * z)


@jit
def box_gap(m, node_a, node_b, R, t, enough):
    """A proven lower bound of the distance of two boxes, as good as it gets or at least `enough` [m]."""
    c = sub(add(rotated(R, row(m.centre, node_b)), t), row(m.centre, node_a))
    ax, ay, az = row(m.axes[node_a], 0), row(m.axes[node_a], 1), row(m.axes[node_a], 2)
    bx, by, bz = (
        rotated(R, row(m.axes[node_b], 0)),
        rotated(R, row(m.axes[node_b], 1)),
        rotated(R, row(m.axes[node_b], 2)),
    )
    xx, xy, xz = dot(ax, bx), dot(ax, by), dot(ax, bz)
    yx, yy, yz = dot(ay, bx), dot(ay, by), dot(ay, bz)
    zx, zy, zz = dot(az, bx), dot(az, by), dot(az, bz)
    p, q, r = m.half[node_a, 0], m.half[node_a, 1], m.half[node_a, 2]
    u, v, w = m.half[node_b, 0], m.half[node_b, 1], m.half[node_b, 2]
    cx, cy, cz = dot(ax, c), dot(ay, c), dot(az, c)
    gap = _outside(
        abs(cx) - p - u * abs(xx) - v * abs(xy) - w * abs(xz),
        abs(cy) - q - u * abs(yx) - v * abs(yy) - w * abs(yz),
        abs(cz) - r - u * abs(zx) - v * abs(zy) - w * abs(zz),
    )
    if gap >= enough:
        return gap
    other = _outside(
        abs(dot(bx, c)) - u - p * abs(xx) - q * abs(yx) - r * abs(zx),
        abs(dot(by, c)) - v - p * abs(xy) - q * abs(yy) - r * abs(zy),
        abs(dot(bz, c)) - w - p * abs(xz) - q * abs(yz) - r * abs(zz),
    )
    gap = max(gap, other)
    if gap >= enough:
        return gap
    gap = max(
        gap,
        _edges_gap(cy, cz, q, r, v, w, yx, zx, xy, xz, xx),
        _edges_gap(cy, cz, q, r, w, u, yy, zy, xz, xx, xy),
        _edges_gap(cy, cz, q, r, u, v, yz, zz, xx, xy, xz),
    )
    if gap >= enough:
        return gap
    gap = max(
        gap,
        _edges_gap(cz, cx, r, p, v, w, zx, xx, yy, yz, yx),
        _edges_gap(cz, cx, r, p, w, u, zy, xy, yz, yx, yy),
        _edges_gap(cz, cx, r, p, u, v, zz, xz, yx, yy, yz),
    )
    if gap >= enough:
        return gap
    return max(
        gap,
        _edges_gap(cx, cy, p, q, v, w, xx, yx, zy, zz, zx),
        _edges_gap(cx, cy, p, q, w, u, xy, yy, zz, zx, zy),
        _edges_gap(cx, cy, p, q, u, v, xz, yz, zx, zy, zz),
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
def divides_a(m, node_a, node_b):
    """Whether a walk goes on with the children of node a rather than those of node b: the larger one, if it has any."""
    if m.child[node_a] < 0 or m.child[node_b] < 0:
        return m.child[node_a] >= 0
    size_a = m.half[node_a, 0] + m.half[node_a, 1] + m.half[node_a, 2]
    return size_a >= m.half[node_b, 0] + m.half[node_b, 1] + m.half[node_b, 2]


@jit
def _first_pair(m, node_a, node_b, R, t):
    """`best` of the triangle pair that a descent along the centres finds: the first upper bound."""
    n = unit(sub(add(rotated(R, row(m.centre, node_b)), t), row(m.centre, node_a)))
    n_b, n_t = rotated_back(R, n), dot(n, t)
    while m.child[node_a] >= 0 or m.child[node_b] >= 0:
        if divides_a(m, node_a, node_b):
            one = m.child[node_a]
            nearer = _gap_along(m, one, node_b, n, n_b, n_t) <= _gap_along(m, one + 1, node_b, n, n_b, n_t)
            node_a = one if nearer else one + 1
        else:
            one = m.child[node_b]
            nearer = _gap_along(m, node_a, one, n, n_b, n_t) <= _gap_along(m, node_a, one + 1, n, n_b, n_t)
            node_b = one if nearer else one + 1
    return _triangle_pair(m, m.leaf_triangles[m.first[node_a]], m.leaf_triangles[m.first[node_b]], R, t)


@jit
def _worth(reach, slack, distance):
    """What a bound must be below to be worth a look: the reach, or clearly below the best distance so far."""
    return min(reach, max(distance - slack, 0.5 * distance))


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
                if distance == 0.0:
                    return lower, best
    return lower, best


@jit
def closest_points(m, shape_a, shape_b, R, t, reach, witness_a, witness_b, stack, bounds):
    """`best` of two meshes, exact if its distance is below `reach` [m].

    Otherwise the distance is a proven lower bound, at least `reach`, and points and triangles are those of a pair seen
    on the way. witness_a, witness_b: a triangle pair to begin with (indices over all shapes; -1: none). stack
    (STACK_SIZE, 2) int64 and bounds (STACK_SIZE,) are work space. A distance 0 ends the walk: the triangles intersect.
    """
    root_a, root_b = m.root[shape_a], m.root[shape_b]
    if witness_a >= 0 and witness_b >= 0:
        best = _triangle_pair(m, witness_a, witness_b, R, t)
    else:
        best = _first_pair(m, root_a, root_b, R, t)
    lower = inf
    n = best[3]
    n_b, n_t = rotated_back(R, n), dot(n, t)
    slack = SLACK * (m.size[shape_a] + m.size[shape_b])
    limit = _worth(reach, slack, best[0])
    top, stale = 0, 0  # entries below `stale` have bounds of an earlier direction
    if best[0] > 0.0:
        stack[0, 0], stack[0, 1], bounds[0] = root_a, root_b, _gap_along(m, root_a, root_b, n, n_b, n_t)
        top = 1
    while top > 0:
        top -= 1
        node_a, node_b, bound = stack[top, 0], stack[top, 1], bounds[top]
        if top < stale:
            stale = top
            if bound < limit:
                bound = max(bound, _gap_along(m, node_a, node_b, n, n_b, n_t))
        if bound < limit:
            bound = max(bound, box_gap(m, node_a, node_b, R, t, limit))
        if bound >= limit:
            lower = min(lower, bound)
        elif m.child[node_a] < 0 and m.child[node_b] < 0:
            before = best[0]
            lower, best = _leaf_pair(m, node_a, node_b, R, t, reach, slack, lower, best)
            if best[0] == 0.0:
                return best
            if best[0] < before:
                n = best[3]
                n_b, n_t = rotated_back(R, n), dot(n, t)
                limit, stale = _worth(reach, slack, best[0]), top
        else:
            top = _push_children(m, node_a, node_b, n, n_b, n_t, bound, stack, bounds, top)
    if best[0] < reach:
        return best
    return min(best[0], lower), best[1], best[2], best[3], best[4], best[5]


@jit
def _push_children(m, node_a, node_b, n, n_b, n_t, bound, stack, bounds, top):
    """Put the two children pairs on the stack, the nearer one on top; the new height of the stack."""
    a, b = node_a, node_b
    c, d = node_a, node_b
    if divides_a(m, node_a, node_b):
        a, c = m.child[node_a], m.child[node_a] + 1
    else:
        b, d = m.child[node_b], m.child[node_b] + 1
    near = _gap_along(m, a, b, n, n_b, n_t)
    far = _gap_along(m, c, d, n, n_b, n_t)
    if near > far:
        a, b, c, d = c, d, a, b
        near, far = far, near
    stack[top, 0], stack[top, 1], bounds[top] = c, d, max(far, bound)
    stack[top + 1, 0], stack[top + 1, 1], bounds[top + 1] = a, b, max(near, bound)
    return top + 2


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
    stack, bounds, R = np.empty((STACK_SIZE, 2), np.int64), np.empty(STACK_SIZE), np.empty((3, 3))
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        shape_a, shape_b = shape_of_body[a], shape_of_body[b]
        start_a, start_b = m.triangle_start[shape_a], m.triangle_start[shape_b]
        relative_rotation(rotations[a], rotations[b], R)
        t = rotated_back(rotations[a], sub(row(positions, b), row(positions, a)))
        known = witness[k, 0] >= 0 and witness[k, 1] >= 0
        witness_a = start_a + witness[k, 0] if known else -1
        witness_b = start_b + witness[k, 1] if known else -1
        d, p, q, n, i, j = closest_points(m, shape_a, shape_b, R, t, reach[k], witness_a, witness_b, stack, bounds)
        distance[k] = d
        point_a[k] = along(row(positions, a), 1.0, rotated(rotations[a], p))
        point_b[k] = along(row(positions, a), 1.0, rotated(rotations[a], q))
        normal[k] = rotated(rotations[a], n)
        witness[k, 0], witness[k, 1] = i - start_a, j - start_b
