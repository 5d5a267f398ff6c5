"""Answers to a cluster of contacts, all by one projection P in the mass metric.

    collide(bodies, contacts, count, restitution, friction, law, v, R, L, w, impulse, report) -> status
        an impact of the first `count` contacts: changes v, L, w of the reacting bodies
    hold(bodies, contacts, count, bias, force, torque, R, L, w, acceleration, change, pressing, certificate) -> status
        contact forces of contacts that are held: y = P(M^-1 F), one-sided, without friction
    settle_velocities(bodies, contacts, count, equal, target, v, R, L, w, impulse, certificate) -> status
        the least change of motion that gives chosen contacts their opening speeds
    displacements(bodies, contacts, count, equal, target, R, shift, turn, certificate) -> status
        the least move of the bodies that gives chosen contacts their change of gap

Status: SOLVED; CAPPED, velocities are sound but reflections or steps ran out and the rest was taken plastically; JAMMED,
contacts press on each other with no net push, so no elastic answer exists and energy was lost; BLOCKED, no motion
satisfies the contacts marked in the certificate: nothing was changed.

A body that does not react, and what is locked or prescribed, moves as given. Members and rows are taken in the order of
body rows and contacts: the same input gives the same bits. All arrays of bodies have n rows, world frame, SI.
"""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.cluster_projection import project_cluster
from comotion_server.kernels.cluster_rows import (
    Cluster,
    bounds_along,
    change_velocities,
    cluster_of,
    rows_along,
    scaled_velocities,
)
from comotion_server.kernels.dual_active_set import BLOCKED, CAPPED, JAMMED, SOLVED
from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.jit import jit
from comotion_server.kernels.reflections import LOST, WORK, approaches, reflect
from comotion_server.kernels.sequential_impacts import take_turns
from comotion_server.kernels.single_impact import collide_one
from comotion_server.kernels.vectors import cross, dot, row, sub

__all__ = ["BLOCKED", "CAPPED", "JAMMED", "LOST", "SOLVED", "WORK", "Cluster"]

TOGETHER, SEQUENTIAL = 0, 1  # laws
WEAK = 1e-6  # relative: equalities closer to the span of others are left out; patches whose normals differ by 1e-8 tilt


class Report(NamedTuple):
    """What an impact did: kinetic energy changes by work - lost."""

    approach: np.ndarray  # (c,) speed at which a contact closed before [m/s]; negative: it opened
    certificate: np.ndarray  # (c,) bool BLOCKED: contacts that no motion satisfies together
    book: np.ndarray  # (2,) [J] LOST to restitution (and plastic contact), WORK of motion that is given
    reflections: np.ndarray  # (1,) int64 reflections or impacts it took


@jit
def new_report(capacity):
    """Room for a report on up to `capacity` contacts."""
    return Report(np.zeros(capacity), np.zeros(capacity, np.bool_), np.zeros(2), np.zeros(1, np.int64))


@jit
def impossible(rows, bounds, x, certificate):
    """Whether no motion satisfies all rows; without given motion rest always does. Marks certificate (c,)."""
    certificate[: len(bounds)] = False
    if not bounds.any():
        return False
    count = len(bounds)
    everywhere, equal = np.ones(count, np.bool_), np.zeros(count, np.bool_)
    status, _ = project_cluster(
        rows, bounds, everywhere, equal, 0.0, x, np.empty_like(x), np.empty(count), certificate[:count]
    )
    return status == BLOCKED


@jit
def collide(bodies, contacts, count, restitution, friction, law, v, R, L, w, impulse, report):
    """Answers the impact of `count` contacts with restitution (c,) and friction (c,): status.

    Changes v, L, w (n,3); writes impulse (c,3) [N s] on body b of each contact, and the report.
    """
    report.book[:] = 0.0
    if count == 1:
        return collide_one(bodies, contacts, restitution[0], v, R, L, w, impulse, report)
    normals = contacts.normal[:count]
    cluster = cluster_of(bodies, contacts, count, R)
    rows, bounds = rows_along(cluster, contacts, normals), bounds_along(bodies, contacts, normals, v, w)
    before = scaled_velocities(cluster, v, L)
    speeds = np.empty(count)
    approaches(rows, bounds, before, speeds)
    impulse[:count] = 0.0
    report.approach[:count] = -speeds
    if impossible(rows, bounds, before, report.certificate):
        return BLOCKED
    x, given = before.copy(), np.empty(count)
    if law == TOGETHER:
        status, report.reflections[0] = reflect(rows, bounds, restitution[:count], x, given, report.book)
    else:
        status, report.reflections[0] = take_turns(rows, bounds, restitution[:count], x, given, report.book)
    for i in range(count):
        for k in range(3):
            impulse[i, k] = given[i] * normals[i, k]
    change_velocities(bodies, cluster, R, x - before, v, L, w)
    return status


@jit
def free_accelerations(bodies, cluster, force, torque, L, w):
    """Unknowns (k,6) of acceleration under force, torque (n,3) alone; a body free to turn feels its gyroscopic moment."""
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
def settle_velocities(bodies, contacts, count, equal, target, v, R, L, w, impulse, certificate):
    """Least change of motion that opens contacts at target (c,) [m/s] where equal (c,) bool, else at least so fast: status.

    Changes v, L, w (n,3) unless BLOCKED. Writes certificate (c,) and impulse (c,) [N s] along the normal on b, negative
    where an equality pulls.
    """
    normals = contacts.normal[:count]
    cluster = cluster_of(bodies, contacts, count, R)
    rows = rows_along(cluster, contacts, normals)
    bounds = bounds_along(bodies, contacts, normals, v, w) + target[:count]
    x = scaled_velocities(cluster, v, L)
    y, chosen = np.empty_like(x), np.ones(count, np.bool_)
    status, _ = project_cluster(rows, bounds, chosen, equal[:count], WEAK, x, y, impulse[:count], certificate[:count])
    if status != BLOCKED:
        change_velocities(bodies, cluster, R, y - x, v, L, w)
    return status


@jit
def displacements(bodies, contacts, count, equal, target, R, shift, turn, certificate):
    """Least move that opens gaps by target (c,) [m] where equal (c,) bool, else by at least as much: status.

    Writes shift (n,3) [m] of the centres and turn (n,3) [rad], a small world rotation, of the reacting bodies of the
    cluster (zero if BLOCKED), and certificate (c,).
    """
    cluster = cluster_of(bodies, contacts, count, R)
    rows = rows_along(cluster, contacts, contacts.normal[:count])
    x = np.zeros((len(cluster.members), 6))
    y, chosen, multiplier = np.empty_like(x), np.ones(count, np.bool_), np.empty(count)
    status, _ = project_cluster(
        rows, target[:count], chosen, equal[:count], WEAK, x, y, multiplier, certificate[:count]
    )
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
