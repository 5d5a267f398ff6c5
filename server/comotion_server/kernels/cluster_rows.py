"""The bodies and contacts of one cluster as rows over mass-scaled unknowns: kinetic energy is |x|^2 / 2.

Unknowns, six per reacting body: sqrt(m) v_k along the free world axes; sqrt(I_m) w_m about its principal axes, or
sqrt(I_ss) w_s about its one free world axis s. `ease`, 1/sqrt(m) or 1/sqrt(I), is zero along what is not free, and so
are the numbers of a row there. A row gives the speed at which its contact opens along a direction d, from a to b:

    d.(v_b + w_b x r_b - v_a - w_a x r_a) = part.x - bound,

`bound` holding minus what prescribed, fixed, locked and non-reacting motion contributes.

Legend: r arm from the centre of mass, n unit normal, c count of contacts, k count of reacting bodies; world frame, SI.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.flight import SPIN_FREE, angular_velocity_of, inertia_about
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.vectors import dot, lever, row

NOT_REACTING = -1


class Cluster(NamedTuple):
    """The reacting bodies of a cluster and the contacts that join them."""

    members: np.ndarray  # (k,) int64 rows of the reacting bodies, ascending
    ease: np.ndarray  # (k,6) 1/sqrt(mass) [kg^-1/2], 1/sqrt(inertia) [kg^-1/2 m^-1]; 0: not free
    axes: np.ndarray  # (k,3,3) unit axes of the rotations as rows, world
    link: np.ndarray  # (c,2) int64 places of a and b among the members, or NOT_REACTING


class Rows(NamedTuple):
    """Rows over the unknowns of a cluster; each touches at most two bodies."""

    link: np.ndarray  # (c,2) int64 places of its bodies, or NOT_REACTING
    part: np.ndarray  # (c,2,6) its numbers at both; zero at NOT_REACTING
    size: np.ndarray  # (c,) their norm [kg^-1/2]


@jit
def place_of(members, count, body):
    """Where a body stands, or would stand, among the first `count` of the ascending members."""
    low, high = 0, count
    while low < high:
        middle = (low + high) // 2
        if members[middle] < body:
            low = middle + 1
        else:
            high = middle
    return low


@jit
def members_of(bodies, pairs, count):
    """The reacting bodies of `count` contacts, ascending."""
    members, found = np.empty(2 * count, np.int64), 0
    for i in range(count):
        for side in range(2):
            body = pairs[i, side]
            place = place_of(members, found, body)
            if not bodies.reacts[body] or (place < found and members[place] == body):
                continue
            for j in range(found, place, -1):
                members[j] = members[j - 1]
            members[place] = body
            found += 1
    return members[:found].copy()


@jit
def fill_ease(bodies, i, R, ease, axes):
    """The six eases (6,) of body i and the axes (3,3) of its rotations."""
    spin = bodies.spin[i]
    axes[:] = 0.0
    for k in range(3):
        ease[k] = sqrt(bodies.inverse_mass[i, k])
        ease[3 + k] = 0.0
        if spin == SPIN_FREE:
            ease[3 + k] = 1.0 / sqrt(bodies.moments[i, k])
            for j in range(3):
                for m in range(3):
                    axes[k, j] += R[j, m] * bodies.principal[i, m, k]
        elif spin == k:
            ease[3 + k] = 1.0 / sqrt(inertia_about(R, bodies.moments[i], bodies.principal[i], k))
            axes[k, k] = 1.0


@jit
def cluster_of(bodies, contacts, count, R):
    """The cluster of the first `count` contacts, R (n,3,3) the attitudes of all bodies."""
    members = members_of(bodies, contacts.bodies, count)
    k = len(members)
    cluster = Cluster(members, np.empty((k, 6)), np.empty((k, 3, 3)), np.empty((count, 2), np.int64))
    for j in range(k):
        fill_ease(bodies, members[j], R[members[j]], cluster.ease[j], cluster.axes[j])
    for i in range(count):
        for side in range(2):
            body = contacts.bodies[i, side]
            reacts = bodies.reacts[body]
            cluster.link[i, side] = place_of(members, k, body) if reacts else NOT_REACTING
    return cluster


@jit
def fill_part(ease, axes, arm, direction, sign, part):
    """A row's numbers (6,) at one body: sign times the speed of its point at `arm` along `direction`."""
    turn = lever(arm, direction)
    for k in range(3):
        part[k] = sign * direction[k] * ease[k]
        part[3 + k] = sign * dot(row(axes, k), turn) * ease[3 + k]


@jit
def rows_along(cluster, contacts, directions):
    """Rows of all contacts along unit `directions` (c,3); both arms to the middle of the gap, one line of action."""
    count = len(cluster.link)
    rows = Rows(cluster.link, np.zeros((count, 2, 6)), np.empty(count))
    for i in range(count):
        d, total = row(directions, i), 0.0
        for side in range(2):
            j = cluster.link[i, side]
            if j != NOT_REACTING:
                arm = arm_to_middle(contacts, i, side)
                fill_part(cluster.ease[j], cluster.axes[j], arm, d, 2.0 * side - 1.0, rows.part[i, side])
            for k in range(6):
                total += rows.part[i, side, k] ** 2
        rows.size[i] = sqrt(total)
    return rows


@lean_jit
def arm_to_middle(contacts, i, side):
    """From the centre of a (side 0) or b (side 1) to the middle of the gap of contact i."""
    n, half = row(contacts.normal, i), 0.5 * contacts.gap[i]
    if side == 0:
        r = row(contacts.arm_a, i)
        return r[0] + half * n[0], r[1] + half * n[1], r[2] + half * n[2]
    r = row(contacts.arm_b, i)
    return r[0] - half * n[0], r[1] - half * n[1], r[2] - half * n[2]


@jit
def given_speed(bodies, i, v, w, arm, direction):
    """Speed along `direction` of the point at `arm` of body i that impacts cannot change."""
    spin, total = bodies.spin[i], 0.0
    turn = lever(arm, direction)
    for k in range(3):
        if not bodies.reacts[i] or bodies.inverse_mass[i, k] == 0.0:
            total += direction[k] * v[i, k]
        if not bodies.reacts[i] or spin not in (SPIN_FREE, k):
            total += turn[k] * w[i, k]
    return total


@jit
def bounds_along(bodies, contacts, directions, v, w):
    """The bounds (c,) of rows along `directions` (c,3): minus the opening speed that is given."""
    bounds = np.empty(len(directions))
    for i in range(len(directions)):
        d = row(directions, i)
        a = given_speed(bodies, contacts.bodies[i, 0], v, w, arm_to_middle(contacts, i, 0), d)
        bounds[i] = a - given_speed(bodies, contacts.bodies[i, 1], v, w, arm_to_middle(contacts, i, 1), d)
    return bounds


@jit
def along_row(rows, i, x):
    """Product of row i with unknowns x (k,6)."""
    total = 0.0
    for side in range(2):
        j = rows.link[i, side]
        if j != NOT_REACTING:
            for k in range(6):
                total += rows.part[i, side, k] * x[j, k]
    return total


@jit
def add_row(rows, i, s, x):
    """Adds s times row i to unknowns x (k,6)."""
    for side in range(2):
        j = rows.link[i, side]
        if j != NOT_REACTING:
            for k in range(6):
                x[j, k] += s * rows.part[i, side, k]


@jit
def scaled_velocities(cluster, v, L):
    """Unknowns x (k,6) of the members from their velocities (n,3) and angular momenta (n,3)."""
    x = np.zeros((len(cluster.members), 6))
    for j in range(len(cluster.members)):
        i = cluster.members[j]
        for k in range(3):
            if cluster.ease[j, k] > 0.0:
                x[j, k] = v[i, k] / cluster.ease[j, k]
            x[j, 3 + k] = dot(row(cluster.axes[j], k), row(L, i)) * cluster.ease[j, 3 + k]
    return x


@jit
def change_velocities(bodies, cluster, R, before, after, v, L, w):
    """Brings v, L, w of the members along as their unknowns (k,6) change; a member that does not keeps its bits."""
    for j in range(len(cluster.members)):
        i, turned = cluster.members[j], False
        for k in range(3):
            v[i, k] += cluster.ease[j, k] * (after[j, k] - before[j, k])
            change = after[j, 3 + k] - before[j, 3 + k]
            if change != 0.0:
                turned = True
                for m in range(3):
                    L[i, m] += cluster.axes[j, k, m] * (change / cluster.ease[j, 3 + k])
        spin = bodies.spin[i]
        if turned and spin == SPIN_FREE:
            angular_velocity_of(R[i], L[i], bodies.moments[i], bodies.principal[i], w[i])
        elif turned:
            w[i, spin] = L[i, spin] * cluster.ease[j, 3 + spin] ** 2
