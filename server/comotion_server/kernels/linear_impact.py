"""The contact time of two triangles, edges or vertices whose corners move on straight lines, each at its own speed.

The same proven steps as for rigid bodies (`pair_impact`), with bounds that are simpler: nothing bends the paths. A
vertex is a triangle of three equal corners, an edge one of two.
"""

from math import sqrt

from comotion_server.kernels.jit import jit
from comotion_server.kernels.motion_bounds import Spin
from comotion_server.kernels.pair_impact import FREE, HIT, PAIR_STEPS, STALLED
from comotion_server.kernels.pair_impact_bounds import Corners, Limits, safe_time
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.kernels.vectors import ZERO, along, dot, row, sub

AT_REST = (ZERO, ZERO, ZERO)
NO_SPIN = Spin(0.0, 0.0, 0.0, 1, ZERO)


@jit
def _moved(x, v, s):
    return along(x[0], s, v[0]), along(x[1], s, v[1]), along(x[2], s, v[2])


@jit
def _limits(c, horizon):
    """`Limits` of corners that move straight on."""
    extent, speed = 0.0, 0.0
    for i in range(3):
        for j in range(3):
            D, V = sub(c.b[j], c.a[i]), sub(c.velocity_b[j], c.velocity_a[i])
            extent, speed = max(extent, dot(D, D)), max(speed, dot(V, V))
    speed = sqrt(speed)
    return Limits(NO_SPIN, NO_SPIN, 0.0, 0.0, 0.0, speed, sqrt(extent) + speed * horizon)


@jit
def linear_impact(a, b, velocity_a, velocity_b, end, tolerance):
    """(FREE, HIT or STALLED, time) of two triangles from time 0 to `end` [s], corners as tuples [m], [m/s].

    HIT: the gap is within the tolerance [m] at `time`, and before it they are apart. FREE: apart until `end`. STALLED:
    apart until `time`, and no step possible. The steps aim at half the tolerance.
    """
    now = 0.0
    for _ in range(PAIR_STEPS):
        c = Corners(_moved(a, velocity_a, now), _moved(b, velocity_b, now), velocity_a, velocity_b, AT_REST, AT_REST)
        distance, _, _, n = triangle_points(c.a[0], c.a[1], c.a[2], c.b[0], c.b[1], c.b[2])
        if distance <= tolerance:
            return HIT, now
        horizon = end - now
        step = safe_time(n, c, _limits(c, horizon), 0.5 * tolerance, horizon)
        if step >= horizon:
            return FREE, end
        if not now + step > now:
            break
        now += step
    return STALLED, now


@jit
def linear_impacts(a, b, velocity_a, velocity_b, end, tolerance, status, time):
    """Many queries: corners and velocities (k, 3, 3); out: status (k,) int64, time (k,)."""
    for k in range(len(a)):
        status[k], time[k] = linear_impact(
            (row(a[k], 0), row(a[k], 1), row(a[k], 2)),
            (row(b[k], 0), row(b[k], 1), row(b[k], 2)),
            (row(velocity_a[k], 0), row(velocity_a[k], 1), row(velocity_a[k], 2)),
            (row(velocity_b[k], 0), row(velocity_b[k], 1), row(velocity_b[k], 2)),
            end,
            tolerance,
        )
