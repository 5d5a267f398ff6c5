"""All points at which two bodies touch, as few as say all of it (docs/contacts.md).

Everything is computed in the axes of body a from its centre, so a scene far from the world's origin keeps its digits.
"""

from math import inf

from comotion_server.kernels.by_shapes import by_shapes
from comotion_server.kernels.jit import jit
from comotion_server.kernels.smooth_contact import smooth_manifold
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.sphere_impact import are_smooth, smooth_gap
from comotion_server.kernels.vectors import row


@jit
def _no_manifold(*_):
    """There are no such pairs."""
    return 0


_other_manifold = by_shapes("flat_contact.flat_manifold", _no_manifold, "mixed_contact.mixed_manifold")


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
def _no_gap(*_):
    """There are no such pairs."""
    return inf


_other_gap = by_shapes("flat_contact.flat_gap", _no_gap, "mixed_contact.mixed_gap")


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
