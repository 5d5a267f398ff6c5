"""What is asked of the contacts of bodies that may come to rest: where they are, how fast they open, who gives way."""

from math import inf

from comotion_server.kernels.cluster_rows import cluster_of, rows_along
from comotion_server.kernels.contact_manifold import gap_of_pair, manifold
from comotion_server.kernels.contact_motion import refresh
from comotion_server.kernels.contacts import FULL
from comotion_server.kernels.flight import begin
from comotion_server.kernels.held_flight import turn_to
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.rotation import rotate_left
from comotion_server.kernels.vectors import length, row


@lean_jit
def contacts_of_pairs(solids, pairs, x, R, reach, angle, level, contacts, pair_of, work):
    """All contacts of pairs (p,2) within their reach (p,) [m], patches as in `manifold`: how many, or FULL.

    pair_of (c,): the pair that a contact belongs to.
    """
    count = 0
    for k in range(len(pairs)):
        rows = manifold(solids, pairs[k, 0], pairs[k, 1], x, R, reach[k], angle, level[k], contacts, count, work)
        if rows == FULL:
            return FULL
        pair_of[count : count + rows] = k
        count += rows
    return count


@lean_jit
def gaps_of_pairs(solids, pairs, x, R, limit, witness, gap, work):
    """Distances gap (p,) [m] of pairs (p,2) as by `gap_of_pair`, exact below limit (p,); witness (p,2) is changed."""
    for k in range(len(pairs)):
        gap[k] = gap_of_pair(solids, pairs[k, 0], pairs[k, 1], x, R, limit[k], witness[k], work)


@lean_jit
def opening_speeds(solids, contacts, count, state, speed, scale):
    """Speeds (c,) [m/s] at which the gaps open, and what the bodies' own speeds are there: rounding is of these."""
    x, v, R, _, w = state
    for i in range(count):
        _, speed[i], _ = refresh(solids, contacts, i, x, v, R, w)
        a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
        scale[i] = length(row(v, a)) + length(row(v, b))
        scale[i] += length(row(w, a)) * length(row(contacts.arm_a, i)) + length(row(w, b)) * length(
            row(contacts.arm_b, i)
        )


@lean_jit
def gaps_at(solids, contacts, count, state, gap):
    """Gaps (c,) [m] of contacts at other poses; inf where a point has left its face or edges. Moves the contacts."""
    x, v, R, _, w = state
    for i in range(count):
        margin, _, _ = refresh(solids, contacts, i, x, v, R, w)
        gap[i] = contacts.gap[i] if margin >= 0.0 else inf


@jit
def eases(bodies, contacts, count, R, ease):
    """How easily (c,) [1/kg] an impulse along each contact's normal opens it: one over the effective mass."""
    rows = rows_along(cluster_of(bodies, contacts, count, R), contacts, contacts.normal[:count])
    for i in range(count):
        ease[i] = rows.size[i] ** 2


@jit
def move(bodies, rows, part, shift, turn, state):
    """Moves the bodies in `rows` by a part of shift (n,3) [m] and of the small rotations turn (n,3) [rad]."""
    x, _, R, L, w = state
    for i in rows:
        for k in range(3):
            x[i, k] += part * shift[i, k]
        rotate_left(R[i], part * turn[i, 0], part * turn[i, 1], part * turn[i, 2])
        turn_to(bodies, i, R, L, w)


@jit
def begin_rows(flights, bodies, rows, acceleration, torque, time, state):
    """Bodies in `rows` begin flights at a state under accelerations and torques (n,3)."""
    x, v, R, L, w = state
    for i in rows:
        flights.acceleration[i], flights.torque[i] = row(acceleration, i), row(torque, i)
        begin(flights, bodies, i, time, x[i], v[i], R[i], L[i], w[i])


@jit
def kinetic_energy(bodies, rows, v, L, w):
    """Of the reacting bodies in `rows` [J]."""
    total = 0.0
    for i in rows:
        if bodies.reacts[i]:
            for k in range(3):
                if bodies.inverse_mass[i, k] > 0.0:
                    total += 0.5 * v[i, k] * v[i, k] / bodies.inverse_mass[i, k]
                total += 0.5 * L[i, k] * w[i, k]
    return total
