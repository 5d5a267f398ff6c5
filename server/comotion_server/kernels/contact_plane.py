"""Meshes on planes: the lowest corner, and the corners in reach."""

from math import inf

from comotion_server.kernels.boxes import lowest
from comotion_server.kernels.contact_hull import add_point
from comotion_server.kernels.contacts import CORNER_FACE, FACE_CORNER
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import is_top_corner
from comotion_server.kernels.vectors import add, along, dot, rotated, row, scaled


@lean_jit
def lowest_corner(m, shape, up, nodes):
    """The least that up . x reaches on a mesh [m], up a unit vector in the body's axes; nodes (STACK_SIZE, 2) int64."""
    best, top = inf, 1
    nodes[0, 0] = m.root[shape]
    while top > 0:
        top -= 1
        node = nodes[top, 0]
        if lowest(m, node, up) >= best:
            continue
        if m.child[node] < 0:
            for e in range(m.first[node], m.first[node] + m.entries[node]):
                for k in range(3):
                    best = min(best, dot(up, row(m.vertices, m.triangles[m.leaf_triangles[e], k])))
            continue
        near, far = m.child[node], m.child[node] + 1
        if lowest(m, far, up) < lowest(m, near, up):
            near, far = far, near
        nodes[top, 0], nodes[top + 1, 0] = far, near
        top += 2
    return best


@lean_jit
def add_corners(m, shape, up, height, rotation, offset, mesh_is_a, slope, view, nodes, points):
    """The corners of a mesh within reach of a plane, as points of a patch; how many, or FULL.

    up: unit, away from the plane's solid side, in the axes of the mesh; height [m]: of the centre of the mesh over the
    plane; rotation, offset: from the axes of the mesh to those of `view`.
    """
    down, count, top = scaled(up, -1.0), 0, 1
    nodes[0, 0] = m.root[shape]
    while top > 0:
        top -= 1
        node = nodes[top, 0]
        if height + lowest(m, node, up) > view.limit:
            continue
        if m.child[node] >= 0:
            nodes[top, 0], nodes[top + 1, 0] = m.child[node], m.child[node] + 1
            top += 2
            continue
        for e in range(m.first[node], m.first[node] + m.entries[node]):
            t = m.leaf_triangles[e]
            for k in range(3):
                v = m.triangles[t, k]
                gap = height + dot(up, row(m.vertices, v))
                if gap > view.limit or not (m.sharp[t, k] or m.sharp[t, (k + 2) % 3]):
                    continue
                if not is_top_corner(m, v, down, slope):
                    continue
                p = add(rotated(rotation, row(m.vertices, v)), offset)
                if mesh_is_a:
                    count = add_point(points, count, view, CORNER_FACE, v, -1, -1, -1, -1, p, along(p, gap, view.n))
                else:
                    count = add_point(points, count, view, FACE_CORNER, -1, -1, v, -1, -1, along(p, -gap, view.n), p)
    return count
