"""The contact time of two bodies of any kinds of shapes."""

from comotion_server.kernels.jit import jit
from comotion_server.kernels.plane_impact import advance_plane
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.time_of_impact import advance
from comotion_server.kernels.vectors import row


@jit
def advance_pair(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
    """As `time_of_impact.advance`, for bodies a and b of `solids`; at most one of them is a plane."""
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
