"""A flight: the motion of a body under a held wrench, evaluable at any time of the step.

Translation is a parabola and the world angular momentum is L0 + M t, both exact. Attitude, by kind:
  STILL      no rotation at all
  AXIS       R = exp(u (w0 t + w1 t^2 / 2)) R0 about a fixed world axis u: exact
  SYMMETRIC  two equal inertias I1, the third I3 about body axis e, no torque:
             R = exp(t L / I1) R0 exp(t (1/I3 - 1/I1) l3 e): exact (VALIDATION A)
  SPLIT      everything else: Suzuki's fourth-order composition of a symmetric splitting, sub-stepped to a tolerance.

The splitting takes out the part of a sphere with the middle inertia I1, H = L^2 / (2 I1) + (1/I0 - 1/I1) l0^2 / 2
+ (1/I2 - 1/I1) l2^2 / 2: the first term is a rotation about L that commutes with the other two, each of these is a
rotation about a principal axis, and the torque is a kick of L. The error therefore vanishes with the difference of the
inertias instead of growing with the spin; without torque, what it changes the energy by is taken back at the end.
(McLachlan 1993, "Explicit Lie-Poisson integration and the Euler equations"; Suzuki 1990, "Fractal decomposition of
exponential operators".)

Legend: x centre of mass, v velocity, a acceleration, R attitude, L angular momentum, M moment, w angular velocity,
l = R^T L in principal axes; all world frame, SI; t local time of the step.
"""

from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.rotation import (
    orthonormalise,
    product,
    rotate_about_column,
    rotate_left,
)
from comotion_server.kernels.vectors import along, cross, dot, rotated, rotated_back, row

STILL, AXIS, SYMMETRIC, SPLIT = 0, 1, 2, 3

ATTITUDE_TOLERANCE = 1e-13  # [rad] aimed at per radian turned (at least one); larger: cutting a step changes the result
ERROR_CONSTANT = 3e-4  # of the splitting: largest ratio to the bound below seen against DOP853, 2e-4, with a margin
RESTORED = 10.0 * ATTITUDE_TOLERANCE  # what a body may be turned for its energy, likewise
MOST_SUBSTEPS = 10_000_000  # about a minute; above it the spin is no motion that a step can resolve
SUZUKI = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))


class Flights(NamedTuple):
    """The flights of all bodies, n rows each."""

    origin: np.ndarray  # (n,) local time at which the flight begins [s]
    position: np.ndarray  # (n,3) at the origin [m]
    velocity: np.ndarray  # (n,3) at the origin [m/s]
    acceleration: np.ndarray  # (n,3) [m/s2]
    rotation: np.ndarray  # (n,3,3) body to world at the origin
    momentum: np.ndarray  # (n,3) angular, at the origin [kg m2/s]
    torque: np.ndarray  # (n,3) [N m]
    axis: np.ndarray  # (n,3) AXIS: unit world axis
    rate: np.ndarray  # (n,2) AXIS: angular velocity [rad/s] and acceleration [rad/s2] about it
    kind: np.ndarray  # (n,) int64


SPIN_GIVEN, SPIN_NONE, SPIN_FREE = -3, -2, -1  # who decides the rotation; 0, 1, 2: free about that world axis alone
EQUAL_INERTIA = 1e-12  # relative difference of two inertias that counts as none: it turns the body by 1e-12 per radian


class Bodies(NamedTuple):
    """What flights and impacts need to know of the bodies, n rows each."""

    moments: np.ndarray  # (n,3) principal moments of inertia, ascending [kg m2]
    principal: np.ndarray  # (n,3,3) principal axes as columns, body frame
    spin: np.ndarray  # (n,) int64: SPIN_GIVEN, SPIN_NONE, SPIN_FREE or the one free world axis
    inverse_mass: np.ndarray  # (n,3) world, zero along what is locked, fixed or prescribed [1/kg]
    gravity: np.ndarray  # (n,3) world, zero along what is locked, fixed or prescribed [m/s2]
    reacts: np.ndarray  # (n,) bool: impacts change its motion


@lean_jit
def count_substeps(moments, momentum, torque, duration):
    """Sub-steps of the splitting so that its error stays within the tolerance."""
    L = sqrt(momentum[0] ** 2 + momentum[1] ** 2 + momentum[2] ** 2)
    M = sqrt(torque[0] ** 2 + torque[1] ** 2 + torque[2] ** 2)
    L += M * duration
    spread = (1.0 / moments[0] - 1.0 / moments[2]) * L * duration
    turned = L / moments[0] * duration
    kick = M / moments[0] * duration * duration
    error = ERROR_CONSTANT * (spread**5 + kick * (turned + sqrt(kick)) ** 3)
    wanted = (error / (ATTITUDE_TOLERANCE * max(1.0, turned))) ** 0.25
    return int(min(max(ceil(wanted), 1.0), float(MOST_SUBSTEPS)))


@lean_jit
def split_step(P, L, moments, torque, h):
    """One symmetric step of second order; P principal axes to world and L are changed in place."""
    for k in range(3):
        L[k] += 0.5 * h * torque[k]
    middle = 1.0 / moments[1]
    low, high = 1.0 / moments[0] - middle, 1.0 / moments[2] - middle
    rotate_left(P, h * middle * L[0], h * middle * L[1], h * middle * L[2])
    l0, _, _ = rotated_back(P, L)
    rotate_about_column(P, 0, 0.5 * h * low * l0)
    _, _, l2 = rotated_back(P, L)
    rotate_about_column(P, 2, h * high * l2)
    l0, _, _ = rotated_back(P, L)
    rotate_about_column(P, 0, 0.5 * h * low * l0)
    for k in range(3):
        L[k] += 0.5 * h * torque[k]


@lean_jit
def restore_energy(P, L, moments, doubled, most):
    """Turns P [rad] so that twice its energy is `doubled` [J], about L x w, which changes it fastest; by `most` or not.

    Near a principal axis energy has an extremum: there is nothing to restore.
    """
    l0, l1, l2 = rotated_back(P, L)
    w = rotated(P, (l0 / moments[0], l1 / moments[1], l2 / moments[2]))
    turn = cross(L, w)
    excess, square = 0.5 * (dot(L, w) - doubled), dot(turn, turn)
    if square > 0.0 and excess * excess <= most * most * square:
        share = excess / square
        rotate_left(P, share * turn[0], share * turn[1], share * turn[2])


@jit
def split(R, L, moments, Q, torque, duration):
    """Attitude after `duration` [s] by the composed splitting; R and L are changed in place."""
    steps = count_substeps(moments, L, torque, duration)
    h = duration / steps
    P = np.empty((3, 3))
    product(R, Q, P)
    orthonormalise(P)
    l0, l1, l2 = L[0], L[1], L[2]
    along_axes = rotated_back(P, L)
    doubled = along_axes[0] ** 2 / moments[0] + along_axes[1] ** 2 / moments[1] + along_axes[2] ** 2 / moments[2]
    for step in range(steps + 1):
        t = duration * step / steps  # L afresh each time, so that its kicks do not add up rounding
        L[0], L[1], L[2] = l0 + t * torque[0], l1 + t * torque[1], l2 + t * torque[2]
        if step == steps:
            break
        split_step(P, L, moments, torque, SUZUKI * h)
        split_step(P, L, moments, torque, SUZUKI * h)
        split_step(P, L, moments, torque, (1.0 - 4.0 * SUZUKI) * h)
        split_step(P, L, moments, torque, SUZUKI * h)
        split_step(P, L, moments, torque, SUZUKI * h)
    if torque[0] == 0.0 and torque[1] == 0.0 and torque[2] == 0.0:
        orthonormalise(P)
        most = RESTORED * max(1.0, sqrt(dot(L, L)) / moments[0] * duration)
        restore_energy(P, L, moments, doubled, most)
    product(P, Q.T, R)


@lean_jit
def spin_symmetric(R, L, moments, Q, duration):
    """Attitude of a torque-free body with two equal inertias after `duration` [s]; R is changed in place."""
    axis = 2 if moments[1] - moments[0] <= moments[2] - moments[1] else 0
    equal = moments[1]
    body = rotated_back(R, L)
    along = body[0] * Q[0, axis] + body[1] * Q[1, axis] + body[2] * Q[2, axis]
    angle = duration * (1.0 / moments[axis] - 1.0 / equal) * along
    # R exp(angle e^) = exp(angle (R e)^) R
    e = rotated(R, (Q[0, axis], Q[1, axis], Q[2, axis]))
    rotate_left(R, angle * e[0], angle * e[1], angle * e[2])
    turn = duration / equal
    rotate_left(R, turn * L[0], turn * L[1], turn * L[2])


@lean_jit
def angular_velocity_of(R, L, moments, Q, w):
    """World angular velocity w = R Q I^-1 Q^T R^T L."""
    b = rotated_back(R, L)
    l0, l1, l2 = rotated_back(Q, b)
    b = rotated(Q, (l0 / moments[0], l1 / moments[1], l2 / moments[2]))
    w[0], w[1], w[2] = rotated(R, b)


@lean_jit
def inertia_about(R, moments, Q, k):
    """Moment of inertia about world axis k through the centre of mass: e_k . R Q I Q^T R^T e_k."""
    total = 0.0
    for m in range(3):
        along = R[k, 0] * Q[0, m] + R[k, 1] * Q[1, m] + R[k, 2] * Q[2, m]
        total += along * along * moments[m]
    return total


@lean_jit
def kind_of_spin(moments, L, torque):
    """The cheapest exact kind of flight for a body that turns freely."""
    if torque[0] != 0.0 or torque[1] != 0.0 or torque[2] != 0.0:
        return SPLIT
    if L[0] == 0.0 and L[1] == 0.0 and L[2] == 0.0:
        return STILL
    low = moments[1] - moments[0] <= EQUAL_INERTIA * moments[2]
    high = moments[2] - moments[1] <= EQUAL_INERTIA * moments[2]
    if low and high:
        return AXIS
    return SYMMETRIC if low or high else SPLIT


@lean_jit
def begin_axis(flights, i, wx, wy, wz):
    """Rotation at the constant world angular velocity (wx, wy, wz)."""
    rate = sqrt(wx * wx + wy * wy + wz * wz)
    flights.rate[i, 0], flights.rate[i, 1] = rate, 0.0
    flights.kind[i] = AXIS if rate > 0.0 else STILL
    if rate > 0.0:
        flights.axis[i, 0], flights.axis[i, 1], flights.axis[i, 2] = wx / rate, wy / rate, wz / rate


@lean_jit
def begin(flights, bodies, i, time, x, v, R, L, w):
    """Body i takes off at local `time` from its state, under the acceleration and torque its flight already holds."""
    if w[0] != 0.0 or w[1] != 0.0 or w[2] != 0.0:
        orthonormalise(R)
    flights.origin[i] = time
    for k in range(3):
        flights.position[i, k], flights.velocity[i, k], flights.momentum[i, k] = x[k], v[k], L[k]
        for m in range(3):
            flights.rotation[i, k, m] = R[k, m]
    spin = bodies.spin[i]
    if spin == SPIN_NONE:
        flights.kind[i] = STILL
    elif spin == SPIN_GIVEN:
        begin_axis(flights, i, w[0], w[1], w[2])
    elif spin == SPIN_FREE:
        kind = kind_of_spin(bodies.moments[i], L, flights.torque[i])
        if kind == AXIS:
            begin_axis(flights, i, w[0], w[1], w[2])
        else:
            flights.kind[i] = kind
    else:
        inertia = inertia_about(R, bodies.moments[i], bodies.principal[i], spin)
        flights.kind[i] = AXIS
        flights.axis[i, :] = 0.0
        flights.axis[i, spin] = 1.0
        flights.rate[i, 0], flights.rate[i, 1] = L[spin] / inertia, flights.torque[i, spin] / inertia


@lean_jit
def begin_all(flights, bodies, force, moment, x, v, R, L, w):
    """All bodies take off at local time 0 under a held wrench: force, moment (n,3) about the centres of mass, world."""
    for i in range(x.shape[0]):
        spin = bodies.spin[i]
        for k in range(3):
            flights.acceleration[i, k] = bodies.inverse_mass[i, k] * force[i, k] + bodies.gravity[i, k]
            flights.torque[i, k] = moment[i, k] if spin in (SPIN_FREE, k) else 0.0
        begin(flights, bodies, i, 0.0, x[i], v[i], R[i], L[i], w[i])


@jit
def begin_drift(flights, x, v, R, L, w):
    """All bodies take off at local time 0 with their velocities held: the prediction of the middle of a step."""
    flights.acceleration[:] = 0.0
    flights.torque[:] = 0.0
    flights.origin[:] = 0.0
    flights.position[:] = x
    flights.velocity[:] = v
    flights.rotation[:] = R
    flights.momentum[:] = L
    for i in range(x.shape[0]):
        begin_axis(flights, i, w[i, 0], w[i, 1], w[i, 2])


@lean_jit
def motion_of(flights, i, time):
    """(x, v) of the centre of mass of body i at local `time`, as tuples."""
    t, a = time - flights.origin[i], row(flights.acceleration, i)
    x, v = row(flights.position, i), row(flights.velocity, i)
    return along(along(x, t, v), 0.5 * t * t, a), along(v, t, a)


@lean_jit
def fly(flights, bodies, i, time, x, v, R, L, w):
    """State of body i at local `time`, written to x (3,), v (3,), R (3,3), L (3,), w (3,)."""
    t = time - flights.origin[i]
    for k in range(3):
        a = flights.acceleration[i, k]
        x[k] = flights.position[i, k] + t * (flights.velocity[i, k] + 0.5 * t * a)
        v[k] = flights.velocity[i, k] + t * a
        L[k] = flights.momentum[i, k]
        for m in range(3):
            R[k, m] = flights.rotation[i, k, m]
    kind = flights.kind[i]
    if kind == STILL:
        w[:] = 0.0
    elif kind == AXIS:
        u, rate, change = flights.axis[i], flights.rate[i, 0], flights.rate[i, 1]
        angle = t * (rate + 0.5 * t * change)
        rotate_left(R, angle * u[0], angle * u[1], angle * u[2])
        for k in range(3):
            w[k] = u[k] * (rate + t * change)
            L[k] += t * flights.torque[i, k]
    else:
        if kind == SYMMETRIC:
            spin_symmetric(R, L, bodies.moments[i], bodies.principal[i], t)
        else:
            split(R, L, bodies.moments[i], bodies.principal[i], flights.torque[i], t)
        angular_velocity_of(R, L, bodies.moments[i], bodies.principal[i], w)


@lean_jit
def fly_all(flights, bodies, time, x, v, R, L, w):
    """States of all bodies at local `time`: x, v, L, w (n,3) and R (n,3,3)."""
    for i in range(x.shape[0]):
        fly(flights, bodies, i, time, x[i], v[i], R[i], L[i], w[i])


@lean_jit
def fly_rows(rows, flights, bodies, time, x, v, R, L, w):
    """As `fly_all`, for the bodies in `rows` (k,) alone."""
    for i in rows:
        fly(flights, bodies, i, time, x[i], v[i], R[i], L[i], w[i])
