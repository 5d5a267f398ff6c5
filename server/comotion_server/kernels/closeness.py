"""Closeness of pairs (P9), and how fast bodies may get within a step.

Legend: x, v, R, L, w state arrays; p, q closest points of a and b, world; n unit normal from a to b; reach [m].
"""

from math import inf, nan, sqrt

from comotion_server.kernels.flight import AXIS, STILL
from comotion_server.kernels.impact import closing_speed
from comotion_server.kernels.jit import jit
from comotion_server.kernels.vectors import rotated, rotated_back

LEAST_APPROACH = 1e-300  # [m/s] of a pair found intersecting: P14 asks for a speed that is not zero


@jit
def speed_bounds(flights, bodies, end, radius, bound):
    """Bounds (n,) on the speed [m/s] of any point of each body until local time `end` [s], if nothing hits it."""
    for i in range(radius.shape[0]):
        speed = acceleration = momentum = torque = 0.0
        for k in range(3):
            speed += flights.velocity[i, k] ** 2
            acceleration += flights.acceleration[i, k] ** 2
            momentum += flights.momentum[i, k] ** 2
            torque += flights.torque[i, k] ** 2
        bound[i] = sqrt(speed) + end * sqrt(acceleration)
        if flights.kind[i] == AXIS:
            bound[i] += radius[i] * (abs(flights.rate[i, 0]) + end * abs(flights.rate[i, 1]))
        elif flights.kind[i] != STILL:
            bound[i] += radius[i] * (sqrt(momentum) + end * sqrt(torque)) / bodies.moments[i, 0]


@jit
def measure(pairs, time, tolerance, x, v, R, w, reach, distance, p, q, n, approach, last):
    """Approach speed (k,) of each pair (P9), and the memory of when it was last apart.

    From the distances at the previous and the present sub-step; from the closing speed of the closest points where
    there is no previous one, or the gap is within the tolerance. Pairs beyond `reach` (k,) [m] do not approach. For
    pairs that intersect, p, q and n are those of the last state apart, carried along by the bodies (P14).
    """
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        if distance[k] >= reach[k]:
            approach[k] = -inf
            last.time[k] = nan
            continue
        if distance[k] > 0.0:
            remember(last, k, a, b, x, R, p[k], q[k], n[k])
            elapsed = time - last.time[k]
            if elapsed > 0.0 and distance[k] > tolerance[k]:
                approach[k] = (last.distance[k] - distance[k]) / elapsed
            else:
                approach[k] = closing_speed(v, w, x, a, b, p[k], q[k], n[k])
        else:
            recall(last, k, a, b, x, R, p[k], q[k], n[k])
            approach[k] = max(closing_speed(v, w, x, a, b, p[k], q[k], n[k]), LEAST_APPROACH)
        last.time[k] = time
        last.distance[k] = distance[k]


@jit
def remember(last, k, a, b, x, R, p, q, n):
    """Keeps the closest points in the frames of their bodies, their triangles and the normal."""
    pa = rotated_back(R[a], (p[0] - x[a, 0], p[1] - x[a, 1], p[2] - x[a, 2]))
    qb = rotated_back(R[b], (q[0] - x[b, 0], q[1] - x[b, 1], q[2] - x[b, 2]))
    for m in range(3):
        last.point_a[k, m], last.point_b[k, m], last.normal[k, m] = pa[m], qb[m], n[m]
    last.triangles[k, 0], last.triangles[k, 1] = last.witness[k, 0], last.witness[k, 1]


@jit
def recall(last, k, a, b, x, R, p, q, n):
    """The closest points and normal of the last state apart, the points moved with their bodies."""
    pa = rotated(R[a], (last.point_a[k, 0], last.point_a[k, 1], last.point_a[k, 2]))
    qb = rotated(R[b], (last.point_b[k, 0], last.point_b[k, 1], last.point_b[k, 2]))
    for m in range(3):
        p[m], q[m], n[m] = pa[m] + x[a, m], qb[m] + x[b, m], last.normal[k, m]
