"""The impact of one contact in closed form: j = (1 + e) c / (n.M^-1 n), without any room to work in.

Legend: c approach speed, n unit normal from a to b, r arm from the centre of mass; world frame, SI.
"""

from comotion_server.kernels.cluster_rows import arm_to_middle
from comotion_server.kernels.dual_active_set import BLOCKED, SOLVED
from comotion_server.kernels.flight import SPIN_FREE, angular_velocity_of, inertia_about
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.reflections import LOST, WORK
from comotion_server.kernels.vectors import ZERO, dot, lever, rotated_back, row, scaled, two_product, two_sum


@lean_jit
def speed_at(v, w, i, arm, n):
    """Speed along n of the point at `arm` of body i."""
    return dot(n, row(v, i)) + dot(lever(arm, n), row(w, i))


@lean_jit
def free_speed_at(bodies, i, v, w, arm, n):
    """The part of `speed_at` that impacts can change."""
    if not bodies.reacts[i]:
        return 0.0
    turn, total, spin = lever(arm, n), 0.0, bodies.spin[i]
    for k in range(3):
        if bodies.inverse_mass[i, k] > 0.0:
            total += n[k] * v[i, k]
        if spin in (SPIN_FREE, k):
            total += turn[k] * w[i, k]
    return total


@lean_jit
def ease_at(bodies, i, R, arm, n):
    """n.M^-1 n [1/kg] of body i at `arm`: how easily an impulse along n moves the point."""
    if not bodies.reacts[i]:
        return 0.0
    W, spin = row(bodies.inverse_mass, i), bodies.spin[i]
    total = n[0] * n[0] * W[0] + n[1] * n[1] * W[1] + n[2] * n[2] * W[2]
    turn = lever(arm, n)
    if spin == SPIN_FREE:
        t = rotated_back(bodies.principal[i], rotated_back(R[i], turn))
        for k in range(3):
            total += t[k] * t[k] / bodies.moments[i, k]
    elif spin > SPIN_FREE:
        total += turn[spin] ** 2 / inertia_about(R[i], bodies.moments[i], bodies.principal[i], spin)
    return total


@lean_jit
def push_at(bodies, i, arm, J, v, R, L, w):
    """Impulse J [N s] on body i at `arm`."""
    if not bodies.reacts[i]:
        return
    spin, turn = bodies.spin[i], lever(arm, J)
    for k in range(3):
        v[i, k] += bodies.inverse_mass[i, k] * J[k]
        if spin in (SPIN_FREE, k):
            L[i, k] += turn[k]
    if turn == ZERO:
        return
    if spin == SPIN_FREE:
        angular_velocity_of(R[i], L[i], bodies.moments[i], bodies.principal[i], w[i])
    elif spin > SPIN_FREE:
        w[i, spin] = L[i, spin] / inertia_about(R[i], bodies.moments[i], bodies.principal[i], spin)


@lean_jit
def collide_one(bodies, contacts, restitution, v, R, L, w, impulse, report):
    """As `impact_cluster.collide` for the first contact alone, frictionless."""
    a, b = contacts.bodies[0, 0], contacts.bodies[0, 1]
    n, r_a, r_b = row(contacts.normal, 0), arm_to_middle(contacts, 0, 0), arm_to_middle(contacts, 0, 1)
    approach = speed_at(v, w, a, r_a, n) - speed_at(v, w, b, r_b, n)
    free = free_speed_at(bodies, a, v, w, r_a, n) - free_speed_at(bodies, b, v, w, r_b, n)
    report.approach[0], report.reflections[0] = approach, 0
    report.certificate[0] = False
    impulse[0, :] = 0.0
    if approach <= 0.0:
        return SOLVED
    ease, lost = two_sum(ease_at(bodies, a, R, r_a, n), ease_at(bodies, b, R, r_b, n))
    if ease == 0.0:
        report.certificate[0] = True
        return BLOCKED
    wanted = (1.0 + restitution) * approach
    j = wanted / ease
    product, error = two_product(
        j, ease
    )  # of `ease` the rounding is the same at every impact of a pair: it would add up
    j += ((wanted - product) - error - j * lost) / ease
    J = scaled(n, j)
    impulse[0, 0], impulse[0, 1], impulse[0, 2] = J
    push_at(bodies, a, r_a, scaled(J, -1.0), v, R, L, w)
    push_at(bodies, b, r_b, J, v, R, L, w)
    report.reflections[0] = 1
    report.book[LOST] = 0.5 * (1.0 - restitution * restitution) * approach * approach / ease
    report.book[WORK] = j * (approach - free)
    return SOLVED
