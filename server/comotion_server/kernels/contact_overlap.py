"""Where two triangles overlap, seen along the normal n of a patch: plain arithmetic on corners, without arrays.

What is found comes as bits: bit k for corner k, bit 3 k + l for edge k of a over edge l of b.
"""

from typing import NamedTuple

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import rises
from comotion_server.kernels.pair_impact_bounds import Points, Vector
from comotion_server.kernels.vectors import along, cross, dot, sub

PARALLEL = 1e-9  # sine of two edges below which they do not cross: their ends tell where they overlap


class Side(NamedTuple):
    """A triangle of one body, in the axes of a, and what it may show of its body along the normal."""

    body: int  # OF_A or OF_B
    triangle: int  # over all shapes
    points: Points  # corners [m]
    outward: Vector  # the normal of the patch, away from the body
    face: Vector  # the triangle's own outward normal
    level: bool  # whether it is a level face
    sharp: tuple[bool, bool, bool]  # whether the edge from corner k is one


@lean_jit
def lies_over(p, corners, outward, slack):
    """Whether p lies over a triangle, looking against its outward normal, or beside it by no more than `slack` [m]."""
    for k in range(3):
        u = sub(corners[(k + 1) % 3], corners[k])
        inside = dot(cross(outward, u), sub(p, corners[k]))
        if inside < 0.0 and inside * inside > slack * slack * dot(u, u):
            return False
    return True


@lean_jit
def foot(p, n, face, point):
    """Where the line from p along n meets the plane of normal `face` through a point."""
    return along(p, dot(face, sub(point, p)) / dot(face, n), n)


@lean_jit
def _may_show_corner(side, k, slope):
    """Whether corner k is at a sharp edge of a level face, or a top of its own triangle."""
    if side.level:
        return side.sharp[k] or side.sharp[(k + 2) % 3]
    p, n = side.points[k], side.outward
    u, v = sub(side.points[(k + 1) % 3], p), sub(side.points[(k + 2) % 3], p)
    return not (rises(u, n, slope) or rises(v, n, slope))


@lean_jit
def _may_show_edge(side, k, slope):
    """Whether the edge from corner k is sharp and level, and the triangle does not rise from it."""
    if not side.sharp[k] or side.level:
        return side.sharp[k]
    p, q, n = side.points[k], side.points[(k + 1) % 3], side.outward
    u, v = sub(q, p), sub(side.points[(k + 2) % 3], p)
    return not (rises(u, n, slope) or rises(sub(p, q), n, slope) or rises(v, n, slope))


@lean_jit
def corners_over_face(side, other, slope, slack, limit):
    """Corners of one triangle that lie over the other, a level face, with a gap of at most `limit` [m]."""
    bits = 0
    for k in range(3):
        p = side.points[k]
        gap = dot(other.face, sub(p, other.points[0]))
        if abs(gap) <= limit and lies_over(p, other.points, other.outward, slack) and _may_show_corner(side, k, slope):
            bits |= 1 << k
    return bits


@lean_jit
def crossing(a0, u, b0, v, n):
    """(s, t, product of the lengths and the sine) where a0 + s u lies over b0 + t v, looking along n; 0 if parallel."""
    normal, w = cross(u, v), sub(b0, a0)
    sine = dot(normal, n)
    if sine == 0.0:
        return 0.0, 0.0, 0.0
    return dot(cross(w, v), n) / sine, dot(cross(w, u), n) / sine, sine


@lean_jit
def _within(s, slack, squared):
    """Whether the point at s in [0, 1] lies on an edge of this squared length."""
    beyond = max(-s, s - 1.0)
    return beyond <= 0.0 or beyond * beyond * squared <= slack * slack


@lean_jit
def edges_crossing(side_a, side_b, slope, slack):
    """Edges of both triangles that cross inside, or by no more than `slack` outside."""
    bits = 0
    for k in range(3):
        if not _may_show_edge(side_a, k, slope):
            continue
        a0 = side_a.points[k]
        u = sub(side_a.points[(k + 1) % 3], a0)
        for l in range(3):
            if not _may_show_edge(side_b, l, slope):
                continue
            b0 = side_b.points[l]
            v = sub(side_b.points[(l + 1) % 3], b0)
            s, t, sine = crossing(a0, u, b0, v, side_a.outward)
            uu, vv = dot(u, u), dot(v, v)
            if sine * sine > PARALLEL * PARALLEL * uu * vv and _within(s, slack, uu) and _within(t, slack, vv):
                bits |= 1 << (3 * k + l)
    return bits


@lean_jit
def are_over(p, q, n, slack):
    """Whether p and q lie over each other, looking along n."""
    d = sub(q, p)
    d = along(d, -dot(n, d), n)
    return dot(d, d) <= slack * slack


@lean_jit
def on_edge(p, side, l):
    """Where on edge l of a triangle the point nearest to p is, 0 to 1 inside."""
    u = sub(side.points[(l + 1) % 3], side.points[l])
    return dot(u, sub(p, side.points[l])) / dot(u, u)


@lean_jit
def point_on_edge(side, l, s):
    """The point of edge l at s."""
    return along(side.points[l], s, sub(side.points[(l + 1) % 3], side.points[l]))


@lean_jit
def corners_over_edges(side, other, slope, slack):
    """Corners of one triangle that lie over edges of the other: bit 3 k + l for corner k over edge l."""
    bits = 0
    for k in range(3):
        if not _may_show_corner(side, k, slope):
            continue
        p = side.points[k]
        for l in range(3):
            u = sub(other.points[(l + 1) % 3], other.points[l])
            s = on_edge(p, other, l)
            if (
                _within(s, slack, dot(u, u))
                and are_over(p, point_on_edge(other, l, s), side.outward, slack)
                and _may_show_edge(other, l, slope)
            ):
                bits |= 1 << (3 * k + l)
    return bits


@lean_jit
def corners_over_corners(side_a, side_b, slope, slack):
    """Corners of both triangles that lie over each other: bit 3 k + l."""
    bits = 0
    for k in range(3):
        for l in range(3):
            if (
                are_over(side_a.points[k], side_b.points[l], side_a.outward, slack)
                and _may_show_corner(side_a, k, slope)
                and _may_show_corner(side_b, l, slope)
            ):
                bits |= 1 << (3 * k + l)
    return bits
