"""A point of contact on its way: frozen features at another pose and other velocities (docs/contacts.md).

For every kind of features the gap is g = n . (Q - P) with a unit normal n(t) and points P of a, Q of b, *any* points of
the two features, so material ones may be taken; with those now at the contact, Q - P = g n,
  g'  = n . (Q' - P'),    g'' = n . (Q'' - P'') + 2 n' . (Q' - P') - g n'^2,
because n . n'' = -n'^2 for a unit vector. The acceleration of a point is that of its centre, plus that of the rotation
x arm, plus w x (w x arm); *bias* is all of g'' that velocities alone make. n' is w x n for the normal of a face, and
comes from the edges' turning, or from the points' own motion, where these make the normal.
"""

from math import inf

from comotion_server.kernels.by_shapes import by_shapes
from comotion_server.kernels.contacts import SMOOTH
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.smooth_contact import refresh_smooth


@lean_jit
def _refresh_none(*_):
    """There are no such rows."""
    return inf, 0.0, 0.0


_refresh_others = by_shapes("flat_motion.refresh_flat", _refresh_none, "mixed_motion.refresh_mixed")


@lean_jit
def refresh(solids, contacts, i, x, v, R, w):
    """Row i of the contacts at another pose and other velocities of its two bodies: (margin, opening, bias).

    x, v, w (n, 3), R (n, 3, 3) of all bodies, world. In place: normal, arms and gap of the row; a corner on a flat face
    goes from triangle to triangle. margin [m]: inside the face or the edges, above zero while it lies on them; inf for
    a plane, or far from edges. opening: speed of the gap [m/s]. bias [m/s2]: its second derivative is
    n . (a_b + alpha_b x arm_b - a_a - alpha_a x arm_a) + bias with accelerations a of the centres and alpha.
    """
    if contacts.kind[i] == SMOOTH:
        return refresh_smooth(solids, contacts, i, x, v, R, w)
    return _refresh_others(solids, contacts, i, x, v, R, w)
