"""How long a direction surely keeps two triangles apart (docs/time_of_impact.md, 3 to 5).

For corners a_i, b_j and a direction n(s) that turns on a great circle, n(0) = n, n'(0) = m normal to n, the gaps
f_ij(s) = n(s) . D, D = b_j(s) - a_i(s), have the derivatives at s = 0
  f0 = n.D,  f1 = n.D' + m.D,  f2 = n.D'' + 2 m.D' - m^2 f0,  and a third one of at most J over a window of length h,
so f_ij(s) >= f0 + f1 s + (f2 - J h / 3) s^2 / 2 there. While all nine are positive the triangles are apart. The safe
time is the first at which one of them could come down to the target gap g*; a gap that is already below it and grows
may come back to where it is (the escape), and one that shrinks may be halved.
"""

from math import inf, sqrt
from typing import NamedTuple

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import Spin, first_root
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, rotated, scaled, sub, unit

LEVEL = 1e-12  # sine of the angle of two edges below which their product is no direction
UPRIGHT = 0.1  # cosine below which a direction may have been meant to be normal to an edge
WORTH = 0.2  # of the target: a direction along which the gap is smaller does not count, it might be rounding alone
AHEAD = 1.5  # times the first guess of a safe time: the window that it is then proven for

Vector = tuple[float, float, float]
Points = tuple[Vector, Vector, Vector]


class Corners(NamedTuple):
    """Two triangles at one time, in the axes of body a, from its centre."""

    a: Points  # corners of a [m]
    b: Points  # corners of b [m]
    velocity_a: Points  # of the corners of a, against the centre of a [m/s]
    velocity_b: Points  # of the corners of b, likewise
    bend_a: Points  # accelerations of the corners of a, likewise [m/s2]
    bend_b: Points


class Limits(NamedTuple):
    """Bounds over a window of how two triangles' corners move against each other."""

    spin_a: Spin
    spin_b: Spin
    jerk_a: float  # third derivative of the corners of a about its centre [m/s3]
    jerk_b: float
    acceleration: float  # |D''| [m/s2]
    speed: float  # |D'| [m/s]
    extent: float  # |D| [m]


@lean_jit
def _lever(spin, r0, r1, r2):
    """Largest distance [m] of three corners from the axis or, where the axis moves, from the centre."""
    if spin.fixed == 0:
        return max(length(r0), length(r1), length(r2))
    u = spin.axis
    return max(length(cross(u, r0)), length(cross(u, r1)), length(cross(u, r2)))


@lean_jit
def _bend(w, change, r, velocity):
    """Acceleration of a corner about the centre: w' x r + w x (w x r)."""
    return add(cross(change, r), cross(w, velocity))


@lean_jit
def moving_corners(relative, R, corners_a, arms_b):
    """`Corners` of a triangle of a, and of one of b given by its corners in b's own axes."""
    a0, a1, a2 = corners_a
    b0, b1, b2 = rotated(R, arms_b[0]), rotated(R, arms_b[1]), rotated(R, arms_b[2])
    wa, wb, v, x = relative.spin_a, relative.spin_b, relative.velocity, relative.offset
    va0, va1, va2 = cross(wa, a0), cross(wa, a1), cross(wa, a2)
    vb0, vb1, vb2 = cross(wb, b0), cross(wb, b1), cross(wb, b2)
    change_a, change_b, pull = relative.change_a, relative.change_b, relative.acceleration
    return Corners(
        (a0, a1, a2),
        (add(b0, x), add(b1, x), add(b2, x)),
        (va0, va1, va2),
        (add(v, vb0), add(v, vb1), add(v, vb2)),
        (_bend(wa, change_a, a0, va0), _bend(wa, change_a, a1, va1), _bend(wa, change_a, a2, va2)),
        (
            add(pull, _bend(wb, change_b, b0, vb0)),
            add(pull, _bend(wb, change_b, b1, vb1)),
            add(pull, _bend(wb, change_b, b2, vb2)),
        ),
    )


@lean_jit
def unit_jerk(spin):
    """Bound of the third derivative of a point at unit distance: |w''| + 3 |w'| |w| + |w|^3."""
    return spin.jolt + spin.rate * (3.0 * spin.change + spin.rate * spin.rate)


@lean_jit
def limits_of(c, relative, spin_a, spin_b, horizon):
    """`Limits` of two triangles over the next `horizon` [s]."""
    x = relative.offset
    lever_a = _lever(spin_a, c.a[0], c.a[1], c.a[2])
    lever_b = _lever(spin_b, sub(c.b[0], x), sub(c.b[1], x), sub(c.b[2], x))
    extent, speed = 0.0, 0.0
    for i in range(3):
        for j in range(3):
            D, V = sub(c.b[j], c.a[i]), sub(c.velocity_b[j], c.velocity_a[i])
            extent, speed = max(extent, dot(D, D)), max(speed, dot(V, V))
    acceleration = length(relative.acceleration) + (spin_a.change + spin_a.rate * spin_a.rate) * lever_a
    acceleration += (spin_b.change + spin_b.rate * spin_b.rate) * lever_b
    speed = sqrt(speed) + acceleration * horizon
    extent = sqrt(extent) + speed * horizon
    return Limits(spin_a, spin_b, unit_jerk(spin_a) * lever_a, unit_jerk(spin_b) * lever_b, acceleration, speed, extent)


@lean_jit
def across(spin, n):
    """Length of the part of n that a rotation can move: all of it, or what is normal to a fixed axis."""
    if spin.fixed == 0:
        return 1.0
    along_axis = dot(spin.axis, n)
    return sqrt(max(1.0 - along_axis * along_axis, 0.0))


@lean_jit
def _third(n, m, limits):
    """The bound J of the third derivatives of all f_ij over the window [m/s3]."""
    turning = length(m)
    if turning == 0.0:
        return across(limits.spin_a, n) * limits.jerk_a + across(limits.spin_b, n) * limits.jerk_b
    inner = 3.0 * limits.acceleration + turning * (3.0 * limits.speed + turning * limits.extent)
    return limits.jerk_a + limits.jerk_b + turning * inner


@lean_jit
def _line(n, m, turning, point, velocity, bend):
    """The part of a corner in (f0, f1, f2)."""
    height = dot(n, point)
    return height, dot(n, velocity) + dot(m, point), dot(n, bend) + 2.0 * dot(m, velocity) - turning * height


@lean_jit
def _pair_time(a, b, less, target):
    """Safe time of one pair of corners: down to the target, back to the present gap, or to half of it."""
    f0, f1, k = b[0] - a[0], b[1] - a[1], b[2] - a[2] - less
    if f0 > target:
        return first_root(f0 - target, f1, k)
    if f1 > 0.0:
        return first_root(0.0, f1, k)
    return first_root(0.5 * f0, f1, k)


@lean_jit
def _all_pairs_time(lines_a, lines_b, less, target):
    """The least safe time of all nine, their second derivatives taken as smaller by `less`."""
    safe = inf
    for a in lines_a:
        for b in lines_b:
            safe = min(safe, _pair_time(a, b, less, target))
    return safe


@lean_jit
def _at(line, s):
    return line[0] + s * line[1]


@lean_jit
def direction_time(n, m, c, limits, target, horizon):
    """For how long [s] the direction n, turning at the rate m, keeps two triangles apart; at most `horizon`.

    n: unit vector in the axes of a; its sense is chosen here. Zero where it does not separate them clearly.
    """
    gap = min(dot(n, c.b[0]), dot(n, c.b[1]), dot(n, c.b[2])) - max(dot(n, c.a[0]), dot(n, c.a[1]), dot(n, c.a[2]))
    least = WORTH * target
    if gap <= least:
        n, m = scaled(n, -1.0), scaled(m, -1.0)
        gap = min(dot(n, c.b[0]), dot(n, c.b[1]), dot(n, c.b[2])) - max(dot(n, c.a[0]), dot(n, c.a[1]), dot(n, c.a[2]))
        if gap <= least:
            return 0.0
    turning = dot(m, m)
    a0 = _line(n, m, turning, c.a[0], c.velocity_a[0], c.bend_a[0])
    a1 = _line(n, m, turning, c.a[1], c.velocity_a[1], c.bend_a[1])
    a2 = _line(n, m, turning, c.a[2], c.velocity_a[2], c.bend_a[2])
    b0 = _line(n, m, turning, c.b[0], c.velocity_b[0], c.bend_b[0])
    b1 = _line(n, m, turning, c.b[1], c.velocity_b[1], c.bend_b[1])
    b2 = _line(n, m, turning, c.b[2], c.velocity_b[2], c.bend_b[2])
    third = _third(n, m, limits) / 3.0
    if gap >= target:
        k = min(min(b0[2], b1[2], b2[2]) - max(a0[2], a1[2], a2[2]) - third * horizon, 0.0)
        later = min(_at(b0, horizon), _at(b1, horizon), _at(b2, horizon))
        later -= max(_at(a0, horizon), _at(a1, horizon), _at(a2, horizon))
        if later + 0.5 * k * horizon * horizon >= target:
            return horizon  # bounds that are concave and end above the target
    lines_a, lines_b = (a0, a1, a2), (b0, b1, b2)
    window = min(horizon, AHEAD * _all_pairs_time(lines_a, lines_b, 0.0, target))
    return min(window, _all_pairs_time(lines_a, lines_b, third * window, target))


@lean_jit
def _product_time(u, v, du, dv, least, c, limits, target, horizon):
    """Of the product of two edges u, v that change at the rates du, dv, turning with it, and fixed.

    Nothing where the sine between the edges is not above `least`.
    """
    normal = cross(u, v)
    size = length(normal)
    if not size > least * sqrt(dot(u, u) * dot(v, v)):
        return 0.0
    n = scaled(normal, 1.0 / size)
    change = scaled(add(cross(du, v), cross(u, dv)), 1.0 / size)
    safe = direction_time(n, along(change, -dot(n, change), n), c, limits, target, horizon)
    if safe < horizon:
        safe = max(safe, direction_time(n, ZERO, c, limits, target, horizon))
    return safe


@lean_jit
def _face_time(points, velocities, c, limits, target, horizon):
    """Of the normal of a face."""
    u, v = sub(points[1], points[0]), sub(points[2], points[0])
    du, dv = sub(velocities[1], velocities[0]), sub(velocities[2], velocities[0])
    return _product_time(u, v, du, dv, 0.0, c, limits, target, horizon)


@lean_jit
def _beside_time(n, points, velocities, c, limits, target, horizon):
    """Of the direction n made normal to an edge of one triangle, and turning so that it stays so.

    It is what keeps a corner beside an edge: of coplanar triangles neither face nor product of edges does. The
    direction between two points as close as the tolerance has lost digits, which an edge's length brings to light.
    """
    safe = 0.0
    for i in range(3):
        e, de = sub(points[(i + 1) % 3], points[i]), sub(velocities[(i + 1) % 3], velocities[i])
        square, slope = dot(e, e), dot(n, e)
        if square > 0.0 and slope * slope <= UPRIGHT * UPRIGHT * square:
            upright = along(n, -slope / square, e)
            upright = unit(along(upright, -dot(upright, e) / square, e))
            change = scaled(e, -dot(upright, de) / square)
            m = along(change, -dot(upright, change), upright)
            safe = max(safe, direction_time(upright, m, c, limits, target, horizon))
    return safe


@lean_jit
def safe_time(n, c, limits, target, horizon):
    """The best of many directions: how long [s] two triangles are surely apart, at most `horizon`.

    n: the direction between their closest points. Tried are n fixed, the face normals, the nine products of edges, and
    n turning with an edge.
    """
    safe = direction_time(n, ZERO, c, limits, target, horizon)
    if safe < horizon:
        safe = max(safe, _face_time(c.a, c.velocity_a, c, limits, target, horizon))
    if safe < horizon:
        safe = max(safe, _face_time(c.b, c.velocity_b, c, limits, target, horizon))
    for i in range(3):
        u, du = sub(c.a[(i + 1) % 3], c.a[i]), sub(c.velocity_a[(i + 1) % 3], c.velocity_a[i])
        for j in range(3):
            if safe >= horizon:
                return safe
            v, dv = sub(c.b[(j + 1) % 3], c.b[j]), sub(c.velocity_b[(j + 1) % 3], c.velocity_b[j])
            safe = max(safe, _product_time(u, v, du, dv, LEVEL, c, limits, target, horizon))
    if safe < horizon:
        safe = max(safe, _beside_time(n, c.a, c.velocity_a, c, limits, target, horizon))
        safe = max(safe, _beside_time(n, c.b, c.velocity_b, c, limits, target, horizon))
    return safe
