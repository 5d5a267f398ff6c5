"""The books of an impact of many contacts (VALIDATION B): what the bodies carry before and after, against the impulses.

What fixed, prescribed, locked or non-reacting bodies take is external: only the part of an impulse that a body's free
directions take up counts. Legend: as in `books`; ledger (7,): momentum, angular momentum about a point c, energy.
"""

from comotion_server.kernels.books import carried, errors, size_of
from comotion_server.kernels.cluster_rows import arm_to_middle
from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.impact_cluster import LOST, WORK
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import cross, lever, row, scaled, sub


@lean_jit
def carried_by(bodies, members, x, v, L, w, c, ledger, scale):
    """What the bodies in `members` (k,) carry, to ledger (7,), and the scales (3,) of their momenta, added."""
    ledger[:] = 0.0
    for i in members:
        carried(bodies, i, x, v, L, w, c, ledger)
        momentum, spin = size_of(bodies, i, x, v, L, c)
        scale[0] += momentum
        scale[1] += spin
    scale[2] += ledger[6]


@lean_jit
def _taken_up(bodies, i, x, arm, J, c, ledger):
    """Adds what impulse J at `arm` from the centre of body i gives to what it carries."""
    if not bodies.reacts[i]:
        return
    W, spin, turn = row(bodies.inverse_mass, i), bodies.spin[i], lever(arm, J)
    p = (J[0] if W[0] > 0.0 else 0.0, J[1] if W[1] > 0.0 else 0.0, J[2] if W[2] > 0.0 else 0.0)
    m = cross(sub(row(x, i), c), p)
    for k in range(3):
        ledger[k] += p[k]
        ledger[3 + k] += m[k] + (turn[k] if spin in (SPIN_FREE, k) else 0.0)


@lean_jit
def given_by(bodies, contacts, count, x, impulse, book, c, ledger):
    """What `count` contacts with impulse (c,3) on b give to the bodies, and the energy by the law's book."""
    ledger[:] = 0.0
    for i in range(count):
        J = row(impulse, i)
        _taken_up(bodies, contacts.bodies[i, 0], x, arm_to_middle(contacts, i, 0), scaled(J, -1.0), c, ledger)
        _taken_up(bodies, contacts.bodies[i, 1], x, arm_to_middle(contacts, i, 1), J, c, ledger)
    ledger[6] = book[WORK] - book[LOST]


@lean_jit
def audit(before, after, given, scale, found, worst):
    """Relative errors of the balance, to found (3,); worst (3,) keeps the largest ever."""
    for k in range(3):
        scale[k] = max(scale[k], 1e-300)
    errors(before, after, given, scale, found)
    for k in range(3):
        worst[k] = max(worst[k], found[k])
