"""A triangle against each curved shape, which is about the origin.

Legend: u axis; a, b, c corners of the triangle from the shape's centre [m]. Results are (signed distance, point of the
triangle, unit normal from the shape to it); at most 0 where they meet.
"""

from math import inf, sqrt

from comotion_server.kernels.curved_bore import open_pipe_segment
from comotion_server.kernels.curved_cores import crossing_normal
from comotion_server.kernels.curved_kinds import (
    CAPSULE,
    CYLINDER,
    HALF,
    HALF_LENGTH,
    INNER,
    OUTER,
    PIPE,
    PLANE,
    RADIUS,
    SPHERE,
)
from comotion_server.kernels.curved_points import cavity_depth, cylinder_distance, pipe_distance, some_perpendicular
from comotion_server.kernels.curved_search import lowest_on_triangle
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.triangle_distance import triangle_normal, triangle_points
from comotion_server.kernels.vectors import ZERO, along, cross, dot, length, scaled, sub, unit

CAVITY = 6  # a kind besides those of `curved_kinds`: the inside of a closed pipe


@lean_jit
def point_distance(kind, size, u, P):
    """(signed distance, unit normal from the shape) of a point."""
    if kind == PLANE:
        return dot(u, P), u
    if kind == CYLINDER:
        return cylinder_distance(size[RADIUS], size[HALF_LENGTH], u, P)
    if kind == PIPE:
        return pipe_distance(size, u, P)
    if kind == CAVITY:
        return cavity_depth(size[INNER], size[HALF], u, P)
    h = size[HALF_LENGTH] if kind == CAPSULE else 0.0
    way = along(P, -min(max(dot(u, P), -h), h), u)
    return length(way) - size[RADIUS], unit(way)


@lean_jit
def _round_and_triangle(r, M, a, b, c):
    """A sphere or capsule, M half its segment."""
    far, p, P, n = triangle_points(scaled(M, -1.0), M, M, a, b, c)
    if far == 0.0:
        normal = unit(triangle_normal(sub(b, a), sub(c, a)))
        n = normal if normal != ZERO else crossing_normal(M, sub(b, a))
        P = p
    return far - r, P, n


@lean_jit
def _lowest_corner(kind, size, u, a, b, c):
    """Of a plane, or from inside a closed pipe: a corner is nearest."""
    far, n = point_distance(kind, size, u, a)
    best = far, a, n
    for P in (b, c):
        far, n = point_distance(kind, size, u, P)
        if far < best[0]:
            best = far, P, n
    return best


@lean_jit
def _holds(N, a, b, c, P):
    """Whether the foot of a point in the plane of a triangle lies in it."""
    return (
        dot(cross(sub(b, a), sub(P, a)), N) >= 0.0
        and dot(cross(sub(c, b), sub(P, b)), N) >= 0.0
        and dot(cross(sub(a, c), sub(P, c)), N) >= 0.0
    )


@lean_jit
def _rim_meets(R, Z, u, e, N, a, b, c):
    """Whether a rim passes through a triangle; e: the direction across u in which the plane falls most."""
    fall = R * dot(N, e)
    if fall == 0.0:
        return False
    k = (dot(N, a) - Z * dot(N, u)) / fall
    if abs(k) > 1.0:
        return False
    foot, aside = along(scaled(u, Z), R * k, e), scaled(cross(u, e), R * sqrt((1.0 - k) * (1.0 + k)))
    return _holds(N, a, b, c, along(foot, 1.0, aside)) or _holds(N, a, b, c, along(foot, -1.0, aside))


@lean_jit
def _line_meets(size, u, e, N, a, b, c):
    """Whether a straight line on the outer wall passes through a triangle."""
    foot, rise = scaled(e, size[OUTER]), dot(N, u)
    if rise == 0.0:
        return False
    z = dot(N, sub(a, foot)) / rise
    return abs(z) <= size[HALF] and _holds(N, a, b, c, along(foot, z, u))


@lean_jit
def _open_pipe_and_triangle(size, u, a, b, c):
    """An open pipe: its distance from the edges, and from the inside of the triangle that of its rims."""
    best = inf, a, ZERO
    for P, Q in ((a, b), (b, c), (c, a)):
        M = scaled(sub(Q, P), 0.5)
        middle = along(P, 1.0, M)
        far, t, n = open_pipe_segment(size, u, middle, M)
        if far < best[0]:
            best = far, along(middle, t, M), n
    N = unit(triangle_normal(sub(b, a), sub(c, a)))
    if N == ZERO:
        return best
    across = along(N, -dot(N, u), u)
    e = unit(across) if dot(across, across) > 1e-30 else some_perpendicular(u)
    meets = _line_meets(size, u, e, N, a, b, c)
    for R in (size[INNER], size[OUTER]):
        for Z in (size[HALF], -size[HALF]):
            meets = meets or _rim_meets(R, Z, u, e, N, a, b, c)
            for side in (-1.0, 1.0):
                rim = along(scaled(u, Z), side * R, e)
                height = dot(N, sub(a, rim))
                if abs(height) < best[0] and _holds(N, a, b, c, rim):
                    best = abs(height), along(rim, height, N), scaled(N, 1.0 if height >= 0.0 else -1.0)
    return (min(best[0], 0.0), best[1], best[2]) if meets else best


@lean_jit
def triangle_gap(kind, size, u, a, b, c):
    """A triangle against any shape, CAVITY among them; a PIPE is open."""
    if kind == SPHERE:
        return _round_and_triangle(size[RADIUS], ZERO, a, b, c)
    if kind == CAPSULE:
        return _round_and_triangle(size[RADIUS], scaled(u, size[HALF_LENGTH]), a, b, c)
    if kind == CYLINDER:
        P = lowest_on_triangle(size[RADIUS], size[HALF_LENGTH], u, a, b, c)
        far, n = cylinder_distance(size[RADIUS], size[HALF_LENGTH], u, P)
        return far, P, n
    if kind == PIPE:
        return _open_pipe_and_triangle(size, u, a, b, c)
    return _lowest_corner(kind, size, u, a, b, c)
