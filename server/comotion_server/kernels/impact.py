"""One impact of two bodies (P11, P12): impulse along a normal with restitution.

Legend: x, v, R, L, w state arrays of all bodies; n unit normal from body a to body b; p, q contact points of a and b
(p, q and n in one line); r arm from the centre of mass; W inverse mass (diagonal), J impulse on b. World frame, SI.
"""

from comotion_server.kernels.flight import SPIN_FREE, angular_velocity_of, inertia_about
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import cross


@lean_jit
def closing_speed(v, w, x, a, b, p, q, n):
    """Speed [m/s] at which the points p of body a and q of body b approach along n; negative when they part."""
    total = 0.0
    for body, point, sign in ((a, p, 1.0), (b, q, -1.0)):
        r0, r1, r2 = point[0] - x[body, 0], point[1] - x[body, 1], point[2] - x[body, 2]
        c0, c1, c2 = cross((w[body, 0], w[body, 1], w[body, 2]), (r0, r1, r2))
        total += sign * (n[0] * (v[body, 0] + c0) + n[1] * (v[body, 1] + c1) + n[2] * (v[body, 2] + c2))
    return total


@lean_jit
def inverse_mass_along(bodies, i, n):
    """N . W n [1/kg]: how easily an impulse along n moves the centre of mass of body i."""
    if not bodies.reacts[i]:
        return 0.0
    W = bodies.inverse_mass[i]
    return n[0] ** 2 * W[0] + n[1] ** 2 * W[1] + n[2] ** 2 * W[2]


@lean_jit
def inverse_inertia_along(bodies, i, R, x, point, n):
    """(r x n) . I^-1 (r x n) [1/kg]: how easily an impulse along n at `point` turns body i."""
    spin = bodies.spin[i]
    if not bodies.reacts[i] or spin < SPIN_FREE:
        return 0.0
    c0, c1, c2 = cross((point[0] - x[i, 0], point[1] - x[i, 1], point[2] - x[i, 2]), n)
    c = (c0, c1, c2)
    if spin != SPIN_FREE:
        return c[spin] ** 2 / inertia_about(R[i], bodies.moments[i], bodies.principal[i], spin)
    total = 0.0
    for m in range(3):
        along = 0.0
        for k in range(3):
            axis = 0.0
            for j in range(3):
                axis += R[i, k, j] * bodies.principal[i, j, m]
            along += axis * c[k]
        total += along * along / bodies.moments[i, m]
    return total


@lean_jit
def push(bodies, i, x, v, R, L, w, point, J, turning):
    """Impulse J (3,) [N s] on body i at `point`; without `turning` it acts as if at the centre of mass (P12)."""
    if not bodies.reacts[i]:
        return
    for k in range(3):
        v[i, k] += bodies.inverse_mass[i, k] * J[k]
    spin = bodies.spin[i]
    if not turning or spin < SPIN_FREE:
        return
    c = cross((point[0] - x[i, 0], point[1] - x[i, 1], point[2] - x[i, 2]), J)
    for k in range(3):
        if spin in (SPIN_FREE, k):
            L[i, k] += c[k]
    if spin == SPIN_FREE:
        angular_velocity_of(R[i], L[i], bodies.moments[i], bodies.principal[i], w[i])
    else:
        w[i, spin] = L[i, spin] / inertia_about(R[i], bodies.moments[i], bodies.principal[i], spin)


@lean_jit
def impulse_of(bodies, a, b, x, v, R, w, p, q, n, restitution, parallel):
    """Normal impulse [N s] on b, the approach speed it answers [m/s], and whether it turns the bodies (P11, P12).

    A parallel contact answers the closing speed of the centres with the masses alone; where the centres do not close,
    the ordinary impulse. No impulse where the points part already or nothing can give way.
    """
    ease = inverse_mass_along(bodies, a, n) + inverse_mass_along(bodies, b, n)
    if parallel and ease > 0.0:
        speed = 0.0
        for k in range(3):
            speed += n[k] * (v[a, k] - v[b, k])
        if speed > 0.0:
            return (1.0 + restitution) * speed / ease, speed, ease, False
    ease += inverse_inertia_along(bodies, a, R, x, p, n) + inverse_inertia_along(bodies, b, R, x, q, n)
    speed = closing_speed(v, w, x, a, b, p, q, n)
    if speed <= 0.0 or ease == 0.0:
        return 0.0, speed, ease, True
    return (1.0 + restitution) * speed / ease, speed, ease, True
