"""The flight of bodies in held contact over a sub-step, of fourth order (docs/rest.md).

The contact forces follow from the accelerations: y(state) = the free accelerations, corrected as little as possible so
that no touching gap accelerates inwards. Nystrom's scheme for x'' = y(x, x'), with k = y:
  k1 at the beginning;  k2 after h/2 on the flight under k1;  k3 there, with the velocities under k2;
  k4 after h on the flight under k3.
Positions after h are those of the flight under (k1 + k2 + k3) / 3, exactly; velocities lack h (k4 - k1) / 6, which is
added where the sub-step ends. So bodies in contact are on ordinary flights, which every other kernel can evaluate, and
where the forces do not change the flight is exact for any h. On the way the flight strays from the true path by at
most (k4 - k1) h^2 / 40, which must stay small against the gap that held contacts keep.

Legend: k accelerations and torques (gyroscopic part left out: flights have it in them); rows are contacts.
"""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.cluster_rows import place_of
from comotion_server.kernels.contact_motion import refresh
from comotion_server.kernels.flight import SPIN_FREE, STILL, angular_velocity_of, begin, fly, inertia_about
from comotion_server.kernels.impact_cluster import SOLVED, hold
from comotion_server.kernels.jit import jit
from comotion_server.kernels.motion_bounds import angular_acceleration
from comotion_server.kernels.smooth_contact import is_bent
from comotion_server.kernels.vectors import add, cross, dot, length, row

STAGES = 4
STRAYS = 4.0 / 162.0  # largest s^2 (1 - s) / 6 in [0, 1]: how far the flight strays on the way, times (k4 - k1) h^2


class Course(NamedTuple):
    """The stages of a sub-step: k members, c contacts."""

    acceleration: np.ndarray  # (4,k,3) [m/s2]
    torque: np.ndarray  # (4,k,3) [N m]
    force: np.ndarray  # (4,c) along the normals [N]
    normal: np.ndarray  # (4,c,3)
    margin: np.ndarray  # (4,c) inside the features [m]
    speed: np.ndarray  # (4,c) at which gaps open [m/s]
    bias: np.ndarray  # (c,) work space


@jit
def new_course(members, count):
    """Room for a sub-step of `members` bodies with `count` contacts."""
    return Course(
        np.zeros((STAGES, members, 3)),
        np.zeros((STAGES, members, 3)),
        np.zeros((STAGES, count)),
        np.zeros((STAGES, count, 3)),
        np.zeros((STAGES, count)),
        np.zeros((STAGES, count)),
        np.zeros(count),
    )


@jit
def _given_acceleration(flights, bodies, contacts, i, R, L, w):
    """What motion that does not react adds to the opening acceleration of contact i [m/s2]."""
    total, n = 0.0, row(contacts.normal, i)
    for side in range(2):
        body, sign = contacts.bodies[i, side], 2.0 * side - 1.0
        if bodies.reacts[body]:
            continue
        arm = row(contacts.arm_a, i) if side == 0 else row(contacts.arm_b, i)
        turned = angular_acceleration(flights, bodies, body, R, L, w, np.empty(3))
        total += sign * dot(n, add(row(flights.acceleration, body), cross(turned, arm)))
    return total


@jit
def evaluate(solids, flights, bodies, contacts, count, members, free, state, course, stage, certificate, answer):
    """Stage of a sub-step at a state: what forces keep the touching gaps from accelerating inwards. Returns `hold`'s.

    free: force and torque without contacts (n,3); answer: room for accelerations and torques (n,3).
    """
    x, v, R, L, w = state
    for i in range(count):
        margin, speed, bias = refresh(solids, contacts, i, x, v, R, w)
        course.speed[stage, i], course.margin[stage, i] = speed, margin
        course.bias[i] = bias + _given_acceleration(flights, bodies, contacts, i, R, L, w)
        course.normal[stage, i] = contacts.normal[i]
    force, torque = free
    acceleration, angular = answer
    pressing = course.force[stage]
    status = hold(
        bodies, contacts, count, course.bias, force, torque, R, L, w, acceleration, angular, pressing, certificate
    )
    for j in range(len(members)):
        course.acceleration[stage, j] = acceleration[members[j]]
        course.torque[stage, j] = angular[members[j]]
    return status


@jit
def take_off_under(flights, bodies, members, acceleration, torque, time, state):
    """The members (k,) begin flights at a state under accelerations and torques (k,3)."""
    x, v, R, L, w = state
    for j in range(len(members)):
        i = members[j]
        flights.acceleration[i], flights.torque[i] = acceleration[j], torque[j]
        begin(flights, bodies, i, time, x[i], v[i], R[i], L[i], w[i])


@jit
def _fly_to(flights, bodies, rows, time, state):
    x, v, R, L, w = state
    for i in rows:
        fly(flights, bodies, i, time, x[i], v[i], R[i], L[i], w[i])


@jit
def turn_to(bodies, i, R, L, w):
    """The angular velocity of body i is made to follow from its momentum."""
    spin = bodies.spin[i]
    if spin == SPIN_FREE:
        angular_velocity_of(R[i], L[i], bodies.moments[i], bodies.principal[i], w[i])
    elif spin >= 0:
        w[i, spin] = L[i, spin] / inertia_about(R[i], bodies.moments[i], bodies.principal[i], spin)


@jit
def _is_steady(solids, flights, contacts, count, members, touched, course, state):
    """Whether nothing turns, nor will: then normals and contact forces stay as they are."""
    for i in range(count):
        if is_bent(solids, contacts, i) and row(state[1], contacts.bodies[i, 0]) != row(
            state[1], contacts.bodies[i, 1]
        ):
            return False
    for i in touched:
        if flights.kind[i] != STILL and length(row(state[4], i)) > 0.0:
            return False
    turning = 0.0
    for j in range(len(members)):
        turning += length(row(course.torque[0], j))
    return turning == 0.0


@jit
def _carry_on(solids, contacts, count, trial, course):
    """All stages are like the first one; only the points move over their faces."""
    x, v, R, _, w = trial
    for stage in range(1, STAGES):
        course.acceleration[stage], course.torque[stage] = course.acceleration[0], course.torque[0]
        course.force[stage], course.normal[stage] = course.force[0], course.normal[0]
        course.margin[stage], course.speed[stage] = course.margin[0], course.speed[0]
    for i in range(count):
        course.margin[STAGES - 1, i], course.speed[STAGES - 1, i], _ = refresh(solids, contacts, i, x, v, R, w)
    return SOLVED


@jit
def try_flight(
    solids, flights, bodies, contacts, count, members, touched, free, time, h, state, trial, course, certificate, answer
):
    """Puts the members on a flight of `h` [s] from their state at `time`: status of the stages.

    members (k,): reacting bodies of the island; touched: they and all they touch; state, trial: (x, v, R, L, w) of all
    bodies, at `time`, and room for later ones. The contacts' points move on with the stages: give a copy.
    """
    status = evaluate(solids, flights, bodies, contacts, count, members, free, state, course, 0, certificate, answer)
    if status != SOLVED:
        return status
    if _is_steady(solids, flights, contacts, count, members, touched, course, state):
        take_off_under(flights, bodies, members, course.acceleration[0], course.torque[0], time, state)
        _fly_to(flights, bodies, touched, time + h, trial)
        return _carry_on(solids, contacts, count, trial, course)
    take_off_under(flights, bodies, members, course.acceleration[0], course.torque[0], time, state)
    _fly_to(flights, bodies, touched, time + 0.5 * h, trial)
    for stage in (1, 2):
        status = evaluate(
            solids, flights, bodies, contacts, count, members, free, trial, course, stage, certificate, answer
        )
        if status != SOLVED:
            return status
        if stage == 1:
            _, v, R, L, w = trial
            for j in range(len(members)):
                i = members[j]
                for k in range(3):
                    v[i, k] = state[1][i, k] + 0.5 * h * course.acceleration[1, j, k]
                    L[i, k] = state[3][i, k] + 0.5 * h * course.torque[1, j, k]
                turn_to(bodies, i, R, L, w)
    take_off_under(flights, bodies, members, course.acceleration[2], course.torque[2], time, state)
    _fly_to(flights, bodies, touched, time + h, trial)
    status = evaluate(solids, flights, bodies, contacts, count, members, free, trial, course, 3, certificate, answer)
    if status == SOLVED:
        acceleration = (course.acceleration[0] + course.acceleration[1] + course.acceleration[2]) / 3.0
        torque = (course.torque[0] + course.torque[1] + course.torque[2]) / 3.0
        take_off_under(flights, bodies, members, acceleration, torque, time, state)
    return status


@jit
def correct(bodies, members, gains, state):
    """Adds what velocities and angular momenta (two arrays (k,3)) lack at the end of a sub-step to the state."""
    _, v, R, L, w = state
    for j in range(len(members)):
        i = members[j]
        for k in range(3):
            v[i, k] += gains[0][j, k]
            L[i, k] += gains[1][j, k]
        turn_to(bodies, i, R, L, w)


@jit
def straying(bodies, contacts, count, members, course, h, R):
    """How far [m] loaded contacts may come off their course on the way: the flight against the true path."""
    acceleration, turn = np.zeros((len(members), 3)), np.zeros((len(members), 3))
    for j in range(len(members)):
        i = members[j]
        for k in range(3):
            acceleration[j, k] = course.acceleration[3, j, k] - course.acceleration[0, j, k]
            turn[j, k] = course.torque[3, j, k] - course.torque[0, j, k]
        if bodies.spin[i] == SPIN_FREE:
            angular_velocity_of(R[i], turn[j], bodies.moments[i], bodies.principal[i], turn[j])
        elif bodies.spin[i] >= 0:
            turn[j, bodies.spin[i]] /= inertia_about(R[i], bodies.moments[i], bodies.principal[i], bodies.spin[i])
    worst = 0.0
    for i in range(count):
        if course.force[0, i] == 0.0 and course.force[3, i] == 0.0:
            continue
        total, n = 0.0, row(contacts.normal, i)
        for side in range(2):
            body = contacts.bodies[i, side]
            if bodies.reacts[body]:
                j = place_of(members, len(members), body)
                arm = row(contacts.arm_a, i) if side == 0 else row(contacts.arm_b, i)
                total += (2.0 * side - 1.0) * dot(n, add(row(acceleration, j), cross(row(turn, j), arm)))
        worst = max(worst, abs(total))
    return STRAYS * worst * h * h
