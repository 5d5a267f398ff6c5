"""How long a cylinder's face stays clear of a triangle, along the face's own normal, which turns with it.

A cylinder that tips over an edge, on which its face stands, dips on one side of it below any fixed direction's floor,
as a middle line does (`line_time`). Along the outward normal m of its face, a corner p of the triangle is at
  g = m . (p - c) - h,   g'' >= -K,   K = B |W| + 2 rho |W'| + A,
over a time T: c, h centre and half length, W = p - c, A largest acceleration of c, rho and B largest first and second
derivative of m. The triangle is as far as the nearest of its corners.
"""

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import first_root
from comotion_server.kernels.solids import CYLINDER, HALF_LENGTH
from comotion_server.kernels.vectors import cross, dot, length, scaled, sub

WORTH = 0.2  # of the target: a distance below it may be rounding


@lean_jit
def _corner_time(course, m, p, around, down, target, T):
    """How long [s], at most T, a corner stays farther than `around` from the face."""
    W = sub(p, course.centre)
    gap = dot(m, W) - course.size[HALF_LENGTH] - around
    if gap <= WORTH * target:
        return 0.0
    slope = dot(cross(course.turn, m), W) - dot(m, course.velocity)
    B, A = course.bend / course.arm, length(course.pull) + course.error
    rho, speed = length(course.turn) + B * T, length(course.velocity) + A * T
    K = B * (length(W) + speed * T) + 2.0 * rho * speed + A
    floor = (gap if slope > 0.0 else 0.5 * gap) if down else target
    return min(first_root(gap - floor, slope, -K), T) if gap >= floor else 0.0


@lean_jit
def face_time(_, course, n, p, q, r, around, down, target, horizon):
    """How long [s], at most `horizon`, a cylinder's face that looks against n stays `around` [m] a triangle p, q, r."""
    if course.kind != CYLINDER:
        return 0.0
    m = course.axis if dot(course.axis, n) < 0.0 else scaled(course.axis, -1.0)
    time = _corner_time(course, m, p, around, down, target, horizon)
    time = min(time, _corner_time(course, m, q, around, down, target, horizon))
    return min(time, _corner_time(course, m, r, around, down, target, horizon))
