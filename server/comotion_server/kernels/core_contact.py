"""Points at which two spheres or capsules touch, and their motion (docs/shapes.md, 5).

What touches are the cores, blown up by both radii: a ball's centre (a sphere has one ball, a capsule one at either
end) or the middle line between them. Capsules that lie beside each other touch along a stretch, of which the ends are
the rows. Legend: D offset of b's centre from a's, P and Q points of the cores from the centre of a, n from P to Q.
"""

from math import inf

from comotion_server.kernels.ball_contact import arm_of, balls_of
from comotion_server.kernels.contacts import CORES, FULL
from comotion_server.kernels.curved_cores import core_parameters
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.round_contact import FOUND, LINE, SAME, small_size
from comotion_server.kernels.solids import CAPSULE, HALF_LENGTH, RADIUS, SPHERE
from comotion_server.kernels.topology import FLAT
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, rotated, row, scaled, sub, unit

END = 1e-12  # of half a line: a point nearer to its end is the ball's centre


@lean_jit
def are_cores(solids, a, b):
    """Whether both bodies are spheres or capsules."""
    one, other = solids.kind[a], solids.kind[b]
    return one in (SPHERE, CAPSULE) and other in (SPHERE, CAPSULE)


@lean_jit
def _line_of(solids, R, i):
    """(unit axis, world; half the middle line [m]) of a body."""
    return rotated(R[i], row(solids.axis, i)), (solids.size[i, HALF_LENGTH] if solids.kind[i] == CAPSULE else 0.0)


@lean_jit
def _on_line(u, half, C):
    """(foot of the point C on a line through the origin, how far inside its ends [m])."""
    s = dot(u, C)
    return scaled(u, s), half - abs(s)


@lean_jit
def _stand(solids, contacts, i, D, velocity, R, w):
    """(n, its rate of change, P, Q, margin) of row i; velocity: of the centre of b against that of a [m/s]."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    one, other, margin, e, spin = contacts.feature[i, 0], contacts.feature[i, 1], inf, ZERO, ZERO
    (u, half_a), (v, half_b), w_a, w_b = _line_of(solids, R, a), _line_of(solids, R, b), row(w, a), row(w, b)
    if one == LINE and other == LINE:
        product, slant = cross(u, v), dot(u, v)
        square = dot(product, product)
        s, t = (dot(D, u) - slant * dot(D, v)) / square, (slant * dot(D, u) - dot(D, v)) / square
        P, Q = scaled(u, s), along(D, t, v)
        sign = 1.0 if dot(product, sub(Q, P)) > 0.0 else -1.0
        size = sign / length(product)
        n = scaled(product, size)
        turning = scaled(add(cross(cross(w_a, u), v), cross(u, cross(w_b, v))), size)
        return n, along(turning, -dot(n, turning), n), P, Q, min(half_a - abs(s), half_b - abs(t))
    if one == LINE:
        Q, e, spin = add(D, arm_of(solids, R, b, other)), u, w_a
        P, margin = _on_line(u, half_a, Q)
    elif other == LINE:
        P, e, spin = arm_of(solids, R, a, one), v, w_b
        foot, margin = _on_line(v, half_b, sub(P, D))
        Q = add(D, foot)
    else:
        P, Q = arm_of(solids, R, a, one), add(D, arm_of(solids, R, b, other))
    d = sub(Q, P)
    far, n = length(d), unit(d)
    if one != LINE and other != LINE:  # beyond the ends of both
        if half_a > 0.0:
            margin = far * dot(n, u) * (1.0 if one == 0 else -1.0)
        if half_b > 0.0:
            margin = min(margin, far * dot(n, v) * (-1.0 if other == 0 else 1.0))
    V = sub(add(velocity, cross(w_b, sub(Q, D))), cross(w_a, P))
    across = along(along(V, -dot(n, V), n), -dot(e, V), e)
    turning = along(scaled(across, 1.0 / far if far > 0.0 else 0.0), -dot(cross(spin, e), n), e)
    return n, turning, P, Q, margin


@lean_jit
def _write(solids, contacts, i, D, n, P, Q):
    """Normal, arms and gap of row i."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    r_a, r_b = solids.size[a, RADIUS], solids.size[b, RADIUS]
    contacts.normal[i], contacts.arm_a[i] = n, along(P, r_a, n)
    contacts.arm_b[i] = along(sub(Q, D), -r_b, n)
    contacts.gap[i] = dot(n, sub(Q, P)) - (r_a + r_b)


@lean_jit
def refresh_cores(solids, contacts, i, x, v, R, w):
    """`refresh` of a row of two spheres or capsules."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    D, velocity = sub(row(x, b), row(x, a)), sub(row(v, b), row(v, a))
    n, turning, P, Q, margin = _stand(solids, contacts, i, D, velocity, R, w)
    _write(solids, contacts, i, D, n, P, Q)
    w_a, w_b, arm = row(w, a), row(w, b), sub(Q, D)
    V = sub(add(velocity, cross(w_b, arm)), cross(w_a, P))
    inward = sub(cross(w_b, cross(w_b, arm)), cross(w_a, cross(w_a, P)))
    bias = dot(n, inward) + 2.0 * dot(turning, V) - dot(n, sub(Q, P)) * dot(turning, turning)
    return margin + 2.0 * FOUND * small_size(solids, a, b), dot(n, V), bias


@lean_jit
def _ball_at(half, s):
    """The ball at s in [-1, 1] of a middle line, or LINE."""
    if half > 0.0 and abs(s) < 1.0 - END:
        return LINE
    return 1 if half > 0.0 and s < 0.0 else 0


@lean_jit
def _add(solids, contacts, first, count, a, b, one, other, D, R, reach):
    """A row between two parts of the cores, where they are within reach and not met already: count, or FULL."""
    i = first + count
    if i >= len(contacts.gap):
        return FULL
    contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.kind[i] = a, b, CORES
    contacts.feature[i, :] = -1
    contacts.feature[i, 0], contacts.feature[i, 1] = one, other
    n, _, P, Q, _ = _stand(solids, contacts, i, D, ZERO, R, R[a])
    _write(solids, contacts, i, D, n, P, Q)
    if contacts.gap[i] > reach:
        return count
    close = SAME * small_size(solids, a, b)
    for k in range(first, i):
        d = sub(row(contacts.arm_a, k), row(contacts.arm_a, i))
        if dot(d, d) <= close * close:
            return count
    return count + 1


@lean_jit
def core_manifold(solids, a, b, x, R, reach, angle, level, contacts, first):
    """`manifold` of two spheres or capsules: the nearest points, and ends beside the other's line; or FULL."""
    D, count = sub(row(x, b), row(x, a)), 0
    (u, half_a), (v, half_b) = _line_of(solids, R, a), _line_of(solids, R, b)
    turn = cross(u, v)
    across = half_a == 0.0 or half_b == 0.0 or dot(turn, turn) > max(angle, FLAT) ** 2
    if across:
        s, t = core_parameters(scaled(u, half_a), scaled(v, half_b), D)
        one, other = _ball_at(half_a, s), _ball_at(half_b, t)
        return _add(solids, contacts, first, count, a, b, one, other, D, R, reach)
    reach = max(reach, level) if angle > 0.0 else reach
    for ball in range(balls_of(solids, a)):
        s = dot(v, sub(arm_of(solids, R, a, ball), D))
        if abs(s) <= half_b and count >= 0:
            count = _add(solids, contacts, first, count, a, b, ball, LINE, D, R, reach)
    for ball in range(balls_of(solids, b)):
        s = dot(u, add(D, arm_of(solids, R, b, ball)))
        if abs(s) <= half_a and count >= 0:
            count = _add(solids, contacts, first, count, a, b, LINE, ball, D, R, reach)
    if count == 0:
        for one in range(2):
            for other in range(2):
                if count >= 0:
                    count = _add(solids, contacts, first, count, a, b, one, other, D, R, reach)
    return count
