"""Proven lower bounds of the distance of two nodes' oriented boxes.

R (3, 3) and t turn points y of body b's frame into body a's: R y + t.
"""

from math import inf, sqrt

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import add, dot, rotated, row, sub

PARALLEL = 1e-6  # squared sine of two box axes below which their cross product is not used


@lean_jit
def _radius_along(m, node, n):
    return (
        m.half[node, 0] * abs(m.axes[node, 0, 0] * n[0] + m.axes[node, 0, 1] * n[1] + m.axes[node, 0, 2] * n[2])
        + m.half[node, 1] * abs(m.axes[node, 1, 0] * n[0] + m.axes[node, 1, 1] * n[1] + m.axes[node, 1, 2] * n[2])
        + m.half[node, 2] * abs(m.axes[node, 2, 0] * n[0] + m.axes[node, 2, 1] * n[1] + m.axes[node, 2, 2] * n[2])
    )


@lean_jit
def highest(m, node, n):
    """The most that n . x reaches in a node's box, n in the body's frame."""
    return dot(row(m.centre, node), n) + _radius_along(m, node, n)


@lean_jit
def lowest(m, node, n):
    """The least that n . x reaches in a node's box, n in the body's frame."""
    return dot(row(m.centre, node), n) - _radius_along(m, node, n)


@lean_jit
def divides_a(m, node_a, node_b):
    """Whether a walk goes on with the children of node a rather than those of node b: the larger one, if it has any."""
    if m.child[node_a] < 0 or m.child[node_b] < 0:
        return m.child[node_a] >= 0
    size_a = m.half[node_a, 0] + m.half[node_a, 1] + m.half[node_a, 2]
    return size_a >= m.half[node_b, 0] + m.half[node_b, 1] + m.half[node_b, 2]


@lean_jit
def _edges_gap(c1, c2, a1, a2, b1, b2, m1, m2, k1, k2, m):
    """Gap along the cross product of one axis of each box: the arguments are those of the two other axes."""
    squared = 1.0 - m * m
    if squared < PARALLEL:
        return -inf
    return (abs(c2 * m1 - c1 * m2) - a1 * abs(m2) - a2 * abs(m1) - b1 * abs(k2) - b2 * abs(k1)) / sqrt(squared)


@lean_jit
def _outside(x, y, z):
    """Distance that the gaps along three orthogonal axes prove."""
    x, y, z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
    return sqrt(x * x + y * y + z * z)


@lean_jit
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
