"""The contact time of two bodies of any kinds of shapes."""

from comotion_server.kernels.by_shapes import by_shapes
from comotion_server.kernels.contact_plane import lowest_corner
from comotion_server.kernels.curved_gap import curved_gap
from comotion_server.kernels.curved_impact import advance_curved, axis_of, frame_is_b
from comotion_server.kernels.curved_mesh_gap import curved_mesh_gap
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.mesh_pair import closest_points
from comotion_server.kernels.plane_impact import advance_plane
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.solids import MESH, PLANE
from comotion_server.kernels.sphere_impact import advance_smooth, are_smooth, has_closed_form, smooth_gap
from comotion_server.kernels.time_of_impact import STALLS, advance, distance_left, note_distance
from comotion_server.kernels.vectors import ZERO, dot, rotated, rotated_back, row, scaled, sub


@lean_jit
def _advance_flat(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
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
def _advance_never(*_):
    """There are no such pairs."""
    return STALLS


@lean_jit
def are_flat(solids, a, b):
    """Whether both bodies are meshes or planes."""
    return (solids.kind[a] == MESH or solids.kind[a] == PLANE) and (solids.kind[b] == MESH or solids.kind[b] == PLANE)


@lean_jit
def _advance_mixed(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
    """`advance_pair` of any that have no closed form."""
    limits = (end, key, tolerance, budget)
    if are_flat(solids, a, b):
        return _advance_flat(solids, flights, bodies, a, b, *limits, memory, witness, findings, work, counts)
    return advance_curved(solids, flights, bodies, a, b, *limits, memory, witness, findings, work, counts)


_advance_others = by_shapes(_advance_flat, _advance_never, _advance_mixed)


@lean_jit
def advance_pair(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
    """As `time_of_impact.advance`, for bodies a and b of `solids`; at most one of them is a plane."""
    if has_closed_form(solids, flights, a, b):
        return advance_smooth(solids, flights, a, b, end, key, tolerance, memory, findings)
    limits = (end, key, tolerance, budget)
    return _advance_others(solids, flights, bodies, a, b, *limits, memory, witness, findings, work, counts)


@lean_jit
def _flat_gap_within(solids, a, b, x, R, reach, memory, witness, work):
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


@lean_jit
def _never_within(*_):
    """There are no such pairs."""
    return False


@lean_jit
def round_gap(solids, a, b, x, R, reach, witness, walk):
    """(gap [m], normal from a to b, world) of a round shape and any other; exact below `reach` [m]."""
    frame, i = (b, a) if frame_is_b(solids, a, b) else (a, b)
    D, kind, size, u = sub(row(x, i), row(x, frame)), solids.kind[i], solids.size[i], row(solids.axis, i)
    if solids.kind[frame] == MESH:
        m, shape, room = solids.meshes, solids.shape[frame], (walk[0][:, 0], walk[1])
        gap, _, _, n, witness[0] = curved_mesh_gap(
            m, shape, ZERO, R[frame], kind, size, u, D, R[i], reach, witness[0], *room
        )
    else:
        seen = (solids.kind[frame], solids.size[frame], axis_of(solids, frame), ZERO, R[frame])
        gap, _, _, n = curved_gap(*seen, kind, size, u, D, R[i])
    return gap, (scaled(n, -1.0) if frame == b else n)


@lean_jit
def _mixed_gap_within(solids, a, b, x, R, reach, memory, witness, work):
    """`gap_within` of any that are not smooth."""
    if are_flat(solids, a, b):
        return _flat_gap_within(solids, a, b, x, R, reach, memory, witness, work)
    return round_gap(solids, a, b, x, R, 2.0 * reach, witness, work.walk)[0] <= reach


_other_gap_within = by_shapes(_flat_gap_within, _never_within, _mixed_gap_within)


@lean_jit
def gap_within(solids, a, b, x, R, reach, memory, witness, work):
    """Whether the gap of bodies a and b at x (n,3), R (n,3,3) is at most `reach` [m].

    What is remembered of their distance may settle it; else it is found, and remembered.
    """
    if are_smooth(solids, a, b):
        return smooth_gap(solids, a, b, row(x, a), row(x, b), R[a], R[b])[0] <= reach
    return _other_gap_within(solids, a, b, x, R, reach, memory, witness, work)
