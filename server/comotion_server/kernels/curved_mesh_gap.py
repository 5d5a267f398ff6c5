"""Distance, closest points and normal of a mesh and a shape that is none (docs/shapes.md).

    curved_mesh_gap(m, shape, x, R, kind, size, axis, x_c, R_c, reach, witness, nodes, gaps)
        -> (distance, point on the mesh, point on the other, normal from the mesh to the other, triangle)

m: MeshArrays, shape: which mesh; kind, size, axis, x_c, R_c: the other shape as in `curved_gap`. The distance is that
of the surfaces: exact if below `reach` [m] (inf: always), otherwise a lower bound that is not below reach; at most 0
where they meet. witness: a triangle over all shapes to begin with, -1: none; the one that is nearest is returned. nodes
(STACK,) int64 and gaps (STACK,) float64 are room for the walk (`mesh_pair`).

The walk goes down the binary tree, the nearer child first. A box whose centre is at the distance d from the shape, and
whose corners are at s from its centre, holds nothing nearer than d - s; a sphere is compared with the box itself. A
mesh with its first corner in the bore of a closed pipe is inside of it.
"""

from math import inf

from comotion_server.kernels.curved_kinds import CAPS, CYLINDER, HALF, INNER, OUTER, PIPE, PLANE, RADIUS, SPHERE
from comotion_server.kernels.curved_points import is_in_bore
from comotion_server.kernels.curved_triangles import CAVITY, point_distance, triangle_gap
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.vectors import ZERO, add, along, dot, length, rotated, rotated_back, row, sub


@lean_jit
def _seen_from(m, shape, kind, size, u, C):
    """(kind, size) of a pipe as the mesh meets it: a solid cylinder, a cavity, or an open pipe."""
    if kind != PIPE:
        return kind, (size[0], size[1], size[2], size[3])
    if size[CAPS] == 0.0:
        return PIPE, (size[INNER], size[OUTER], size[HALF], 0.0)
    if is_in_bore(size, u, sub(row(m.vertices, m.vertex_start[shape]), C)):
        return CAVITY, (size[INNER], size[OUTER], size[HALF], 1.0)
    return CYLINDER, (size[OUTER], size[HALF], 0.0, 0.0)


@lean_jit
def _box_bound(m, node, kind, size, u, C):
    """A lower bound of the distance of the triangles below a node."""
    P = sub(row(m.centre, node), C)
    axes, half = m.axes[node], row(m.half, node)
    x, y, z = abs(dot(row(axes, 0), P)), abs(dot(row(axes, 1), P)), abs(dot(row(axes, 2), P))
    if kind == SPHERE:
        return length((max(x - half[0], 0.0), max(y - half[1], 0.0), max(z - half[2], 0.0))) - size[RADIUS]
    if kind == PLANE:
        reach = abs(dot(row(axes, 0), u)) * half[0] + abs(dot(row(axes, 1), u)) * half[1]
        return dot(u, P) - (reach + abs(dot(row(axes, 2), u)) * half[2])
    return point_distance(kind, size, u, P)[0] - length(half)


@lean_jit
def _nearer(best, m, triangle, kind, size, u, C):
    """The better of `best` (distance, point, normal, triangle) and one triangle."""
    a, b, c = corners(m, triangle)
    far, P, n = triangle_gap(kind, size, u, sub(a, C), sub(b, C), sub(c, C))
    return (far, P, n, triangle) if far < best[0] else best


@lean_jit
def _walk(m, shape, kind, size, u, C, reach, witness, nodes, gaps):
    """(distance, point from the shape's centre, normal from the shape, triangle), in the frame of the mesh."""
    best = inf, ZERO, ZERO, witness if witness >= 0 else m.triangle_start[shape]
    best = _nearer(best, m, best[3], kind, size, u, C)
    lower, height = inf, 1
    nodes[0], gaps[0] = m.root[shape], -inf
    while height > 0:
        height -= 1
        node, gap = nodes[height], gaps[height]
        if gap >= min(best[0], reach):
            lower = min(lower, gap)
            continue
        child = m.child[node]
        if child < 0:
            for k in range(m.first[node], m.first[node] + m.entries[node]):
                best = _nearer(best, m, m.leaf_triangles[k], kind, size, u, C)
            continue
        one, other = _box_bound(m, child, kind, size, u, C), _box_bound(m, child + 1, kind, size, u, C)
        near, far, first = (one, other, child) if one <= other else (other, one, child + 1)
        nodes[height], gaps[height] = 2 * child + 1 - first, far
        nodes[height + 1], gaps[height + 1] = first, near
        height += 2
    if best[0] < reach:
        return best
    return min(best[0], lower), best[1], best[2], best[3]


@lean_jit
def curved_mesh_gap(m, shape, x, R, kind, size, axis, x_c, R_c, reach, witness, nodes, gaps):
    """(distance, point on the mesh, point on the other, normal, triangle): see the top of this file."""
    C, u = rotated_back(R, sub(x_c, x)), rotated_back(R, rotated(R_c, axis))
    seen, lengths = _seen_from(m, shape, kind, size, u, C)
    far, P, n, triangle = _walk(m, shape, seen, lengths, u, C, reach, witness, nodes, gaps)
    D = sub(x_c, x)
    p, normal = add(D, rotated(R, P)), rotated(R, n)
    p, q = add(p, x), add(along(p, -far, normal), x)
    return far, p, q, (-normal[0], -normal[1], -normal[2]), triangle
