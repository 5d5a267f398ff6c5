"""The contact time of two meshes, or of a mesh and a plane, and whether they are near."""

from comotion_server.kernels.contact_plane import lowest_corner
from comotion_server.kernels.impact_query import distance_left, note_distance
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.mesh_pair import closest_points
from comotion_server.kernels.plane_impact import advance_plane
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.time_of_impact import advance
from comotion_server.kernels.vectors import dot, rotated, rotated_back, row, sub


@lean_jit
def advance_flat(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
    """`advance_pair` of two meshes, or of a mesh and a plane."""
    m = solids.meshes
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        side = 1 if solids.kind[b] == PLANE else 0
        plane, mesh = (b, a) if side == 1 else (a, b)
        shape, normal = solids.shape[mesh], row(solids.normal, plane)
        limits = (end, key, tolerance, budget)
        return advance_plane(m, flights, bodies, shape, normal, side, a, b, *limits, memory, findings, work, counts)
    near = max(min(solids.near[a], solids.near[b]), 4.0 * tolerance)
    shapes, limits = (solids.shape[a], solids.shape[b]), (end, key, tolerance, near, budget)
    return advance(m, flights, bodies, *shapes, a, b, *limits, memory, witness, findings, work, counts)


@lean_jit
def flat_gap_within(solids, a, b, x, R, reach, memory, witness, work):
    """`gap_within` of two meshes, or of a mesh and a plane."""
    m = solids.meshes
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        plane, mesh = (b, a) if solids.kind[b] == PLANE else (a, b)
        n = rotated(R[plane], row(solids.normal, plane))
        offset = dot(n, sub(row(x, mesh), row(x, plane)))
        if offset - solids.radius[mesh] > reach:
            return False
        return offset + lowest_corner(m, solids.shape[mesh], rotated_back(R[mesh], n), work.nodes) <= reach
    relative_rotation(R[a], R[b], work.R)
    offset = rotated_back(R[a], sub(row(x, b), row(x, a)))
    if distance_left(memory, offset, work.R, solids.radius[a], solids.radius[b]) > reach:
        return False
    near = max(min(solids.near[a], solids.near[b]), 2.0 * reach)
    distance, _, _, _, witness[0], witness[1] = closest_points(
        m, solids.shape[a], solids.shape[b], work.R, offset, near, witness[0], witness[1], work.walk
    )
    note_distance(memory, distance, offset, work.R)
    return distance <= reach
