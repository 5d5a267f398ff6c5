"""Bodies squeezed between motions that are given, hard enough to be hurled aside: as good as blocked.

The velocities that would satisfy the contacts grow without bound as a pinch closes: a hull at half a metre a second
shoots a floe at hundreds. That would be true of an infinitely strong hull; no hull is.
"""

from comotion_server.kernels.cluster_rows import NOT_REACTING
from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.jit import jit
from comotion_server.kernels.vectors import ZERO, add, along, cross, length, row, sub

MOST_HURLED = 100.0  # times the given motions' difference, or the approach: faster answers are taken as impossible


@jit
def _is_given(bodies, i):
    """Whether part of the motion of body i is given."""
    if not bodies.reacts[i] or bodies.spin[i] != SPIN_FREE:
        return True
    return min(bodies.inverse_mass[i, 0], bodies.inverse_mass[i, 1], bodies.inverse_mass[i, 2]) == 0.0


@jit
def given_spread(bodies, contacts, count, v, w):
    """How much the velocities differ [m/s] that contact points have by motion that is given; what is locked rests."""
    first, found, spread = ZERO, False, 0.0
    for i in range(count):
        for side in range(2):
            body = contacts.bodies[i, side]
            if not _is_given(bodies, body):
                continue
            u = ZERO
            if not bodies.reacts[body]:
                arm = row(contacts.arm_a, i) if side == 0 else row(contacts.arm_b, i)
                u = add(row(v, body), cross(row(w, body), arm))
            if not found:
                first, found = u, True
            spread = max(spread, length(sub(u, first)))
    return spread


@jit
def hurls(cluster, contacts, before, after, least):
    """Whether unknowns (k,6) that change so would change the velocity of a contact point by much more than `least`."""
    for i in range(len(cluster.link)):
        for side in range(2):
            j = cluster.link[i, side]
            if j == NOT_REACTING:
                continue
            arm = row(contacts.arm_a, i) if side == 0 else row(contacts.arm_b, i)
            turn = ZERO
            for k in range(3):
                turn = along(
                    turn, (after[j, 3 + k] - before[j, 3 + k]) * cluster.ease[j, 3 + k], row(cluster.axes[j], k)
                )
            change = (
                (after[j, 0] - before[j, 0]) * cluster.ease[j, 0],
                (after[j, 1] - before[j, 1]) * cluster.ease[j, 1],
                (after[j, 2] - before[j, 2]) * cluster.ease[j, 2],
            )
            if length(add(change, cross(turn, arm))) > MOST_HURLED * least:
                return True
    return False
