"""The points of contact and the distance of bodies of which one may be round and the other anything but smooth."""

from comotion_server.kernels.by_shapes import by_cylinders
from comotion_server.kernels.core_contact import are_cores, core_manifold
from comotion_server.kernels.flat_contact import flat_gap, flat_manifold
from comotion_server.kernels.jit import jit
from comotion_server.kernels.mixed_impact import round_gap
from comotion_server.kernels.round_contact import round_manifold
from comotion_server.kernels.solids import CYLINDER, are_flat


@jit
def _no_rows(*_):
    """There are no such pairs."""
    return 0


_beside_cylinder = by_cylinders(_no_rows, "cylinder_on_mesh.any_and_cylinder")


@jit
def mixed_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of any that are not smooth."""
    if are_flat(solids, a, b):
        return flat_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)
    if solids.kind[a] == CYLINDER or solids.kind[b] == CYLINDER:
        return _beside_cylinder(solids, a, b, x, R, reach, angle, level, contacts, first, work)
    if are_cores(solids, a, b):
        return core_manifold(solids, a, b, x, R, reach, angle, level, contacts, first)
    return round_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work)


@jit
def mixed_gap(solids, a, b, x, R, limit, witness, work):
    """`gap_of_pair` of any that are not smooth."""
    if are_flat(solids, a, b):
        return flat_gap(solids, a, b, x, R, limit, witness, work)
    return round_gap(solids, a, b, x, R, limit, witness, work.walk)[0]
