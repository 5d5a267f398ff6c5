"""All points at which two bodies touch, as few as say all of it (docs/contacts.md).

Everything is computed in the axes of body a from its centre, so a scene far from the world's origin keeps its digits.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.by_shapes import by_cylinders, by_shapes
from comotion_server.kernels.contact_hull import PatchPoints, hull, lower_points, new_points, view_along
from comotion_server.kernels.contact_normals import (
    FULL,
    OF_A,
    OF_B,
    Directions,
    new_directions,
)
from comotion_server.kernels.contact_pairs import new_pairs, touching_pairs, tree_of
from comotion_server.kernels.contact_patch import Rules, patch_points
from comotion_server.kernels.contact_plane import add_corners, lowest_corner
from comotion_server.kernels.contacts import FEATURES
from comotion_server.kernels.core_contact import are_cores, core_manifold
from comotion_server.kernels.cylinder_contact import cylinder_manifold, has_cylinder
from comotion_server.kernels.cylinder_on_mesh import mesh_and_cylinder
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.level_faces import surface_of
from comotion_server.kernels.mesh_pair import closest_points, work_space
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.round_contact import round_manifold
from comotion_server.kernels.smooth_contact import smooth_manifold
from comotion_server.kernels.solid_impact import are_flat, round_gap
from comotion_server.kernels.solids import MESH, PLANE
from comotion_server.kernels.sphere_impact import are_smooth, smooth_gap
from comotion_server.kernels.topology import FLAT
from comotion_server.kernels.vectors import ZERO, dot, rotated, rotated_back, row, scaled, sub

MERGE = 1e-7  # of the smaller body's size: points of contact nearer than this are one
OBLIQUE = (0.4472, 0.6325, 0.6324)  # to whatever is likely in a scene: patches are told in its order
ON_FEATURE = 1e-9  # of the same: how far outside a face or an edge a point still lies on it
SAG = 0.1  # of the reach: how much lower than all corners of a patch a point inside it matters


class PatchWork(NamedTuple):
    """Arrays that `manifold` and `gap_of_pair` use; nothing in them means anything before or after."""

    pairs: np.ndarray  # (p,2) int64 triangles of a, of b
    nodes: np.ndarray  # (STACK_SIZE,2) int64 of a walk
    directions: Directions
    points: PatchPoints
    R: np.ndarray  # (3,3) from b's axes to a's
    walk: tuple[np.ndarray, ...]  # of the distance


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
def _flat_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of two meshes, or of a mesh and a plane."""
    slope = max(angle, FLAT)
    limit = max(reach, level) if angle > 0.0 else reach
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        return _mesh_on_plane(solids, a, b, x, R, reach, slope, limit, contacts, first, work)
    return _meshes(solids, a, b, x, R, reach, slope, limit, contacts, first, work)


@jit
def _no_manifold(*_):
    """There are no such pairs."""
    return 0


@lean_jit
def _cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of a cylinder and anything."""
    if solids.kind[a] == MESH or solids.kind[b] == MESH:
        return mesh_and_cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work)
    return cylinder_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)


_beside_cylinder = by_cylinders(_no_manifold, _cylinder)


@jit
def _mixed_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of any that are not smooth."""
    if are_flat(solids, a, b):
        return _flat_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)
    if has_cylinder(solids, a, b):
        return _beside_cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work)
    if are_cores(solids, a, b):
        return core_manifold(solids, a, b, x, R, reach, angle, level, contacts, first)
    return round_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)


_other_manifold = by_shapes(_flat_manifold, _no_manifold, _mixed_manifold)


@jit
def manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """All points of contact of bodies a < b at this pose; how many rows, or FULL where there is no room for them.

    x (n, 3) [m], R (n, 3, 3) of all bodies. Every direction along which surfaces are within `reach` [m] gives a patch:
    rows with one normal, the corners of the convex hull of all that is level in it, counter-clockwise about it, and
    the points inside that lie lower than them.
    angle > 0 [rad]: faces and edges within this angle count as level, and points of such a patch up to the gap `level`
    [m]; angle = 0: points up to `reach` alone. Rows are written to contacts[first :]; work: of `new_patch_work`.
    """
    if are_smooth(solids, a, b):
        return smooth_manifold(solids, a, b, x, R, reach, contacts, first)
    if solids.kind[a] == PLANE and solids.kind[b] == PLANE:
        return 0
    return _other_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)


@jit
def _flat_gap(solids, a, b, x, R, limit, witness, work):
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


@jit
def _no_gap(*_):
    """There are no such pairs."""
    return inf


@jit
def _mixed_gap(solids, a, b, x, R, limit, witness, work):
    """`gap_of_pair` of any that are not smooth."""
    if are_flat(solids, a, b):
        return _flat_gap(solids, a, b, x, R, limit, witness, work)
    return round_gap(solids, a, b, x, R, limit, witness, work.walk)[0]


_other_gap = by_shapes(_flat_gap, _no_gap, _mixed_gap)


@jit
def gap_of_pair(solids, a, b, x, R, limit, witness, work):
    """The distance of two bodies [m], exact below `limit`, otherwise a lower bound that is not below it.

    In and out: witness (2,) int64, the closest triangles (over all shapes), to begin with; -1: none. Not used, and left
    alone, where one is a plane; from a plane the distance is negative below it. Two planes never meet: inf.
    """
    if are_smooth(solids, a, b):
        return smooth_gap(solids, a, b, row(x, a), row(x, b), R[a], R[b])[0]
    if solids.kind[a] == PLANE and solids.kind[b] == PLANE:
        return inf
    return _other_gap(solids, a, b, x, R, limit, witness, work)
