"""How long a capsule's middle line stays clear of a triangle's edges and corners, by directions that turn with it.

A line that rocks on an edge dips on one side of it, below any fixed direction's floor. So the direction m is taken
that stays at right angles to the line (docs/shapes.md, 4): for an edge e, m = u x e of length 1; for a corner, the way
from it to the line. Legend: u the capsule's axis, W its centre from a point of the edge or from the corner, c1, A
velocity and largest acceleration of the centre; rho, B largest first and second derivative of u; all in the frame.

The distance along m is g, with g'' >= -K:
  edge    K = (B / sine + 3 k^2) |W| + 2 k |W'| + A,    |m'| <= k = rho / sine,      sine >= |u x e| - rho T
  corner  K = A + 4 |W'| rho + 2 |W| (B + rho^2),       |m'| <= k = |P'| / |P|,      P = W - (W.u) u
over a time T. The triangle's other corners have to stay below those of the edge, or below the corner, along m.
"""

from math import inf

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import first_root
from comotion_server.kernels.vectors import along, cross, dot, length, scaled, sub, unit

TRIES = 6  # bounds over ever shorter times
SHRINK = 2.0
WORTH = 0.2  # of the target: a distance below it may be rounding


@lean_jit
def _below(m, rate, p, x):
    """How long [s] the corner x stays below p along m, which turns by `rate` [1/s] at most; 0 where it is not."""
    d = sub(x, p)
    fall, size = -dot(m, d), length(d)
    if size == 0.0:
        return inf
    if fall <= 0.0:
        return 0.0
    return fall / (rate * size) if rate > 0.0 else inf


@lean_jit
def _root(slack, slope, down, target, K):
    """When the distance along m, `slack` [m] now, could come down to its floor."""
    floor = target
    if down:
        floor = slack if slope > 0.0 else 0.5 * slack
    return first_root(slack - floor, slope, -K) if slack >= floor else 0.0


@lean_jit
def _edge_time(course, p, q, other, rim, down, target, horizon):
    """Along the edge from p to q; other: the third corner."""
    e, u = unit(sub(q, p)), course.axis
    product = cross(u, e)
    sine = length(product)
    W = sub(course.centre, p)
    W = along(W, -dot(W, e), e)
    if sine < 1e-6:
        return 0.0
    scale = (1.0 if dot(product, W) >= 0.0 else -1.0) / sine
    m = scaled(product, scale)
    slack = dot(m, W) - rim
    if slack <= WORTH * target:
        return 0.0
    turning = scaled(cross(cross(course.turn, u), e), scale)
    turning = along(turning, -dot(turning, m), m)
    slope = dot(turning, W) + dot(m, course.velocity)
    B, A = course.bend / course.arm, length(course.pull) + course.error
    best, T = 0.0, horizon
    for _ in range(TRIES):
        rho = length(course.turn) + B * T
        left = sine - rho * T
        if left > 0.5 * sine:
            rate, speed = rho / left, length(course.velocity) + A * T
            far = length(W) + speed * T
            K = (B / left + 3.0 * rate * rate) * far + 2.0 * rate * speed + A
            time = min(_root(slack, slope, down, target, K), _below(m, rate, p, other))
            best = max(best, min(time, T))
            if time >= T:
                break
            T = min(SHRINK * time, 0.5 * T) if time > 0.0 else 0.1 * T
        else:
            T = min(0.5 * T, 0.4 * sine / rho)
    return best


@lean_jit
def _corner_time(course, p, x, y, rim, down, target, horizon):
    """Over the corner p; x, y: the other ones."""
    u, W = course.axis, sub(course.centre, p)
    t = dot(W, u)
    P = along(W, -t, u)
    size, m = length(P), unit(P)
    slack = size - rim
    if abs(t) > course.arm or slack <= WORTH * target:
        return 0.0
    slope = dot(m, course.velocity) - t * dot(m, cross(course.turn, u))
    B, A = course.bend / course.arm, length(course.pull) + course.error
    best, T = 0.0, horizon
    for _ in range(TRIES):
        rho, speed = length(course.turn) + B * T, length(course.velocity) + A * T
        far = length(W) + speed * T
        moves = speed + 2.0 * far * rho
        left = size - moves * T
        if left > 0.5 * size:
            K, rate = A + 4.0 * speed * rho + 2.0 * far * (B + rho * rho), moves / left
            time = min(_root(slack, slope, down, target, K), _below(m, rate, p, x), _below(m, rate, p, y))
            best = max(best, min(time, T))
            if time >= T:
                break
            T = min(SHRINK * time, 0.5 * T) if time > 0.0 else 0.1 * T
        else:
            T = min(0.5 * T, 0.4 * size / moves)
    return best


@lean_jit
def line_time(course, p, q, r, rim, down, target, horizon):
    """How long [s], at most `horizon`, a capsule stays clear of the triangle p, q, r along such directions.

    rim: what the distance of the middle line has to exceed [m]; down: whether the gap has come down to the target.
    """
    best = 0.0
    for k in range(3):
        a, b, c = (p, q, r) if k == 0 else ((q, r, p) if k == 1 else (r, p, q))
        if best < horizon:
            best = max(best, _edge_time(course, a, b, c, rim, down, target, horizon))
        if best < horizon:
            best = max(best, _corner_time(course, a, b, c, rim, down, target, horizon))
    return best
