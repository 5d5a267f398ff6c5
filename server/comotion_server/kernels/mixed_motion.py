"""Rows of contact of any bodies that are not smooth, on their way: see `contact_motion`."""

from math import inf

from comotion_server.kernels.by_shapes import by_cylinders
from comotion_server.kernels.contacts import BALL_FACE, CORES, PARTS
from comotion_server.kernels.core_contact import refresh_cores
from comotion_server.kernels.flat_motion import refresh_flat
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.round_contact import refresh_round


@lean_jit
def _refresh_none(*_):
    """There are no such rows."""
    return inf, 0.0, 0.0


_refresh_parts = by_cylinders(_refresh_none, "cylinder_contact.refresh_parts")


@lean_jit
def refresh_mixed(solids, contacts, i, x, v, R, w):
    """`refresh` of any row that is not smooth."""
    if contacts.kind[i] == PARTS:
        return _refresh_parts(solids, contacts, i, x, v, R, w)
    if contacts.kind[i] == CORES:
        return refresh_cores(solids, contacts, i, x, v, R, w)
    if contacts.kind[i] >= BALL_FACE:
        return refresh_round(solids, contacts, i, x, v, R, w)
    return refresh_flat(solids, contacts, i, x, v, R, w)
