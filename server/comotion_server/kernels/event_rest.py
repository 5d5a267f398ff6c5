"""Which clusters come to rest: hops lower than the distance within which bodies touch cannot be told from contact.

A contact is pressed when its gap accelerates towards zero on the flights as they are. From a speed u it then hops by
u^2 / (2 |a|), so up to sqrt(2 |a| delta) it never leaves. Where nothing presses, bodies that go back and forth between
others come to rest as well: the way that a pair went apart since its last impact, (t - t_last) u, falls below delta.
"""

from math import sqrt

from comotion_server.kernels.contact_motion import refresh
from comotion_server.kernels.event_scene import CONTACTS, DELTA
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import angular_acceleration
from comotion_server.kernels.vectors import add, cross, dot, length, row, sub

EXCURSION = 4.0  # times delta: a pair that went no farther since its last impact has not parted
STILL = 1e-13  # of the speeds of two points: slower against each other is not moving


@lean_jit
def _acceleration(scene, i, arm, turned):
    """Acceleration [m/s2] of a point of body i that its arm would give without turning on: a + alpha x arm."""
    alpha = angular_acceleration(scene.flights, scene.bodies, i, scene.R, scene.L, scene.w, turned)
    return add(row(scene.flights.acceleration, i), cross(alpha, arm))


@lean_jit
def gap_motion(scene, contacts, i, turned):
    """(speed, acceleration) with which contact i opens on the flights as they are; its row is taken afresh."""
    _, opening, bias = refresh(scene.solids, contacts, i, scene.x, scene.v, scene.R, scene.w)
    a, b, n = contacts.bodies[i, 0], contacts.bodies[i, 1], row(contacts.normal, i)
    pull = sub(
        _acceleration(scene, b, row(contacts.arm_b, i), turned), _acceleration(scene, a, row(contacts.arm_a, i), turned)
    )
    return opening, dot(n, pull) + bias


@lean_jit
def _speed_scale(scene, contacts, i):
    """Size [m/s] of the speeds whose difference is that of contact i."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    scale = length(row(scene.v, a)) + length(row(scene.w, a)) * length(row(contacts.arm_a, i))
    return scale + length(row(scene.v, b)) + length(row(scene.w, b)) * length(row(contacts.arm_b, i))


@lean_jit
def hops_low(queue, scene, i, opening, acceleration):
    """Whether contact i is pressed and, moving at this speed, cannot leave."""
    cluster = queue.cluster
    delta = DELTA * queue.pairs.tolerance[cluster.pair[i]]
    if acceleration >= 0.0:
        return False
    slow = abs(opening) <= STILL * _speed_scale(scene, cluster.contacts, i)
    return slow or (cluster.restitution[i] < 1.0 and abs(opening) <= sqrt(-2.0 * acceleration * delta))


@lean_jit
def comes_to_rest(queue, scene, time):
    """Whether all contacts that close would hop no higher than they touch, or went no farther since they last hit."""
    cluster, pairs, turned = queue.cluster, queue.pairs, queue.turned
    closing = False
    for i in range(cluster.size[CONTACTS]):
        opening, acceleration = gap_motion(scene, cluster.contacts, i, turned)
        if opening >= 0.0:
            continue
        closing = True
        k = cluster.pair[i]
        way = (time - pairs.hit_time[k]) * max(pairs.hit_speed[k], -opening)
        short = cluster.restitution[i] < 1.0 and way <= EXCURSION * DELTA * pairs.tolerance[k]
        if not short and not hops_low(queue, scene, i, opening, acceleration):
            return False
    return closing


@lean_jit
def stays_at_rest(queue, scene):
    """Whether some contact, after the impact, is pressed and does not leave."""
    cluster = queue.cluster
    for i in range(cluster.size[CONTACTS]):
        opening, acceleration = gap_motion(scene, cluster.contacts, i, queue.turned)
        if hops_low(queue, scene, i, opening, acceleration):
            return True
    return False
