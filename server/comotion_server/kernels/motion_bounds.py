"""What is proven of the relative motion of two bodies on flights, from one time on (docs/time_of_impact.md, 2).

Everything is told in the axes of body a at that time, from its centre of mass: `Relative` is the state, `Spins` what
bounds the rotations over the rest of a window. Legend: w angular velocity, L angular momentum, M moment, I0 <= I1 <= I2
principal inertias, all SI; s time from now on.
"""

from math import expm1, inf, sqrt
from typing import NamedTuple

from comotion_server.kernels.flight import (
    AXIS,
    SPLIT,
    STILL,
    SYMMETRIC,
    angular_velocity_of,
    count_substeps,
    fly,
)
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, rotated_back, row, scaled, sub

STRAYING_TRIES = 8  # to find a bound of the straying of an angular velocity that holds; each is half as large again
STEEP = 4.0  # of an exponent: beyond it the bound says nothing that energy does not say
CHEAP = 4  # sub-steps of a flight that are found from its origin each time


class Relative(NamedTuple):
    """Motion of body b against body a at one time, as vectors in the axes of a, whose centre is the origin."""

    offset: tuple[float, float, float]  # of the centre of b [m]
    velocity: tuple[float, float, float]  # of the centre of b against that of a [m/s]
    acceleration: tuple[float, float, float]  # likewise, constant in the world [m/s2]
    spin_a: tuple[float, float, float]  # angular velocity of a [rad/s]
    spin_b: tuple[float, float, float]
    change_a: tuple[float, float, float]  # angular acceleration of a [rad/s2]
    change_b: tuple[float, float, float]


class Spin(NamedTuple):
    """Bounds of a body's rotation over a window."""

    rate: float  # largest angular speed [rad/s]
    change: float  # largest angular acceleration [rad/s2]
    jolt: float  # largest rate of change of the angular acceleration [rad/s3]
    fixed: int  # 1: about one axis that does not move; 0: about any
    axis: tuple[float, float, float]  # that axis, unit, in the axes of a at the beginning of the window


@lean_jit
def angular_acceleration(flights, bodies, i, R, L, w, turned):
    """World angular acceleration [rad/s2], as a tuple; turned (3,): work space."""
    kind = flights.kind[i]
    if kind == STILL:
        return ZERO
    if kind == AXIS:
        return scaled(row(flights.axis, i), flights.rate[i, 1])
    gyroscopic = cross(row(L, i), row(w, i))
    if kind == SYMMETRIC:
        return scaled(gyroscopic, 1.0 / bodies.moments[i, 1])
    turned[0], turned[1], turned[2] = add(row(flights.torque, i), gyroscopic)
    angular_velocity_of(R[i], turned, bodies.moments[i], bodies.principal[i], turned)
    return turned[0], turned[1], turned[2]


@lean_jit
def relate(flights, bodies, time, states, R):
    """`Relative` of bodies a and b, rows 0 and 1, at local `time` [s].

    Out: `states`, the (x, v, R, L, w) of both in the world, two rows each, and room for a vector; R (3, 3), from b's
    axes to a's.
    """
    x, v, rotation, L, w, turned = states
    fly(flights, bodies, 0, time, x[0], v[0], rotation[0], L[0], w[0])
    fly(flights, bodies, 1, time, x[1], v[1], rotation[1], L[1], w[1])
    relative_rotation(rotation[0], rotation[1], R)
    Ra = rotation[0]
    return Relative(
        rotated_back(Ra, sub(row(x, 1), row(x, 0))),
        rotated_back(Ra, sub(row(v, 1), row(v, 0))),
        rotated_back(Ra, sub(row(flights.acceleration, 1), row(flights.acceleration, 0))),
        rotated_back(Ra, row(w, 0)),
        rotated_back(Ra, row(w, 1)),
        rotated_back(Ra, angular_acceleration(flights, bodies, 0, rotation, L, w, turned)),
        rotated_back(Ra, angular_acceleration(flights, bodies, 1, rotation, L, w, turned)),
    )


@lean_jit
def take_over(flights, bodies, a, b, own_flights, own_bodies):
    """Rows 0 and 1 of `own_flights` and `own_bodies` become those of bodies a and b."""
    for k, i in ((0, a), (1, b)):
        own_flights.origin[k], own_flights.kind[k] = flights.origin[i], flights.kind[i]
        own_flights.rate[k, 0], own_flights.rate[k, 1] = flights.rate[i, 0], flights.rate[i, 1]
        own_flights.position[k], own_flights.velocity[k] = row(flights.position, i), row(flights.velocity, i)
        own_flights.acceleration[k], own_flights.axis[k] = row(flights.acceleration, i), row(flights.axis, i)
        own_flights.momentum[k], own_flights.torque[k] = row(flights.momentum, i), row(flights.torque, i)
        own_bodies.moments[k] = row(bodies.moments, i)
        for j in range(3):
            own_flights.rotation[k, j] = row(flights.rotation[i], j)
            own_bodies.principal[k, j] = row(bodies.principal[i], j)


@lean_jit
def settle(flights, bodies, time, states):
    """Let flights whose attitude is costly to find from their origin go on from `time`, where `states` are theirs.

    The attitude is then that of a step cut in pieces: it differs by no more than the flights' own tolerance. Returns
    how many did.
    """
    legs = 0
    x, v, rotation, L, _, _ = states
    for k in range(2):
        if flights.kind[k] != SPLIT or time == flights.origin[k]:
            continue
        past = time - flights.origin[k]
        if count_substeps(bodies.moments[k], flights.momentum[k], flights.torque[k], past) > CHEAP:
            legs += 1
            flights.origin[k] = time
            flights.position[k], flights.velocity[k], flights.momentum[k] = row(x, k), row(v, k), row(L, k)
            for j in range(3):
                flights.rotation[k, j] = row(rotation[k], j)
    return legs


@lean_jit
def spin_line(flights, bodies, i, L, w):
    """(rate, growth): the angular speed is at most rate + growth s for all s >= 0.

    Of a free top the energy E bounds it: I0 w^2 <= 2 E, and d sqrt(2 E) / ds <= |M| / sqrt(I0).
    """
    kind = flights.kind[i]
    if kind == STILL:
        return 0.0, 0.0
    if kind == AXIS:
        return length(w), abs(flights.rate[i, 1])
    if kind == SYMMETRIC:
        return length(w), 0.0
    least = bodies.moments[i, 0]
    rate = max(length(w), sqrt(max(dot(w, L), 0.0) / least))
    return rate, length(row(flights.torque, i)) / least


@lean_jit
def _straying(now, rate, growth, spread, horizon):
    """Bounds (D, change) of how far w comes off its value in body axes [rad/s], and of |w'|, within `horizon` [s].

    now, rate: |w'| and |w|; growth: |M| / I0; spread: (I2 - I0) / I0. inf where this is of no use.
    """
    D = now * horizon
    for _ in range(STRAYING_TRIES):
        pull = now + growth * (rate + D) * horizon
        steep = 0.5 * spread * (2.0 * rate + D)
        turned = steep * horizon
        if turned > STEEP:
            return inf, inf
        grown = pull * horizon * (expm1(turned) / turned if turned > 0.0 else 1.0)
        if grown <= D:
            return D, pull + steep * D
        D = 1.5 * grown
    return inf, inf


@lean_jit
def spin_over(flights, bodies, i, L, w, now, rotation_a, horizon):
    """`Spin` over the next `horizon` [s], from Euler's I w' = M - w x I w (docs/time_of_impact.md, 2); now: |w'|."""
    kind = flights.kind[i]
    rate, growth = spin_line(flights, bodies, i, L, w)
    if kind == STILL:
        return Spin(0.0, 0.0, 0.0, 1, ZERO)
    if kind == AXIS:
        return Spin(rate + growth * horizon, growth, 0.0, 1, rotated_back(rotation_a, row(flights.axis, i)))
    moments = bodies.moments[i]
    if kind == SYMMETRIC:
        change = length(cross(L, w)) / moments[1]
        return Spin(rate, change, length(L) / moments[1] * change, 0, ZERO)
    top = rate + growth * horizon
    spread = (moments[2] - moments[0]) / moments[0]
    change = growth + top * top * 0.5 * spread
    top = min(top, length(w) + change * horizon)
    strays, gentle = _straying(now, length(w), growth, spread, horizon)
    if gentle < change:
        top, change = min(top, length(w) + strays), gentle
    return Spin(top, change, top * (growth + change * spread + change), 0, ZERO)


@lean_jit
def spins_over(flights, bodies, states, horizon):
    """`Spin` of both bodies from the states that `relate` left."""
    _, _, rotation, L, w, turned = states
    now_a = length(angular_acceleration(flights, bodies, 0, rotation, L, w, turned))
    now_b = length(angular_acceleration(flights, bodies, 1, rotation, L, w, turned))
    return (
        spin_over(flights, bodies, 0, row(L, 0), row(w, 0), now_a, rotation[0], horizon),
        spin_over(flights, bodies, 1, row(L, 1), row(w, 1), now_b, rotation[0], horizon),
    )


@lean_jit
def approach_line(flights, bodies, relative, states, radius_a, radius_b):
    """Proven speed limits: (speed, growth, rate, rate_growth).

    Two points of the bodies approach at no more than speed + growth s [m/s] for all s >= 0, and the bodies turn at no
    more than rate + rate_growth s [rad/s] together.
    """
    _, _, _, L, w, _ = states
    rate_a, growth_a = spin_line(flights, bodies, 0, row(L, 0), row(w, 0))
    rate_b, growth_b = spin_line(flights, bodies, 1, row(L, 1), row(w, 1))
    speed = length(relative.velocity) + rate_a * radius_a + rate_b * radius_b
    growth = length(relative.acceleration) + growth_a * radius_a + growth_b * radius_b
    return speed, growth, rate_a + rate_b, growth_a + growth_b


@lean_jit
def first_root(c, f, k):
    """The first s >= 0 with c + f s + k s^2 / 2 = 0 for c >= 0; inf: none."""
    squared = f * f - 2.0 * k * c
    if squared < 0.0:
        return inf
    root = sqrt(squared)
    if f > 0.0:
        return (f + root) / -k if k < 0.0 else inf
    return 2.0 * c / (root - f) if root > f else (0.0 if c == 0.0 and k < 0.0 else inf)


@lean_jit
def covering_time(distance, speed, growth):
    """The time [s] in which `distance` [m] is covered: speed s + growth s^2 / 2 = distance."""
    return first_root(max(distance, 0.0), -speed, -growth)


@lean_jit
def sphere_time(relative, reach):
    """A proven lower bound [s] of the time at which the centres come within `reach` [m], which they are beyond now.

    Exact without acceleration; else the time for which the line between the centres alone keeps them apart.
    """
    x, v, acceleration = relative.offset, relative.velocity, relative.acceleration
    apart = length(x)
    if acceleration[0] != 0.0 or acceleration[1] != 0.0 or acceleration[2] != 0.0:
        n = scaled(x, 1.0 / apart)
        return first_root(apart - reach, dot(n, v), dot(n, acceleration))
    square = dot(v, v)
    if not dot(x, v) < 0.0:
        return inf
    beside = along(x, -dot(x, v) / square, v)
    depth = reach * reach - dot(beside, beside)
    if depth < 0.0:
        return inf
    return max(-dot(x, v) / square - sqrt(depth / square), 0.0)
