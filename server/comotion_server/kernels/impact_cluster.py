"""Answers to a cluster of contacts, all by one projection P in the mass metric.

    collide(bodies, contacts, count, restitution, friction, law, v, R, L, w, impulse, report) -> status
        an impact of the first `count` contacts: changes v, L, w of the reacting bodies
    hold(bodies, contacts, count, bias, force, torque, R, L, w, acceleration, change, pressing, certificate) -> status
        contact forces of contacts that are held: y = P(M^-1 F), one-sided, without friction
    settle_velocities(bodies, contacts, count, equal, target, v, R, L, w, impulse, certificate) -> status
        the least change of motion that gives chosen contacts their opening speeds
    displacements(bodies, contacts, count, equal, target, R, shift, turn, certificate) -> status
        the least move of the bodies that gives chosen contacts their change of gap

Status: SOLVED; CAPPED, velocities are sound but reflections or steps ran out and the rest was taken plastically;
JAMMED, contacts press on each other with no net push, so no elastic answer exists and energy was lost; BLOCKED, no
motion satisfies the contacts marked in the certificate, or none but one that hurls bodies out of a pinch: nothing was
changed. Contacts that are held have no friction.

A body that does not react, and what is locked or prescribed, moves as given. Members and rows are taken in the order of
body rows and contacts: the same input gives the same bits. All arrays of bodies have n rows, world frame, SI.
"""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.cluster_projection import project_cluster
from comotion_server.kernels.cluster_rows import (
    Cluster,
    along_row,
    bounds_along,
    change_velocities,
    cluster_of,
    rows_along,
    scaled_velocities,
)
from comotion_server.kernels.dual_active_set import BLOCKED, CAPPED, JAMMED, SOLVED
from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.friction import rub
from comotion_server.kernels.jit import jit
from comotion_server.kernels.pinches import given_spread, hurls
from comotion_server.kernels.reflections import LOST, RUBBED, WORK, approaches, largest_of, reflect, who_approaches
from comotion_server.kernels.sequential_impacts import take_turns
from comotion_server.kernels.single_impact import collide_one
from comotion_server.kernels.vectors import cross, dot, length, row, sub

__all__ = ["BLOCKED", "CAPPED", "JAMMED", "LOST", "RUBBED", "SOLVED", "WORK", "Cluster"]

TOGETHER, SEQUENTIAL = 0, 1  # laws
REPEATS = 5  # of restitution and friction; a last one has neither
SOUND = 1e-6  # of the energy of a change: what multipliers may do against their bounds
NOTHING = 1e-14  # of the energy before: the same, where hardly anything changes
WEAK = 1e-6  # relative: equalities closer to the span of others are left out; patches whose normals differ by 1e-8 tilt


class Report(NamedTuple):
    """What an impact did: kinetic energy changes by WORK - LOST - RUBBED."""

    approach: np.ndarray  # (c,) speed at which a contact closed before [m/s]; negative: it opened
    certificate: np.ndarray  # (c,) bool BLOCKED: contacts that no motion satisfies together
    book: np.ndarray  # (3,) [J] LOST to restitution (and plastic contact), WORK of motion that is given, RUBBED to heat
    reflections: np.ndarray  # (1,) int64 reflections or impacts it took


@jit
def new_report(capacity):
    """Room for a report on up to `capacity` contacts."""
    return Report(np.zeros(capacity), np.zeros(capacity, np.bool_), np.zeros(3), np.zeros(1, np.int64))


@jit
def add_impulses(sizes, directions, impulse):
    """Adds impulses of sizes (c,) along unit directions (c,3) to impulse (c,3)."""
    for i in range(len(sizes)):
        for k in range(3):
            impulse[i, k] += sizes[i] * directions[i, k]


@jit
def collide(bodies, contacts, count, restitution, friction, law, v, R, L, w, impulse, report):
    """Answers the impact of `count` contacts with restitution (c,) and friction (c,): status.

    Changes v, L, w (n,3); writes impulse (c,3) [N s] on body b of each contact, and the report. With friction, the
    law's answer is rubbed; if that makes another contact close, both are repeated, at last without rebound or friction.
    """
    report.book[:] = 0.0
    rubs = largest_of(friction[:count]) > 0.0
    if count == 1 and not rubs:
        return collide_one(bodies, contacts, restitution[0], v, R, L, w, impulse, report)
    normals, e = contacts.normal[:count], restitution[:count].copy()
    cluster = cluster_of(bodies, contacts, count, R)
    rows, bounds = rows_along(cluster, contacts, normals), bounds_along(bodies, contacts, normals, v, w)
    x, closing = scaled_velocities(cluster, v, L), np.empty(count, np.bool_)
    now, speeds = np.empty(count), np.empty(count)
    before, turned, plastic, status = x.copy(), np.empty(count), np.zeros(count), SOLVED
    fastest, hardest = approaches(rows, bounds, x, speeds)
    for i in range(count):
        report.approach[i] = -speeds[i]
    impulse[:count] = 0.0
    report.reflections[0] = 0
    for repeat in range(REPEATS + 1):
        if repeat == REPEATS:
            e[:] = 0.0
        turned[:] = 0.0
        if law == SEQUENTIAL:
            state, done = take_turns(rows, bounds, e, x, turned, report.book)
            status, report.reflections[0] = max(status, state), report.reflections[0] + done
        rebound = e if law == TOGETHER else plastic
        state, done = reflect(rows, bounds, rebound, x, now, report.book, report.certificate[:count])
        status, report.reflections[0] = max(status, state), report.reflections[0] + done
        if status == BLOCKED:
            impulse[:count] = 0.0
            report.book[:] = 0.0
            return status
        for i in range(count):
            now[i] += turned[i]
        if rubs and repeat < REPEATS:
            rub(bodies, contacts, cluster, (rows, bounds), friction, v, w, x, now, impulse, report.book)
        add_impulses(now, normals, impulse)
        approaches(rows, bounds, x, speeds)
        if not rubs or not who_approaches(rows, speeds, fastest, hardest, closing):
            break
    spread = given_spread(bodies, contacts, count, v, w)
    if spread > 0.0 and hurls(cluster, contacts, before, x, max(spread, fastest)):
        for i in range(count):
            report.certificate[i] = length(row(impulse, i)) > 0.0
        impulse[:count] = 0.0
        report.book[:] = 0.0
        return BLOCKED
    change_velocities(bodies, cluster, R, before, x, v, L, w)
    return status


@jit
def free_accelerations(bodies, cluster, force, torque, L, w):
    """Unknowns (k,6) of acceleration under force, torque (n,3) and the gyroscopic moment, without contacts."""
    y = np.zeros((len(cluster.members), 6))
    for j in range(len(cluster.members)):
        i = cluster.members[j]
        moment = row(torque, i)
        if bodies.spin[i] == SPIN_FREE:
            moment = sub(moment, cross(row(w, i), row(L, i)))
        for k in range(3):
            y[j, k] = force[i, k] * cluster.ease[j, k]
            y[j, 3 + k] = dot(row(cluster.axes[j], k), moment) * cluster.ease[j, 3 + k]
    return y


@jit
def hold(bodies, contacts, count, bias, force, torque, R, L, w, acceleration, change, pressing, certificate):
    """Contact forces that keep `count` contacts from closing: status.

    The gap of contact i opens with n.(a_b + al_b x r_b - a_a - al_a x r_a) + bias (c,) [m/s2] >= 0; bias holds what
    depends on velocities, and the accelerations of bodies that do not react. force, torque (n,3) act besides, gravity
    included, torque about the centres of mass. Writes for the reacting bodies of the cluster: acceleration (n,3) and
    change (n,3) of the angular momentum [N m], by torque and contacts; pressing (c,) >= 0 [N] along the normal on b;
    certificate (c,).
    """
    cluster = cluster_of(bodies, contacts, count, R)
    rows = rows_along(cluster, contacts, contacts.normal[:count])
    x = free_accelerations(bodies, cluster, force, torque, L, w)
    y, chosen, equal = np.empty_like(x), np.ones(count, np.bool_), np.zeros(count, np.bool_)
    status, _ = project_cluster(rows, -bias[:count], chosen, equal, 0.0, x, y, pressing[:count], certificate[:count])
    if status == BLOCKED:
        return status
    for j in range(len(cluster.members)):
        i = cluster.members[j]
        for k in range(3):
            acceleration[i, k] = y[j, k] * cluster.ease[j, k]
            change[i, k] = torque[i, k] if bodies.spin[i] in (SPIN_FREE, k) else 0.0
        for k in range(3):
            moment = (y[j, 3 + k] - x[j, 3 + k]) / cluster.ease[j, 3 + k] if cluster.ease[j, 3 + k] > 0.0 else 0.0
            for m in range(3):
                change[i, m] += cluster.axes[j, k, m] * moment
    return status


@jit
def is_sound(rows, bounds, multiplier, x, y):
    """Whether y (k,6) is the nearest to x (k,6): no multiplier (c,) but where its row is at its bound (c,).

    Rows that depend on others but for rounding have multipliers so large that nothing is left of y.
    """
    change = before = slack = 0.0
    for j in range(len(x)):
        for k in range(6):
            change += (y[j, k] - x[j, k]) ** 2
            before += x[j, k] ** 2
    for i in range(len(multiplier)):
        if multiplier[i] != 0.0:
            slack += multiplier[i] * (along_row(rows, i, y) - bounds[i])
    return abs(slack) <= SOUND * change + NOTHING * before


@jit
def settle_velocities(bodies, contacts, count, equal, target, v, R, L, w, impulse, certificate):
    """Least change of motion: contacts open at target (c,) [m/s] where equal (c,) bool, else at least so fast: status.

    Changes v, L, w (n,3) unless BLOCKED, as are equalities that depend on other rows but for rounding (no certificate),
    or CAPPED where the same is true without any. Writes certificate (c,) and impulse (c,) [N s] along the normal on b,
    negative where an equality pulls.
    """
    normals = contacts.normal[:count]
    cluster = cluster_of(bodies, contacts, count, R)
    rows = rows_along(cluster, contacts, normals)
    bounds = bounds_along(bodies, contacts, normals, v, w) + target[:count]
    x = scaled_velocities(cluster, v, L)
    y, chosen = np.empty_like(x), np.ones(count, np.bool_)
    status, _ = project_cluster(rows, bounds, chosen, equal[:count], WEAK, x, y, impulse[:count], certificate[:count])
    if status == BLOCKED:
        return status
    if not is_sound(rows, bounds, impulse[:count], x, y):
        impulse[:count] = 0.0
        return BLOCKED if equal[:count].any() else CAPPED
    spread, fastest = given_spread(bodies, contacts, count, v, w), 0.0
    for i in range(count):
        fastest = max(fastest, bounds[i] - along_row(rows, i, x))
    if spread > 0.0 and hurls(cluster, contacts, x, y, max(spread, fastest)):
        for i in range(count):
            certificate[i] = impulse[i] > 0.0
        return BLOCKED
    change_velocities(bodies, cluster, R, x, y, v, L, w)
    return status


@jit
def displacements(bodies, contacts, count, equal, target, R, shift, turn, certificate):
    """Least move that opens gaps by target (c,) [m] where equal (c,) bool, else by at least as much: status.

    Writes shift (n,3) [m] of the centres and turn (n,3) [rad], a small world rotation, of the reacting bodies of the
    cluster (zero if BLOCKED, as also where the move would be one of rounding), and certificate (c,).
    """
    cluster = cluster_of(bodies, contacts, count, R)
    rows = rows_along(cluster, contacts, contacts.normal[:count])
    x = np.zeros((len(cluster.members), 6))
    y, chosen, multiplier = np.empty_like(x), np.ones(count, np.bool_), np.empty(count)
    status, _ = project_cluster(
        rows, target[:count], chosen, equal[:count], WEAK, x, y, multiplier, certificate[:count]
    )
    if status != BLOCKED and not is_sound(rows, target, multiplier, x, y):
        status = BLOCKED
    for j in range(len(cluster.members)):
        i = cluster.members[j]
        for k in range(3):
            shift[i, k], turn[i, k] = y[j, k] * cluster.ease[j, k], 0.0
        for k in range(3):
            for m in range(3):
                turn[i, m] += cluster.axes[j, k, m] * y[j, 3 + k] * cluster.ease[j, 3 + k]
        if status == BLOCKED:
            shift[i, :], turn[i, :] = 0.0, 0.0
    return status
