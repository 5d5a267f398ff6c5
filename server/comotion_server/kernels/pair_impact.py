"""The contact time of two triangles on flights: proven steps, each by the best of many turning directions.

A hit is a gap that has come down to the target, to rounding, and closes; the target is positive, half the tolerance or
less, so contact times do not depend on where a query began. A gap within the tolerance that opens is no hit, and its
next step gets away (docs/time_of_impact.md, 4, 5).
"""

from math import sqrt
from typing import NamedTuple

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import relate, spins_over
from comotion_server.kernels.pair_impact_bounds import LEVEL, limits_of, moving_corners, safe_time
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, scaled, sub

FREE, HIT, STALLED = 0, 1, 2  # of a pair over a window

EXPLAINS = 1e-6  # relative: how much of the distance the gap along a normal must reach to be its direction
ROUNDING = 3e-14  # of the extent, the same absolutely: without it large faces take the noisy difference of points
SHARP = 1e-6  # relative: how near the target a gap counts as come down to it; steps close in on it from above
GRAIN = 1e-15  # of the extent, the same absolutely: what computing a gap may lose
SLANT = 1e-3  # cosine of the angle to an edge up to which rounding may have made the direction of two points slant
PAIR_STEPS = 2000  # of one pair over one window; more is a stall


class Touch(NamedTuple):
    """A contact at one time, in the axes of body a, from its centre."""

    gap: float  # [m]
    closing: float  # speed at which the gap closes [m/s]
    point_a: tuple[float, float, float]  # [m]
    point_b: tuple[float, float, float]
    normal: tuple[float, float, float]  # unit, from a to b


NO_TOUCH = Touch(0.0, 0.0, ZERO, ZERO, ZERO)


@lean_jit
def _wider(best, normal, least, c):
    """The better of `best`, (gap, direction), and that of a normal of any length above `least`."""
    size = length(normal)
    if not size > least:
        return best
    n = scaled(normal, 1.0 / size)
    a0, a1, a2 = dot(n, c.a[0]), dot(n, c.a[1]), dot(n, c.a[2])
    b0, b1, b2 = dot(n, c.b[0]), dot(n, c.b[1]), dot(n, c.b[2])
    gap = min(b0, b1, b2) - max(a0, a1, a2)
    if gap > best[0]:
        best = (gap, n)
    gap = min(a0, a1, a2) - max(b0, b1, b2)
    if gap > best[0]:
        best = (gap, scaled(n, -1.0))
    return best


@lean_jit
def _upright(n, e):
    """The direction n made normal to an edge e that it is nearly normal to; else nothing."""
    square, slope = dot(e, e), dot(n, e)
    return along(n, -slope / square, e) if slope * slope < SLANT * SLANT * square else ZERO


@lean_jit
def contact_normal(distance, n, c):
    """The separating axis of largest gap, which is right to rounding; if none explains the distance, n of the points.

    The largest gap over all directions *is* the distance, with one maximiser: a face normal or a product of edges.
    """
    a, b = c.a, c.b
    best = (0.0, n)
    best = _wider(best, cross(sub(a[1], a[0]), sub(a[2], a[0])), 0.0, c)
    best = _wider(best, cross(sub(b[1], b[0]), sub(b[2], b[0])), 0.0, c)
    for i in range(3):
        u = sub(a[(i + 1) % 3], a[i])
        for j in range(3):
            v = sub(b[(j + 1) % 3], b[j])
            best = _wider(best, cross(u, v), LEVEL * sqrt(dot(u, u) * dot(v, v)), c)
    extent = length(c.a[0]) + length(c.b[0])
    enough = distance * (1.0 - EXPLAINS) - ROUNDING * extent
    if best[0] < enough:  # a corner beside an edge in one plane, or two corners
        for i in range(3):
            best = _wider(best, _upright(n, sub(a[(i + 1) % 3], a[i])), 0.0, c)
            best = _wider(best, _upright(n, sub(b[(i + 1) % 3], b[i])), 0.0, c)
    return best[1] if best[0] >= enough else n


@lean_jit
def touch_of(distance, p, q, n, c, relative):
    """`Touch` of two triangles from their closest points."""
    n = contact_normal(distance, n, c)
    velocity_b = add(relative.velocity, cross(relative.spin_b, sub(q, relative.offset)))
    closing = dot(n, sub(cross(relative.spin_a, p), velocity_b))
    return Touch(distance, closing, p, q, n)


@lean_jit
def come_down(gap, target, extent):
    """Whether a gap is at its target, to rounding, or below it; extent: size of the coordinates it is found from."""
    return gap <= target * (1.0 + SHARP) + GRAIN * extent


@lean_jit
def pair_impact(flights, bodies, corners_a, arms_b, window, end, first, relative, spins, R, states, own_R):
    """The contact of two triangles in a window.

    corners_a, arms_b: their corners in their own bodies' axes; end: local time [s] until which to look; first:
    `triangle_points` at the window's beginning; relative, spins, R: the motion there, spins over the window; states,
    own_R: room for `relate`.
    Returns (FREE, HIT or STALLED, time, Touch, steps): apart until `end`, or a contact at `time` with a gap in
    (0, tolerance], or no step possible any more from `time`, until which they are apart.
    """
    now, steps = window.begin, 0
    distance, p, q, n = first
    spin_a, spin_b = spins
    while steps < PAIR_STEPS and distance > 0.0:
        c = moving_corners(relative, R, corners_a, arms_b)
        touch = NO_TOUCH
        if distance <= window.tolerance:
            touch = touch_of(distance, p, q, n, c, relative)
            n = touch.normal
        closes = touch.closing > window.still
        if closes and come_down(distance, window.target, length(c.a[0]) + length(c.b[0])):
            return HIT, now, touch, steps
        steps += 1
        horizon = end - now
        step = safe_time(n, c, limits_of(c, relative, spin_a, spin_b, horizon), window.target, horizon)
        if step >= horizon:
            return FREE, end, NO_TOUCH, steps
        if not now + step > now:
            if closes:
                return HIT, now, touch, steps
            break
        now += step
        relative = relate(flights, bodies, now, states, own_R)
        spin_a, spin_b = spins_over(flights, bodies, states, end - now)
        R = own_R
        c = moving_corners(relative, R, corners_a, arms_b)
        distance, p, q, n = triangle_points(c.a[0], c.a[1], c.a[2], c.b[0], c.b[1], c.b[2])
    return STALLED, now, NO_TOUCH, steps
