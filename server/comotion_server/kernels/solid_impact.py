"""The contact time of two bodies of any kinds of shapes."""

from comotion_server.kernels.by_shapes import by_shapes
from comotion_server.kernels.impact_query import STALLS
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.sphere_impact import advance_smooth, are_smooth, has_closed_form, smooth_gap
from comotion_server.kernels.vectors import row


@lean_jit
def _advance_never(*_):
    """There are no such pairs."""
    return STALLS


_advance_others = by_shapes("flat_impact.advance_flat", _advance_never, "mixed_impact.advance_mixed")


@lean_jit
def advance_pair(solids, flights, bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts):
    """As `time_of_impact.advance`, for bodies a and b of `solids`; at most one of them is a plane."""
    if has_closed_form(solids, flights, a, b):
        return advance_smooth(solids, flights, a, b, end, key, tolerance, memory, findings)
    limits = (end, key, tolerance, budget)
    return _advance_others(solids, flights, bodies, a, b, *limits, memory, witness, findings, work, counts)


@lean_jit
def _never_within(*_):
    """There are no such pairs."""
    return False


_other_gap_within = by_shapes("flat_impact.flat_gap_within", _never_within, "mixed_impact.mixed_gap_within")


@lean_jit
def gap_within(solids, a, b, x, R, reach, memory, witness, work):
    """Whether the gap of bodies a and b at x (n,3), R (n,3,3) is at most `reach` [m].

    What is remembered of their distance may settle it; else it is found, and remembered.
    """
    if are_smooth(solids, a, b):
        return smooth_gap(solids, a, b, row(x, a), row(x, b), R[a], R[b])[0] <= reach
    return _other_gap_within(solids, a, b, x, R, reach, memory, witness, work)
