"""The points that bound a patch of contact, from all pairs of triangles within reach, seen along its normal n.

Each body shows along n its level faces, and edges and corners without a level face, which are *bare*. What both show
overlaps in points (one over the other), stretches and polygons, whose corners are
  corners over faces        CORNER_FACE, FACE_CORNER
  crossings of edges        CROSSING_A, CROSSING_B at the border of a face, EDGES of two bare ones
  corners over bare edges or corners   POINTS
Triangles, and with them lines within a flat face, leave no trace: only sharp edges bound a face.
"""

from typing import NamedTuple

from comotion_server.kernels.contact_hull import NONE, add_point
from comotion_server.kernels.contact_normals import OF_A, OF_B, gap_along, two_triangles
from comotion_server.kernels.contact_overlap import (
    Side,
    corners_over_corners,
    corners_over_edges,
    corners_over_face,
    crossing,
    edges_crossing,
    foot,
    on_edge,
    point_on_edge,
)
from comotion_server.kernels.contacts import CORNER_FACE, CROSSING_A, CROSSING_B, EDGES, FACE_CORNER, FULL, POINTS
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import is_corner, is_edge, is_level
from comotion_server.kernels.vectors import along, rotated, rotated_back, row, scaled, sub


class Rules(NamedTuple):
    """What counts."""

    slope: float  # sine below which nothing rises
    slack: float  # how far outside a face or an edge a point still lies on it [m]


@lean_jit
def _sharp(sharp, t):
    return sharp[t, 0] == 1, sharp[t, 1] == 1, sharp[t, 2] == 1


@lean_jit
def _shows_corner(m, side, k, R, slope):
    """Whether the body shows corner k of a triangle, which may be so as far as the triangle tells."""
    outward = rotated_back(R, side.outward) if side.body == OF_B else side.outward
    return side.level or is_corner(m, m.triangles[side.triangle, k], outward, slope)


@lean_jit
def _shows_edge(m, side, k, R, slope):
    """The same for the edge from corner k."""
    outward = rotated_back(R, side.outward) if side.body == OF_B else side.outward
    return side.level or is_edge(m, side.triangle, k, outward, slope)


@lean_jit
def _add_corner(m, side, k, other, view, points, count):
    """A corner over the level face of the other body."""
    v, p = m.triangles[side.triangle, k], side.points[k]
    q = foot(p, view.n, other.face, other.points[0])
    first, last = v, other.triangle
    if side.body == OF_B:
        first, last, p, q = last, first, q, p
    kind = CORNER_FACE if side.body == OF_A else FACE_CORNER
    return add_point(points, count, view, kind, first, NONE, last, NONE, NONE, p, q)


@lean_jit
def _add_crossing(m, side_a, k, side_b, l, face_of_a, view, points, count):
    """A crossing of two edges; face_of_a: whether the normal is that of a face of a."""
    a0, b0, i, j, triangles = side_a.points[k], side_b.points[l], side_a.triangle, side_b.triangle, m.triangles
    u, v = sub(side_a.points[(k + 1) % 3], a0), sub(side_b.points[(l + 1) % 3], b0)
    s, t, sine = crossing(a0, u, b0, v, view.n)
    kind, face = EDGES, NONE
    if side_a.level and (face_of_a or not side_b.level):
        kind, face = CROSSING_A, i
    elif side_b.level:
        kind, face = CROSSING_B, j
    a_from, a_to, b_from, b_to = triangles[i, k], triangles[i, (k + 1) % 3], triangles[j, l], triangles[j, (l + 1) % 3]
    if a_from > a_to:
        a_from, a_to, sine = a_to, a_from, -sine
    if sine < 0.0:  # the order of b's ends tells the sense of the normal, a's edge x b's edge
        b_from, b_to = b_to, b_from
    return add_point(points, count, view, kind, a_from, a_to, b_from, b_to, face, along(a0, s, u), along(b0, t, v))


@lean_jit
def _add_corner_on_edge(m, side, k, other, l, view, points, count):
    """A bare corner over a bare edge of the other body."""
    v, j = m.triangles[side.triangle, k], other.triangle
    w0, w1 = m.triangles[j, l], m.triangles[j, (l + 1) % 3]
    p = side.points[k]
    q = point_on_edge(other, l, on_edge(p, other, l))
    if side.body == OF_B:
        return add_point(points, count, view, POINTS, w0, w1, v, NONE, NONE, q, p)
    return add_point(points, count, view, POINTS, v, NONE, w0, w1, NONE, p, q)


@lean_jit
def _add_corners(m, side, other, bits, R, rules, view, points, count):
    """The corners over a level face that are shown."""
    for k in range(3):
        if bits >> k & 1 and _shows_corner(m, side, k, R, rules.slope):
            count = _add_corner(m, side, k, other, view, points, count)
    return count


@lean_jit
def _add_crossings(m, side_a, side_b, bits, R, face_of_a, rules, view, points, count):
    """The crossings of edges that are shown."""
    for k in range(3):
        for l in range(3):
            if (
                bits >> (3 * k + l) & 1
                and _shows_edge(m, side_a, k, R, rules.slope)
                and _shows_edge(m, side_b, l, R, rules.slope)
            ):
                count = _add_crossing(m, side_a, k, side_b, l, face_of_a, view, points, count)
    return count


@lean_jit
def _add_corners_on_edges(m, side, other, bits, R, rules, view, points, count):
    """The bare corners over bare edges."""
    for k in range(3):
        for l in range(3):
            if (
                bits >> (3 * k + l) & 1
                and _shows_corner(m, side, k, R, rules.slope)
                and _shows_edge(m, other, l, R, rules.slope)
            ):
                count = _add_corner_on_edge(m, side, k, other, l, view, points, count)
    return count


@lean_jit
def _add_corners_on_corners(m, side_a, side_b, bits, R, rules, view, points, count):
    """The bare corners over each other."""
    for k in range(3):
        for l in range(3):
            if (
                bits >> (3 * k + l) & 1
                and _shows_corner(m, side_a, k, R, rules.slope)
                and _shows_corner(m, side_b, l, R, rules.slope)
            ):
                v, w = m.triangles[side_a.triangle, k], m.triangles[side_b.triangle, l]
                p, q = side_a.points[k], side_b.points[l]
                count = add_point(points, count, view, POINTS, v, NONE, w, NONE, NONE, p, q)
    return count


@lean_jit
def _add_bare(m, side_a, side_b, R, rules, view, points, count):
    """What two triangles that are not level give apart from crossings."""
    slope, slack = rules
    bits = corners_over_edges(side_a, side_b, slope, slack)
    if bits:
        count = _add_corners_on_edges(m, side_a, side_b, bits, R, rules, view, points, count)
    bits = corners_over_edges(side_b, side_a, slope, slack)
    if bits:
        count = _add_corners_on_edges(m, side_b, side_a, bits, R, rules, view, points, count)
    bits = corners_over_corners(side_a, side_b, slope, slack)
    if bits:
        count = _add_corners_on_corners(m, side_a, side_b, bits, R, rules, view, points, count)
    return count


@lean_jit
def patch_points(m, R, t, directions, d, rules, view, pairs, number, points):
    """All points of the patch along direction d of two meshes, as they come; how many, or FULL.

    m: `Surface`; R, t turn points of b's frame into a's; pairs (number, 2) of triangles within reach.
    """
    vertices, triangles, normals, sharp = m.vertices, m.triangles, m.normals, m.sharp
    n, back = view.n, scaled(view.n, -1.0)
    n_b, of_a, count = row(directions.normal_b, d), directions.owner[d] == OF_A, 0
    slope, slack = rules
    for k in range(number):
        i, j = pairs[k, 0], pairs[k, 1]
        c = two_triangles(vertices, triangles, i, j, R, t)
        if count == FULL or gap_along(n, c) > view.limit:
            continue
        face_a, own_b = row(normals, i), row(normals, j)
        side_a = Side(OF_A, i, c.a, n, face_a, is_level(face_a, n, slope), _sharp(sharp, i))
        side_b = Side(OF_B, j, c.b, back, rotated(R, own_b), is_level(own_b, n_b, slope), _sharp(sharp, j))
        if side_b.level:
            bits = corners_over_face(side_a, side_b, slope, slack, view.limit)
            if bits:
                count = _add_corners(m, side_a, side_b, bits, R, rules, view, points, count)
        if side_a.level:
            bits = corners_over_face(side_b, side_a, slope, slack, view.limit)
            if bits:
                count = _add_corners(m, side_b, side_a, bits, R, rules, view, points, count)
        bits = edges_crossing(side_a, side_b, slope, slack)
        if bits:
            count = _add_crossings(m, side_a, side_b, bits, R, of_a, rules, view, points, count)
        if not (side_a.level or side_b.level):
            count = _add_bare(m, side_a, side_b, R, rules, view, points, count)
    return count
