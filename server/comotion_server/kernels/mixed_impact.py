"""The contact time and the distance of bodies of which one may be round and the other anything but smooth."""

from comotion_server.kernels.curved_gap import curved_gap
from comotion_server.kernels.curved_impact import advance_curved, axis_of, frame_is_b
from comotion_server.kernels.curved_mesh_gap import curved_mesh_gap
from comotion_server.kernels.flat_impact import advance_flat, flat_gap_within
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.solids import MESH, are_flat
from comotion_server.kernels.vectors import ZERO, row, scaled, sub


@lean_jit
def advance_mixed(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
    """`advance_pair` of any that have no closed form."""
    limits = (end, key, tolerance, budget)
    if are_flat(solids, a, b):
        return advance_flat(solids, flights, bodies, a, b, *limits, memory, witness, findings, work, counts)
    return advance_curved(solids, flights, bodies, a, b, *limits, memory, witness, findings, work, counts)


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
def mixed_gap_within(solids, a, b, x, R, reach, memory, witness, work):
    """`gap_within` of any that are not smooth."""
    if are_flat(solids, a, b):
        return flat_gap_within(solids, a, b, x, R, reach, memory, witness, work)
    return round_gap(solids, a, b, x, R, 2.0 * reach, witness, work.walk)[0] <= reach
