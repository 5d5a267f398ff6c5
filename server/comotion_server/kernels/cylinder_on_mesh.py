"""Rows of contact between a cylinder and a mesh: every pair of parts within reach at which both are local tops.

Of the cylinder: its side, its faces, its rims, and tips where a face lies flat on one of the mesh. Of the mesh: faces,
sharp edges and their corners (docs/shapes.md, 5).
"""

from math import inf

from comotion_server.kernels.body_parts import (
    AHEAD,
    BACK,
    BETWEEN,
    CORNER,
    EDGE,
    END,
    FREE,
    GROUND,
    MIDDLE,
    RIM,
    TIP,
    do_cross,
    part_of,
)
from comotion_server.kernels.contacts import FULL
from comotion_server.kernels.curved_mesh_gap import box_bound
from comotion_server.kernels.curved_triangles import triangle_gap
from comotion_server.kernels.cylinder_contact import TIPS, cylinder_manifold, is_new, shown, tip_number, try_row
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import is_top_corner, is_top_edge
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.round_contact import FOUND, SAME, small_size
from comotion_server.kernels.solids import CYLINDER, MESH
from comotion_server.kernels.topology import FLAT
from comotion_server.kernels.vectors import ZERO, cross, dot, length, rotated, rotated_back, row, scaled, sub


@lean_jit
def _out_of_cone(solids, R, body, part, number, n, slope):
    """Whether n points into the cylinder from a rim or a face."""
    if part == MIDDLE:
        return False
    rise = dot(n, rotated(R[body], row(solids.axis, body))) * (1.0 if number % 2 == 0 else -1.0)
    return rise < -slope


@lean_jit
def _is_top(m, kind, number, n, slope):
    """Whether a part of a mesh is a local top along n, in its frame."""
    if kind == EDGE:
        return is_top_edge(m, number // 3, number % 3, n, slope)
    if kind == CORNER:
        return is_top_corner(m, number, n, slope)
    return True


@lean_jit
def _add(solids, contacts, first, count, pair, D, R, limits, part, other, which):
    """A row of a part of the cylinder and one of the mesh: count, or FULL.

    pair: (a, b, 1 where b is the mesh); limits: (gap [m], sine of a slope, 1 if it need be no top).
    """
    a, b, mesh_is_b = pair
    if count < 0 or first + count >= len(contacts.gap):
        return FULL
    (limit, slope, forced), size = limits, small_size(solids, a, b)
    features = (part[0], part[1], other[0], other[1], which) if mesh_is_b == 1 else (*other, *part, which)
    margin, n, gap = try_row(solids, contacts, first, count, (a, b), D, R, features)
    if margin < -FOUND * size or not -limit <= gap <= limit:
        return count
    body, mesh = (a, b) if mesh_is_b == 1 else (b, a)
    n = n if mesh_is_b == 1 else scaled(n, -1.0)
    if forced == 0:
        top = _is_top(solids.meshes, other[0], other[1], rotated_back(R[mesh], scaled(n, -1.0)), slope)
        if not top or _out_of_cone(solids, R, body, part[0], part[1], n, slope):
            return count
    return count + 1 if is_new(contacts, first, count, SAME * size) else count


@lean_jit
def _over_triangle(solids, contacts, first, count, pair, D, R, limits, t):
    """Rows of the cylinder over the inside of a triangle."""
    body, mesh = (pair[0], pair[1]) if pair[2] == 1 else (pair[1], pair[0])
    N = rotated(R[mesh], row(solids.meshes.normals, t))
    n = scaled(N, -1.0)
    part, number = shown(solids, R, body, n, limits[1])
    if part == END:
        for k in range(TIPS):
            tip = (TIP, tip_number(solids, R, body, number, n, k))
            count = _add(solids, contacts, first, count, pair, D, R, limits, tip, (GROUND, t), 0)
        return count
    for end in range(2):
        if part == MIDDLE or end == number:
            count = _add(solids, contacts, first, count, pair, D, R, limits, (RIM, end), (GROUND, t), 0)
    return count


@lean_jit
def _over_corner(solids, contacts, first, count, pair, D, R, limits, v):
    """Rows of a corner."""
    count = _add(solids, contacts, first, count, pair, D, R, limits, (MIDDLE, 0), (CORNER, v), 0)
    for end in range(2):
        count = _add(solids, contacts, first, count, pair, D, R, limits, (END, end), (CORNER, v), 0)
        if limits[2] == 1:
            count = _add(solids, contacts, first, count, pair, D, R, limits, (RIM, end), (CORNER, v), BETWEEN)
    return count


@lean_jit
def _over_edge(solids, contacts, first, count, pair, D, R, limits, edge):
    """Rows of an edge."""
    body, mesh = (pair[0], pair[1]) if pair[2] == 1 else (pair[1], pair[0])
    of_body, of_mesh = (ZERO, D) if pair[2] == 1 else (D, ZERO)
    line = part_of(solids, R, mesh, of_mesh, EDGE, edge)
    u = rotated(R[body], row(solids.axis, body))
    beside = length(cross(u, line.axis)) <= FLAT
    if not beside:
        count = _add(solids, contacts, first, count, pair, D, R, limits, (MIDDLE, 0), (EDGE, edge), 0)
    for end in range(2):
        if beside:
            count = _add(solids, contacts, first, count, pair, D, R, limits, (RIM, end), (EDGE, edge), FREE)
        elif abs(dot(u, line.axis)) <= limits[1]:
            if do_cross(part_of(solids, R, body, of_body, RIM, end), line):
                for which in (AHEAD, BACK):
                    count = _add(solids, contacts, first, count, pair, D, R, limits, (RIM, end), (EDGE, edge), which)
            count = _add(solids, contacts, first, count, pair, D, R, limits, (RIM, end), (EDGE, edge), BETWEEN)
        else:
            count = _add(solids, contacts, first, count, pair, D, R, limits, (RIM, end), (EDGE, edge), BETWEEN)
    return count


@lean_jit
def _add_triangle(solids, contacts, first, count, pair, D, R, limits, t):
    """All rows over triangle t, its edges and its corners: count, or FULL."""
    m = solids.meshes
    count = _over_triangle(solids, contacts, first, count, pair, D, R, limits, t)
    for k in range(3):
        if m.sharp[t, k] == 1:
            count = _over_edge(solids, contacts, first, count, pair, D, R, limits, 3 * t + k)
        if m.sharp[t, k] == 1 or m.sharp[t, (k + 2) % 3] == 1:
            count = _over_corner(solids, contacts, first, count, pair, D, R, limits, m.triangles[t, k])
    return count


@lean_jit
def mesh_and_cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of a cylinder and a mesh: how many rows, or FULL. If no part is a top, those nearest."""
    mesh_is_b = 1 if solids.kind[a] == CYLINDER else 0
    body, mesh = (a, b) if mesh_is_b == 1 else (b, a)
    m, size, pair, nodes = solids.meshes, solids.size[body], (a, b, mesh_is_b), work.walk[0][:, 0]
    limit = max(reach, level) if angle > 0.0 else reach
    limits = (limit, max(angle, FLAT), 0)
    C = rotated_back(R[mesh], sub(row(x, body), row(x, mesh)))
    u, D = rotated_back(R[mesh], rotated(R[body], row(solids.axis, body))), sub(row(x, b), row(x, a))
    nearest, least, count, top = -1, inf, 0, 1
    nodes[0] = m.root[solids.shape[mesh]]
    while top > 0 and count >= 0:
        top -= 1
        node = nodes[top]
        if box_bound(m, node, CYLINDER, size, u, C) > limit:
            continue
        if m.child[node] >= 0:
            nodes[top], nodes[top + 1] = m.child[node], m.child[node] + 1
            top += 2
            continue
        for k in range(m.first[node], m.first[node] + m.entries[node]):
            t = m.leaf_triangles[k]
            p, q, s = corners(m, t)
            far = triangle_gap(CYLINDER, size, u, sub(p, C), sub(q, C), sub(s, C))[0]
            if far < least:
                nearest, least = t, far
            if far <= limit and count >= 0:
                count = _add_triangle(solids, contacts, first, count, pair, D, R, limits, t)
    if count == 0 and least <= reach:
        count = _add_triangle(solids, contacts, first, count, pair, D, R, (reach, limits[1], 1), nearest)
    return count


@lean_jit
def any_and_cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of a cylinder and anything."""
    if solids.kind[a] == MESH or solids.kind[b] == MESH:
        return mesh_and_cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work)
    return cylinder_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)
