"""The points at which two triangles bound a patch of contact, seen along its normal n.

Each body shows along n its level faces, and edges and corners without a level face, which are *bare*. What both show
overlaps in points (one over the other), stretches and polygons, whose corners are
  corners over faces        CORNER_FACE, FACE_CORNER
  crossings of edges        CROSSING_A, CROSSING_B at the border of a face, EDGES of two bare ones
  corners over bare edges or corners   POINTS
Triangles, and with them lines within a flat face, leave no trace: only sharp edges bound a face.
"""

from typing import NamedTuple

from comotion_server.kernels.contact_hull import add_point
from comotion_server.kernels.contacts import CORNER_FACE, CROSSING_A, CROSSING_B, EDGES, FACE_CORNER, POINTS
from comotion_server.kernels.jit import jit
from comotion_server.kernels.level_faces import is_corner, is_edge, is_level
from comotion_server.kernels.vectors import along, cross, dot, rotated, row, sub

PARALLEL = 1e-9  # sine of two edges below which they do not cross: their ends tell where they overlap

Vector = tuple[float, float, float]


class Side(NamedTuple):
    """A triangle of one body, and what it shows of its body along the normal."""

    triangle: int
    outward: Vector  # the normal of the patch in the body's own axes, away from the body
    level: bool  # whether the triangle is a level face


class Rules(NamedTuple):
    """What counts."""

    slope: float  # sine below which nothing rises
    slack: float  # how far outside a face or an edge a point still lies on it [m]
    of_a: bool  # whether the normal is that of a face of a


@jit
def side_of(m, triangle, outward, slope):
    """`Side` of a triangle."""
    return Side(triangle, outward, is_level(row(m.normals, triangle), outward, slope))


@jit
def _lies_over(p, corners, outward, slack):
    """Whether p lies over a triangle, looking against its outward normal."""
    for k in range(3):
        u = sub(corners[(k + 1) % 3], corners[k])
        inside = dot(cross(outward, u), sub(p, corners[k]))
        if inside < 0.0 and inside * inside > slack * slack * dot(u, u):
            return False
    return True


@jit
def foot(p, n, face, point):
    """Where the line from p along n meets the plane of normal `face` through a point."""
    return along(p, dot(face, sub(point, p)) / dot(face, n), n)


@jit
def _corners_over_face(m, side, over, c, face, rules, view, sign, points, count):
    """Corners of one triangle that lie over the level triangle `over` of the other body.

    c: `TwoTriangles`, in turn that of the corners and the other; face: outward normal of the level one; sign: 1 if the
    corners are those of a, -1 if of b.
    """
    corners, others = c
    for k in range(3):
        p = corners[k]
        q = foot(p, view.n, face, others[0])
        if abs(dot(view.n, sub(q, p))) > view.limit or not _lies_over(p, others, face, rules.slack):
            continue
        if not is_corner(m, side.triangle, k, side.level, side.outward, rules.slope):
            continue
        v = m.triangles[side.triangle, k]
        if sign > 0:
            count = add_point(points, count, view, CORNER_FACE, (v, -1, over.triangle, -1, -1), p, q)
        else:
            count = add_point(points, count, view, FACE_CORNER, (over.triangle, -1, v, -1, -1), q, p)
    return count


@jit
def crossing(a0, u, b0, v, n):
    """(s, t, sine with the lengths): a0 + s u lies over b0 + t v, looking along n; nothing where the sine is zero."""
    normal, w = cross(u, v), sub(b0, a0)
    sine = dot(normal, n)
    if sine == 0.0:
        return 0.0, 0.0, 0.0
    return dot(cross(w, v), n) / sine, dot(cross(w, u), n) / sine, sine


@jit
def _within(s, slack, squared):
    """Whether the point at s in [0, 1] lies on an edge of this squared length."""
    beyond = max(-s, s - 1.0)
    return beyond <= 0.0 or beyond * beyond * squared <= slack * slack


@jit
def _crossing_of_edges(m, side_a, side_b, k, l, c, rules, view, points, count):
    """The crossing of the edges from corner k of a's triangle and corner l of b's."""
    a0, b0 = c.a[k], c.b[l]
    u, v = sub(c.a[(k + 1) % 3], a0), sub(c.b[(l + 1) % 3], b0)
    s, t, sine = crossing(a0, u, b0, v, view.n)
    uu, vv = dot(u, u), dot(v, v)
    if sine * sine <= PARALLEL * PARALLEL * uu * vv:
        return count
    if not (_within(s, rules.slack, uu) and _within(t, rules.slack, vv)):
        return count
    kind, face = EDGES, -1
    if side_a.level and (rules.of_a or not side_b.level):
        kind, face = CROSSING_A, side_a.triangle
    elif side_b.level:
        kind, face = CROSSING_B, side_b.triangle
    i, j = m.triangles[side_a.triangle], m.triangles[side_b.triangle]
    a_from, a_to, b_from, b_to = i[k], i[(k + 1) % 3], j[l], j[(l + 1) % 3]
    if a_from > a_to:
        a_from, a_to, sine = a_to, a_from, -sine
    if sine < 0.0:  # the order of b's ends tells the sense of the normal, a's edge x b's edge
        b_from, b_to = b_to, b_from
    return add_point(points, count, view, kind, (a_from, a_to, b_from, b_to, face), along(a0, s, u), along(b0, t, v))


@jit
def _crossings(m, side_a, side_b, c, rules, view, points, count):
    """Crossings of the edges that the two triangles show."""
    for k in range(3):
        if not is_edge(m, side_a.triangle, k, side_a.level, side_a.outward, rules.slope):
            continue
        for l in range(3):
            if is_edge(m, side_b.triangle, l, side_b.level, side_b.outward, rules.slope):
                count = _crossing_of_edges(m, side_a, side_b, k, l, c, rules, view, points, count)
    return count


@jit
def _is_over(p, q, n, slack):
    """Whether p and q lie over each other, looking along n."""
    d = sub(q, p)
    d = along(d, -dot(n, d), n)
    return dot(d, d) <= slack * slack


@jit
def _corners_over_edges(m, side, over, c, rules, view, sign, points, count):
    """Bare corners of one triangle that lie over bare edges of the other; arguments as in `_corners_over_face`."""
    corners, others = c
    for l in range(3):
        u = sub(others[(l + 1) % 3], others[l])
        for k in range(3):
            s = dot(u, sub(corners[k], others[l])) / dot(u, u)
            q = along(others[l], s, u)
            if not (_is_over(corners[k], q, view.n, rules.slack) and _within(s, rules.slack, dot(u, u))):
                continue
            if not is_edge(m, over.triangle, l, over.level, over.outward, rules.slope):
                continue
            if is_corner(m, side.triangle, k, side.level, side.outward, rules.slope):
                v = m.triangles[side.triangle, k]
                w0, w1 = m.triangles[over.triangle, l], m.triangles[over.triangle, (l + 1) % 3]
                if sign > 0:
                    count = add_point(points, count, view, POINTS, (v, -1, w0, w1, -1), corners[k], q)
                else:
                    count = add_point(points, count, view, POINTS, (w0, w1, v, -1, -1), q, corners[k])
    return count


@jit
def _corners_over_corners(m, side_a, side_b, c, rules, view, points, count):
    """Bare corners that lie over each other."""
    for k in range(3):
        for l in range(3):
            if (
                _is_over(c.a[k], c.b[l], view.n, rules.slack)
                and is_corner(m, side_a.triangle, k, side_a.level, side_a.outward, rules.slope)
                and is_corner(m, side_b.triangle, l, side_b.level, side_b.outward, rules.slope)
            ):
                v, w = m.triangles[side_a.triangle, k], m.triangles[side_b.triangle, l]
                count = add_point(points, count, view, POINTS, (v, -1, w, -1, -1), c.a[k], c.b[l])
    return count


@jit
def add_overlap(m, side_a, side_b, c, R, rules, view, points, count):
    """Put the points of two triangles, c = `TwoTriangles`, among those of the patch; how many there are, or FULL."""
    if side_b.level:
        face = rotated(R, row(m.normals, side_b.triangle))
        count = _corners_over_face(m, side_a, side_b, (c.a, c.b), face, rules, view, 1, points, count)
    if side_a.level:
        face = row(m.normals, side_a.triangle)
        count = _corners_over_face(m, side_b, side_a, (c.b, c.a), face, rules, view, -1, points, count)
    count = _crossings(m, side_a, side_b, c, rules, view, points, count)
    if not (side_a.level or side_b.level):
        count = _corners_over_edges(m, side_a, side_b, (c.a, c.b), rules, view, 1, points, count)
        count = _corners_over_edges(m, side_b, side_a, (c.b, c.a), rules, view, -1, points, count)
        count = _corners_over_corners(m, side_a, side_b, c, rules, view, points, count)
    return count
