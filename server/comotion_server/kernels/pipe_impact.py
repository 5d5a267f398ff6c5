"""The contact time of a sphere with a pipe that does not turn (docs/spheres.md).

In the bore the wall is a circle in the plane across the axis, and closed ends are planes: closed forms. Everywhere else
(outside, at the rims) the distance is that of a point to a rectangle in the half plane (rho, z) through the axis, and
proven steps lead to the contact: it is convex but for rho'' = a_rho + v_t^2 / rho on the side of the axis, so over a
while it stays above gap + u s - K s^2 / 2, with K the largest |a| + v^2 / rho. Near a contact they converge as Newton's
steps do.

Legend: D, V, A offset, velocity and acceleration of the sphere's centre against the pipe's; e unit axis; all world.
"""

from math import inf, sqrt

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import covering_time, first_root
from comotion_server.kernels.polynomial_falls import fall_time
from comotion_server.kernels.solids import CAPS, HALF, INNER, OUTER
from comotion_server.kernels.vectors import add, along, dot, length, scaled

LEGS = 2000  # steps outside the bore; a dozen do unless the sphere grazes a rim
GRAIN = 2.0**-50  # of the extent: what computing a gap may lose
OVERLAP, STALL = -1.0, -2.0  # instead of a time


@lean_jit
def is_in_bore(size, e, D):
    """Whether a point lies in the bore."""
    z = dot(e, D)
    across = along(D, -z, e)
    return abs(z) <= size[HALF] and dot(across, across) < size[INNER] * size[INNER]


@lean_jit
def pipe_gap(size, e, D, r):
    """(gap [m], unit normal from the pipe to the sphere) of a sphere of radius r; in the wall minus its radius."""
    z = dot(e, D)
    across = along(D, -z, e)
    rho, inner = length(across), size[INNER]
    outward = scaled(across, 1.0 / rho) if rho > 0.0 else (0.0, 0.0, 0.0)
    beyond = abs(z) - size[HALF]
    up = e if z > 0.0 else scaled(e, -1.0)
    if size[CAPS] > 0.0:
        if beyond <= 0.0 and rho < inner:
            if -beyond < inner - rho:
                return -beyond - r, scaled(up, -1.0)
            return inner - rho - r, scaled(outward, -1.0)
        inner = 0.0
    beside = max(rho - size[OUTER], inner - rho, 0.0)
    outward = outward if rho > inner else scaled(outward, -1.0)
    if beyond <= 0.0:
        return beside - r, outward
    if beside == 0.0:
        return beyond - r, up
    far = sqrt(beside * beside + beyond * beyond)
    return far - r, add(scaled(outward, beside / far), scaled(up, beyond / far))


@lean_jit
def _ends_time(e, D, V, A, room, still, depth, horizon):
    """When the point is first as far along the axis as `room` [m], either way."""
    z, v, a = dot(e, D), dot(e, V), 0.5 * dot(e, A)
    top = fall_time((room - z, -v, -a, 0.0, 0.0), still, depth, horizon)
    bottom = fall_time((room + z, v, a, 0.0, 0.0), still, depth, horizon)
    return min(top, bottom)


@lean_jit
def bore_time(size, e, D, V, A, r, still, horizon):
    """When a sphere in the bore touches its wall; inf: not up to `horizon`, were the bore without ends."""
    room = size[INNER] - r
    d, v, a = along(D, -dot(e, D), e), along(V, -dot(e, V), e), along(A, -dot(e, A), e)
    rho = length(d)
    c = (
        (room - rho) * (room + rho),
        -2.0 * dot(d, v),
        -(dot(v, v) + dot(d, a)),
        -dot(v, a),
        -0.25 * dot(a, a),
    )
    s = fall_time(c, 2.0 * room * still, GRAIN * room * room, horizon)
    if 0.0 < s < inf and c[4] != 0.0:
        s = _polished(d, v, a, room, s)
    return s


@lean_jit
def _polished(d, v, a, room, s):
    """The time at which |d + v s + a s^2 / 2| = room, from one that is nearly right."""
    for _ in range(2):
        at = along(along(d, s, v), 0.5 * s * s, a)
        rho = length(at)
        speed = dot(at, along(v, s, a)) / rho
        change = (rho - room) / speed if speed != 0.0 else inf
        if not abs(change) < 1e-6 * s:
            break
        s -= change
    return s


@lean_jit
def _outside_step(size, e, D, V, A, r, gap, n):
    """How long [s] the sphere surely stays off the pipe."""
    speed, pull, opening = length(V), length(A), dot(n, V)
    surely = covering_time(gap, speed, pull)
    z = dot(e, D)
    rho = length(along(D, -z, e))
    if rho >= size[INNER] or size[CAPS] > 0.0:
        return max(surely, first_root(max(gap, 0.0), opening, -pull))
    hull = abs(z) - size[HALF] - r
    if hull > 0.0:
        surely = max(surely, first_root(hull, dot(e, V) if z > 0.0 else -dot(e, V), -pull))
    while_ = covering_time(0.5 * rho, speed, pull)
    if while_ < inf:
        fastest = speed + pull * while_
        bend = pull + fastest * fastest / (0.5 * rho) if rho > 0.0 else inf
        if bend < inf:
            surely = max(surely, min(while_, first_root(max(gap, 0.0), opening, -bend)))
    return surely


@lean_jit
def pipe_time(size, e, D, V, A, r, still, tolerance, horizon):
    """When a sphere of radius r touches a pipe: s >= 0, inf (not up to `horizon`), OVERLAP or STALL."""
    gap, _ = pipe_gap(size, e, D, r)
    if gap < -tolerance:
        return OVERLAP
    passed, inside = 0.0, is_in_bore(size, e, D)
    grain = GRAIN * (length(D) + size[OUTER] + size[HALF])
    for _ in range(LEGS):
        left = horizon - passed
        if inside:
            if size[CAPS] > 0.0:
                room = size[HALF] - r
                wall = bore_time(size, e, D, V, A, r, still, left)
                return passed + min(wall, _ends_time(e, D, V, A, room, still, grain, left))
            leaves = _ends_time(e, D, V, A, size[HALF], 0.0, grain, left)
            s = bore_time(size, e, D, V, A, r, still, min(left, leaves))
            if s <= leaves:
                return passed + s
            step = leaves
        else:
            gap, n = pipe_gap(size, e, D, r)
            if gap <= grain and dot(n, V) < -still:
                return passed
            step = _outside_step(size, e, D, V, A, r, gap, n)
            if not passed + step > passed:
                return passed if gap <= tolerance and dot(n, V) < -still else STALL
        if not passed + step < horizon:
            return inf
        D, V, passed = along(along(D, step, V), 0.5 * step * step, A), along(V, step, A), passed + step
        inside = not inside and is_in_bore(size, e, D) and dot(e, D) * dot(e, V) < 0.0
    return STALL
