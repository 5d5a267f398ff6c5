"""P8: how deep two intersecting bodies overlap, judged by the direction between their closest points when last apart.

- Vertex-face: from each vertex of one body inside the other, a ray along that direction finds the face it came in by;
  the depth is the distance to that face's plane.
- Edge-edge: of each pair of edges of triangles that intersect, the two closest points, if each lies inside the other
  body, and how far apart they are along the direction; lines within a flat face are no edges.
The depth is the largest of these. Where there is none (overlaps at the level of rounding, coplanar sides, plates that
pass through each other) it is the largest move along the direction that any single pair of intersecting triangles
needs to come apart.
"""

from math import inf

import numpy as np

from comotion_server.kernels.boxes import box_gap, divides_a
from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.jit import jit
from comotion_server.kernels.mesh_pair import corners, corners_moved
from comotion_server.kernels.ray import way_out, way_out_along
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.triangle_distance import segment_parameters, triangle_points
from comotion_server.kernels.triangle_intersection import triangles_intersect
from comotion_server.kernels.vectors import ZERO, add, along, dot, rotated, rotated_back, row, scaled, sub, unit

BY_EDGES, BY_MOVES = 0, 1  # how the depth of two intersecting triangles is taken
FOUND = 1e-13  # of the bodies' sizes: a depth below it is the rounding of points on each other's surface
HALVINGS = 50  # of the move that separates two triangles: down to the rounding of a double


@jit
def _set(points, a, b):
    """The two points of an overlap, (2, 3)."""
    points[0, 0], points[0, 1], points[0, 2] = a
    points[1, 0], points[1, 1], points[1, 2] = b


@jit
def _vertices_depth(m, shape, other, R, t, direction, stack):
    """(depth, vertex, way along the direction) of the deepest of the vertices of `other` inside `shape`.

    R and t turn them into its frame.
    """
    depth, deepest, way = 0.0, -1, 0.0
    for v in range(m.vertex_start[other], m.vertex_start[other + 1]):
        found, along_ray = way_out_along(m, shape, add(rotated(R, row(m.vertices, v)), t), direction, stack)
        if found > depth:
            depth, deepest, way = found, v, along_ray
    return depth, deepest, way


@jit
def _edges_depth(m, shape_a, shape_b, i, j, R, t, n, depth, points, stack):
    """The larger of `depth` and that of the nine edge pairs of the triangles i of body a and j of body b."""
    a, b = corners(m, i), corners_moved(m, j, R, t)
    for k in range(3):
        u = sub(a[(k + 1) % 3], a[k])
        for l in range(3):
            if not (m.sharp[i, k] and m.sharp[j, l]):
                continue
            v = sub(b[(l + 1) % 3], b[l])
            s, r = segment_parameters(u, v, sub(b[l], a[k]))
            p, q = along(a[k], s, u), along(b[l], r, v)
            overlap = dot(sub(p, q), n)
            if overlap <= depth or way_out(m, shape_a, q, n, stack) < 0.0:
                continue
            in_b = rotated_back(R, sub(p, t))
            if way_out(m, shape_b, in_b, rotated_back(R, scaled(n, -1.0)), stack) >= 0.0:
                depth = overlap
                _set(points, p, q)
    return depth


@jit
def _move_intersects(a, b, move):
    return triangles_intersect(a[0], a[1], a[2], add(b[0], move), add(b[1], move), add(b[2], move))


@jit
def _move_apart(a, b, n, depth):
    """The larger of `depth` and the move of triangle b along n until it comes free of triangle a."""
    far = max(dot(n, a[0]), dot(n, a[1]), dot(n, a[2])) - min(dot(n, b[0]), dot(n, b[1]), dot(n, b[2]))
    if far <= depth or not _move_intersects(a, b, scaled(n, depth)):
        return depth
    if _move_intersects(a, b, scaled(n, far)):
        return far
    near = depth
    for _ in range(HALVINGS):
        middle = 0.5 * (near + far)
        if _move_intersects(a, b, scaled(n, middle)):
            near = middle
        else:
            far = middle
    return near


@jit
def _pairs_depth(m, shape_a, shape_b, R, t, n, way, depth, points, pairs, stack):
    """The larger of `depth` and that of intersecting triangle pairs: by their edges, or by moving each pair apart."""
    pairs[0, 0], pairs[0, 1] = m.root[shape_a], m.root[shape_b]
    top = 1
    while top > 0:
        top -= 1
        node_a, node_b = pairs[top, 0], pairs[top, 1]
        if box_gap(m, node_a, node_b, R, t, inf) > 0.0:
            continue
        if m.child[node_a] >= 0 or m.child[node_b] >= 0:
            if divides_a(m, node_a, node_b):
                pairs[top, 0], pairs[top + 1, 0] = m.child[node_a], m.child[node_a] + 1
                pairs[top + 1, 1] = node_b
            else:
                pairs[top, 1], pairs[top + 1, 1] = m.child[node_b], m.child[node_b] + 1
                pairs[top + 1, 0] = node_a
            top += 2
            continue
        for i in m.leaf_triangles[m.first[node_a] : m.first[node_a] + m.entries[node_a]]:
            for j in m.leaf_triangles[m.first[node_b] : m.first[node_b] + m.entries[node_b]]:
                a, b = corners(m, i), corners_moved(m, j, R, t)
                distance, common, _, _ = triangle_points(a[0], a[1], a[2], b[0], b[1], b[2])
                if distance > 0.0:
                    continue
                if way == BY_EDGES:
                    depth = _edges_depth(m, shape_a, shape_b, i, j, R, t, n, depth, points, stack)
                else:
                    before, depth = depth, _move_apart(a, b, n, depth)
                    if depth > before:
                        _set(points, common, common)
    return depth


@jit
def overlap(m, shape_a, shape_b, position_a, rotation_a, position_b, rotation_b, direction, points):
    """Depth [m] >= 0 of the overlap of two bodies; `direction` (3,), world: from a to b when they were last apart.

    m: MeshArrays of closed meshes; positions (3,) [m] and rotations (3, 3), body to world. A direction of zero (never
    seen apart) stands for the one between the bodies' origins. Out: points (2, 3), world [m], of a and of b: the vertex
    and where its ray leaves the other body, or the closest points of the two edges, or one that both bodies share; the
    bodies' origins where the depth is zero.
    """
    stack, pairs, R = np.empty((STACK_SIZE, 2), np.int64), np.empty((STACK_SIZE, 2), np.int64), np.empty((3, 3))
    relative_rotation(rotation_a, rotation_b, R)
    back = R.T.copy()
    t = rotated_back(rotation_a, sub(position_b, position_a))
    t_back = rotated_back(rotation_b, sub(position_a, position_b))
    n = unit(rotated_back(rotation_a, direction))
    if n == ZERO:
        n = unit(t) if dot(t, t) > 0.0 else (0.0, 0.0, 1.0)
    _set(points, ZERO, t)
    depth, v, way = _vertices_depth(m, shape_a, shape_b, R, t, n, stack)
    if v >= 0:
        q = add(rotated(R, row(m.vertices, v)), t)
        _set(points, along(q, way, n), q)
    inward = rotated_back(R, scaled(n, -1.0))
    other, v, way = _vertices_depth(m, shape_b, shape_a, back, t_back, inward, stack)
    if other > depth:
        p, depth = row(m.vertices, v), other
        _set(points, p, along(p, -way, n))
    depth = _pairs_depth(m, shape_a, shape_b, R, t, n, BY_EDGES, depth, points, pairs, stack)
    if depth <= FOUND * (m.size[shape_a] + m.size[shape_b]):
        depth = _pairs_depth(m, shape_a, shape_b, R, t, n, BY_MOVES, 0.0, points, pairs, stack)
    for i in range(2):
        points[i] = along(position_a, 1.0, rotated(rotation_a, points[i]))
    return depth


@jit
def overlap_depth(m, shape_a, shape_b, position_a, rotation_a, position_b, rotation_b, direction):
    """As `overlap`, without the points."""
    points = np.empty((2, 3))
    return overlap(m, shape_a, shape_b, position_a, rotation_a, position_b, rotation_b, direction, points)
