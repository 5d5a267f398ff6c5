"""A segment against a pipe, and a cylinder inside a closed one.

The inside of a closed pipe is convex, and the distance from its wall is concave there: an end of the segment is
nearest. From outside, a closed pipe is a solid cylinder. An open pipe is neither. What is nearest to a segment is then,
on the segment: an end of it; where it passes through the plane of an end of the pipe; where it is nearest to the axis;
or where it is nearest to one of the four rims. At each of these the distance is known, and the least is taken.

Nearest to a rim of radius R at height Z: half the slope of the squared distance along P + t M is
    M . (P + t M - Z u) - R b'^2 (t - t0) / rho,    rho^2 = b^2 + b'^2 (t - t0)^2,
with b the distance of the line from the axis, at t0, and b' the part of M across it. It falls only where
rho^3 < R b'^2 b^2 / M^2, about t0: on either side of that there is at most one place of least distance (Eberly 2021,
Robust and Error-Bounded Distance of a Line and a Circle, found the same structure).

Legend: u axis, P a point and M a segment's half length as a vector, from the pipe's centre [m]; the segment is P + t M
with t in [-1, 1].
"""

from math import inf, sqrt

from comotion_server.kernels.curved_kinds import CAPS, HALF, INNER, OUTER
from comotion_server.kernels.curved_points import (
    cavity_depth,
    cylinder_distance,
    is_in_bore,
    part_across,
    pipe_distance,
    profile,
    some_perpendicular,
)
from comotion_server.kernels.curved_search import NARROW, TURNS, between, lowest_on_segment
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, scaled, unit


@lean_jit
def _clamped(t):
    return min(max(t, -1.0), 1.0)


@lean_jit
def nearest_to_axis(u, P, M):
    """The parameter at which the segment is nearest to the axis; its middle if it is everywhere."""
    A, B = along(P, -dot(u, P), u), along(M, -dot(u, M), u)
    bb = dot(B, B)
    return _clamped(-dot(A, B) / bb) if bb > 1e-30 * dot(M, M) else 0.0


@lean_jit
def _rim_slope(R, Z, u, P, M, t):
    z, rho, outward = profile(u, along(P, t, M))
    return (rho - R) * dot(outward, M) + (z - Z) * dot(u, M)


@lean_jit
def _lowest_to_rim(R, Z, u, P, M, lo, hi):
    """Where between lo and hi a rim is nearest, the slope of the distance growing."""
    f_lo, f_hi = _rim_slope(R, Z, u, P, M, lo), _rim_slope(R, Z, u, P, M, hi)
    if f_lo >= 0.0:
        return lo
    if f_hi <= 0.0:
        return hi
    side = 0
    for turn in range(TURNS):
        if hi - lo <= NARROW:
            break
        t = between(lo, f_lo, hi, f_hi, turn)
        f = _rim_slope(R, Z, u, P, M, t)
        if f == 0.0:
            return t
        if f < 0.0:
            lo, f_lo, f_hi, side = t, f, 0.5 * f_hi if side < 0 else f_hi, -1
        else:
            hi, f_hi, f_lo, side = t, f, 0.5 * f_lo if side > 0 else f_lo, 1
    return 0.5 * (lo + hi)


@lean_jit
def _nearest_to_rim(R, Z, u, P, M):
    """Both parameters at which a rim may be nearest to the segment."""
    A, B = along(P, -dot(u, P), u), along(M, -dot(u, M), u)
    bb, mm = dot(B, B), dot(M, M)
    if bb == 0.0:
        t = _clamped((Z - dot(u, P)) / dot(u, M)) if mm > 0.0 else 0.0
        return t, t
    t0 = -dot(A, B) / bb
    b = length(along(A, t0, B))
    turn = b * (R * bb / (b * mm)) ** (1.0 / 3.0) if b > 0.0 else 0.0
    aside = sqrt((turn - b) * (turn + b) / bb) if turn > b else 0.0
    left, right = _clamped(t0 - aside), _clamped(t0 + aside)
    return _lowest_to_rim(R, Z, u, P, M, -1.0, left), _lowest_to_rim(R, Z, u, P, M, right, 1.0)


@lean_jit
def _between_ends(h, u, P, M):
    """(lo, hi) of the parameters between the planes of the pipe's ends; lo > hi: none."""
    z, rise = dot(u, P), dot(u, M)
    if rise == 0.0:
        return (-1.0, 1.0) if abs(z) <= h else (1.0, -1.0)
    t, s = (-h - z) / rise, (h - z) / rise
    return max(min(t, s), -1.0), min(max(t, s), 1.0)


@lean_jit
def meets_wall(size, u, P, M):
    """Whether the segment passes through the wall of an open pipe."""
    lo, hi = _between_ends(size[HALF], u, P, M)
    if lo > hi:
        return False
    t = min(max(nearest_to_axis(u, P, M), lo), hi)
    far = max(profile(u, along(P, lo, M))[1], profile(u, along(P, hi, M))[1])
    return far > size[INNER] and profile(u, along(P, t, M))[1] < size[OUTER]


@lean_jit
def _better(best, size, u, P, M, t):
    distance, n = pipe_distance(size, u, along(P, t, M))
    return (distance, t, n) if distance < best[0] else best


@lean_jit
def open_pipe_segment(size, u, P, M):
    """(distance, parameter, normal from the pipe) of what is nearest to an open pipe; 0 or less where it meets it."""
    best = _better((inf, 0.0, ZERO), size, u, P, M, 0.0)
    if M == ZERO:
        return best
    h = size[HALF]
    best = _better(_better(best, size, u, P, M, -1.0), size, u, P, M, 1.0)
    best = _better(best, size, u, P, M, nearest_to_axis(u, P, M))
    lo, hi = _between_ends(h, u, P, M)
    if lo <= hi:
        best = _better(_better(best, size, u, P, M, lo), size, u, P, M, hi)
    for R, Z in ((size[INNER], h), (size[INNER], -h), (size[OUTER], h), (size[OUTER], -h)):
        left, right = _nearest_to_rim(R, Z, u, P, M)
        best = _better(_better(best, size, u, P, M, left), size, u, P, M, right)
    if meets_wall(size, u, P, M):
        return min(best[0], 0.0), best[1], best[2]
    return best


@lean_jit
def pipe_segment(size, u, P, M):
    """As `open_pipe_segment`, for any pipe; a segment whose middle is in a closed bore is inside."""
    if size[CAPS] == 0.0:
        return open_pipe_segment(size, u, P, M)
    if not is_in_bore(size, u, P):
        t = lowest_on_segment(size[OUTER], size[HALF], u, P, M, -1.0, 1.0)
        distance, n = cylinder_distance(size[OUTER], size[HALF], u, along(P, t, M))
        return distance, t, n
    depth, n = cavity_depth(size[INNER], size[HALF], u, P)
    best = depth - 1e-15 * size[INNER], 0.0, n  # a segment along the wall touches in its middle
    for t in (-1.0, 1.0):
        at_end, n = cavity_depth(size[INNER], size[HALF], u, along(P, t, M))
        if at_end < best[0]:
            best = at_end, t, n
    return (depth, best[1], best[2]) if best[1] == 0.0 else best


@lean_jit
def farthest_of_rim(u, c, r, v):
    """The point farthest from the axis u on the circle of radius r about c, normal to v.

    Across u the circle is an ellipse with the half axes r, along u x v, and r |u . v|; the point lies in the quadrant
    that its middle lies in, where (its slope over sin cos) only falls.
    """
    e1 = unit(part_across(cross(u, v), v))
    if e1 == ZERO:
        _, _, outward = profile(u, c)
        return along(c, r, outward if outward != ZERO else some_perpendicular(u))
    e2 = cross(v, e1)
    flat = along(e2, -dot(e2, u), u)
    squeeze = length(flat)
    x, y = dot(c, e1), dot(c, flat) / squeeze if squeeze > 0.0 else 0.0
    p, q, bulge = abs(x), abs(y) * squeeze, r * (1.0 - squeeze) * (1.0 + squeeze)
    lo, hi = 0.0, sqrt(0.5)  # of the sine on the first half of the quadrant, of the cosine on the other
    steep = hi * (q - p) - 0.5 * bulge > 0.0
    for _ in range(TURNS):
        k = 0.5 * (lo + hi)
        if hi - lo <= NARROW * hi or k in (lo, hi):
            break
        other = sqrt((1.0 - k) * (1.0 + k))
        sine, cosine = (other, k) if steep else (k, other)
        grows = q * cosine - p * sine - bulge * sine * cosine > 0.0
        if grows == steep:
            hi = k
        else:
            lo = k
    k = 0.5 * (lo + hi)
    other = sqrt((1.0 - k) * (1.0 + k))
    sine, cosine = (other, k) if steep else (k, other)
    side_1, side_2 = -1.0 if x < 0.0 else 1.0, -1.0 if y < 0.0 else 1.0
    return add(along(c, r * cosine * side_1, e1), scaled(e2, r * sine * side_2))


@lean_jit
def cylinder_in_bore(size, u, r, h, v, C):
    """(signed distance, point of the cylinder, normal from the pipe to it) of a cylinder about C in a closed pipe."""
    best = inf, ZERO, ZERO
    rise = dot(u, v)
    across = along(v, -rise, u)  # a disc's lowest and highest points along u
    tilt = length(cross(u, v))
    for end in (-1.0, 1.0):
        c = along(C, end * h, v)
        rim = farthest_of_rim(u, c, r, v)
        depth, n = cavity_depth(size[INNER], inf, u, rim)
        if depth < best[0]:
            best = depth, rim, n
        for side in (-1.0, 1.0):
            down = along(scaled(u, side), -side * rise, v)
            P = along(c, r / length(down), down) if tilt > 4e-16 and across != ZERO else c
            depth = size[HALF] - side * dot(u, P)
            if depth < best[0]:
                best = depth, P, scaled(u, -side)
    return best
