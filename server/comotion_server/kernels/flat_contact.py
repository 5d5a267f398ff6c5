"""The points of contact of two meshes, or of a mesh and a plane, and their distance."""

from math import inf

import numpy as np

from comotion_server.kernels.contact_hull import hull, lower_points, new_points, view_along
from comotion_server.kernels.contact_normals import OF_A, OF_B, new_directions
from comotion_server.kernels.contact_pairs import new_pairs, touching_pairs, tree_of
from comotion_server.kernels.contact_patch import Rules, patch_points
from comotion_server.kernels.contact_plane import add_corners, lowest_corner
from comotion_server.kernels.contacts import FEATURES, FULL
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.level_faces import surface_of
from comotion_server.kernels.mesh_pair import closest_points, work_space
from comotion_server.kernels.mesh_room import PatchWork
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.topology import FLAT
from comotion_server.kernels.vectors import ZERO, dot, rotated, rotated_back, row, scaled, sub

MERGE = 1e-7  # of the smaller body's size: points of contact nearer than this are one
OBLIQUE = (0.4472, 0.6325, 0.6324)  # to whatever is likely in a scene: patches are told in its order
ON_FEATURE = 1e-9  # of the same: how far outside a face or an edge a point still lies on it
SAG = 0.1  # of the reach: how much lower than all corners of a patch a point inside it matters


@jit
def new_patch_work():
    """`PatchWork`, to be used again and again."""
    pairs, nodes = new_pairs()
    return PatchWork(pairs, nodes, new_directions(), new_points(), np.empty((3, 3)), work_space())


@lean_jit
def smaller_size(solids, a, b):
    """The diameter of the smaller body [m]."""
    return 2.0 * min(solids.radius[a], solids.radius[b])


@lean_jit
def _write(contacts, first, a, b, points, count, corners, n, rotation, offset):
    """The corners of a patch as rows of contacts; how many rows, or FULL.

    n: normal, world; rotation, offset: from the axes of the points to the world's; centre of b there.
    """
    if first + corners > len(contacts.gap):
        return FULL
    for c in range(corners):
        i, k = first + c, points.order[count + c]
        contacts.bodies[i, 0], contacts.bodies[i, 1] = a, b
        contacts.kind[i], contacts.gap[i] = points.kind[k], points.gap[k]
        for f in range(FEATURES):
            contacts.feature[i, f] = points.feature[k, f]
        contacts.normal[i] = n
        contacts.arm_a[i] = rotated(rotation, row(points.point_a, k))
        contacts.arm_b[i] = rotated(rotation, sub(row(points.point_b, k), offset))
    return corners


@lean_jit
def _world_normal(m, a, b, R, directions, d):
    """Direction d in the world; that of a face straight from the face, so that it is exact."""
    if directions.owner[d] == OF_A:
        return rotated(R[a], row(m.normals, directions.triangle[d]))
    if directions.owner[d] == OF_B:
        return scaled(rotated(R[b], row(m.normals, directions.triangle[d])), -1.0)
    return rotated(R[a], row(directions.normal, d))


@lean_jit
def _in_turn(directions, found, turn):
    """The direction number `turn` along OBLIQUE: an order that hardly depends on how they were found."""
    best = 0
    for d in range(found):
        here, before = dot(OBLIQUE, row(directions.normal, d)), 0
        for other in range(found):
            if (dot(OBLIQUE, row(directions.normal, other)), other) < (here, d):
                before += 1
        if before == turn:
            best = d
    return best


@jit
def _meshes(solids, a, b, x, R, reach, slope, limit, contacts, first, work):
    """`manifold` of two meshes."""
    m, directions = surface_of(solids.meshes), work.directions
    shape_a, shape_b, size = solids.shape[a], solids.shape[b], smaller_size(solids, a, b)
    relative_rotation(R[a], R[b], work.R)
    t = rotated_back(R[a], sub(row(x, b), row(x, a)))
    tree, roots = tree_of(solids.meshes), (solids.meshes.root[shape_a], solids.meshes.root[shape_b])
    pairs, found = touching_pairs(
        m, tree, shape_a, shape_b, roots, work.R, t, reach, limit, slope, work.nodes, work.pairs, directions
    )
    if pairs == FULL or found == FULL:
        return FULL
    rules, rows = Rules(slope, ON_FEATURE * size), 0
    for turn in range(found):
        d = _in_turn(directions, found, turn)
        view = view_along(row(directions.normal, d), limit, MERGE * size)
        count = patch_points(m, work.R, t, directions, d, rules, view, work.pairs, pairs, work.points)
        if count == FULL:
            return FULL
        if count > 0:
            corners = hull(work.points, count, ON_FEATURE * size)
            corners = lower_points(work.points, count, corners, SAG * reach)
            n = _world_normal(m, a, b, R, directions, d)
            written = _write(contacts, first + rows, a, b, work.points, count, corners, n, R[a], t)
            if written == FULL:
                return FULL
            rows += written
    return rows


@jit
def _mesh_on_plane(solids, a, b, x, R, reach, slope, limit, contacts, first, work):
    """`manifold` of a mesh and a plane."""
    mesh_is_a = solids.kind[b] == PLANE
    mesh, plane = (a, b) if mesh_is_a else (b, a)
    m, points, size = solids.meshes, work.points, smaller_size(solids, a, b)
    n = rotated(R[plane], row(solids.normal, plane))
    height = dot(n, sub(row(x, mesh), row(x, plane)))
    up = rotated_back(R[mesh], n)
    view = view_along(scaled(n, -1.0) if mesh_is_a else n, limit, MERGE * size)
    offset = ZERO if mesh_is_a else sub(row(x, b), row(x, a))
    count = add_corners(m, solids.shape[mesh], up, height, R[mesh], offset, mesh_is_a, slope, view, work.nodes, points)
    least = inf
    for k in range(count):
        least = min(least, points.gap[k])
    if count == FULL or not least <= reach:
        return min(count, 0)
    corners = lower_points(points, count, hull(points, count, ON_FEATURE * size), SAG * reach)
    work.R[:] = 0.0
    for k in range(3):
        work.R[k, k] = 1.0
    offset = sub(row(x, b), row(x, a))
    return _write(contacts, first, a, b, points, count, corners, view.n, work.R, offset)


@jit
def flat_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of two meshes, or of a mesh and a plane."""
    slope = max(angle, FLAT)
    limit = max(reach, level) if angle > 0.0 else reach
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        return _mesh_on_plane(solids, a, b, x, R, reach, slope, limit, contacts, first, work)
    return _meshes(solids, a, b, x, R, reach, slope, limit, contacts, first, work)


@jit
def flat_gap(solids, a, b, x, R, limit, witness, work):
    """`gap_of_pair` of two meshes, or of a mesh and a plane."""
    m = solids.meshes
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        mesh, plane = (a, b) if solids.kind[b] == PLANE else (b, a)
        n = rotated(R[plane], row(solids.normal, plane))
        height = dot(n, sub(row(x, mesh), row(x, plane)))
        if height - solids.radius[mesh] >= limit:
            return height - solids.radius[mesh]
        return height + lowest_corner(m, solids.shape[mesh], rotated_back(R[mesh], n), work.nodes)
    relative_rotation(R[a], R[b], work.R)
    t = rotated_back(R[a], sub(row(x, b), row(x, a)))
    shape_a, shape_b = solids.shape[a], solids.shape[b]
    distance, _, _, _, witness[0], witness[1] = closest_points(
        m, shape_a, shape_b, work.R, t, limit, witness[0], witness[1], work.walk
    )
    return distance
