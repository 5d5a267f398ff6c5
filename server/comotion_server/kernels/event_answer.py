"""What happens at a hit: the contact points of the cluster, the answer of the law, and what is written down of it."""

import numpy as np

from comotion_server.kernels.cluster_books import audit, carried_by, given_by
from comotion_server.kernels.contacts import CORNER_FACE
from comotion_server.kernels.event_scene import CONTACTS, NOW
from comotion_server.kernels.impact_cluster import BLOCKED, collide
from comotion_server.kernels.impact_log import IMPACTS, ROWS
from comotion_server.kernels.jit import jit
from comotion_server.kernels.vectors import add, cross, dot, length, row, sub


@jit
def opening_speed(scene, contacts, i):
    """Speed [m/s] at which contact i opens."""
    a, b, n = contacts.bodies[i, 0], contacts.bodies[i, 1], row(contacts.normal, i)
    speed_a = add(row(scene.v, a), cross(row(scene.w, a), row(contacts.arm_a, i)))
    speed_b = add(row(scene.v, b), cross(row(scene.w, b), row(contacts.arm_b, i)))
    return dot(n, sub(speed_b, speed_a))


@jit
def note_impacts(queue, scene):
    """A row of the log for each contact point that took part, and the sums and memory of the pairs."""
    cluster, log, pairs, time = queue.cluster, queue.log, queue.pairs, queue.clock[NOW]
    contacts, report = cluster.contacts, cluster.report
    count = log.count[ROWS]
    for i in range(cluster.size[CONTACTS]):
        k, J = cluster.pair[i], row(cluster.impulse, i)
        pairs.impulse[k] = add(row(pairs.impulse, k), J)
        opening = opening_speed(scene, contacts, i)
        if pairs.hit_time[k] != time or opening > pairs.hit_speed[k]:
            pairs.hit_speed[k] = max(opening, 0.0)
        pairs.hits[k] += 1 if pairs.hit_time[k] != time else 0
        pairs.hit_time[k] = time
        approach = report.approach[i]
        if approach <= 0.0 and length(J) == 0.0:
            continue
        b = contacts.bodies[i, 1]
        log.bodies[count] = contacts.bodies[i]
        log.time[count] = time
        log.contact_time[count] = time + contacts.gap[i] / approach if approach > 0.0 else time
        log.point[count] = add(row(scene.x, b), row(contacts.arm_b, i))
        log.normal[count] = contacts.normal[i]
        log.impulse[count] = J
        log.approach[count] = approach
        log.restitution[count] = cluster.restitution[i]
        log.cluster[count] = log.count[IMPACTS]
        count += 1
    log.count[ROWS] = count
    log.count[IMPACTS] += 1


@jit
def contacts_of(queue, scene, rules):
    """The contact points of all pairs of the cluster; a negative number where there is no room for them."""
    cluster = queue.cluster
    f = queue.findings
    k = cluster.pairs[0]
    a, b = queue.pairs.bodies[k, 0], queue.pairs.bodies[k, 1]
    contacts = cluster.contacts
    contacts.bodies[0, 0], contacts.bodies[0, 1] = a, b
    contacts.kind[0] = CORNER_FACE
    contacts.normal[0] = f[9:12]
    contacts.arm_a[0] = f[3:6] - scene.x[a]
    contacts.arm_b[0] = f[6:9] - scene.x[b]
    contacts.gap[0] = f[1]
    cluster.size[CONTACTS] = 1
    cluster.pair[0] = k
    one, other = rules.material[a], rules.material[b]
    cluster.restitution[0], cluster.friction[0] = rules.restitution[one, other], rules.friction[one, other]


@jit
def answer(queue, scene, rules):
    """Let the law answer the cluster; write down what happened. The law's status."""
    cluster, bodies = queue.cluster, scene.bodies
    contacts, count = cluster.contacts, cluster.size[CONTACTS]
    members = cluster.bodies[: cluster.size[0]]
    point = add(row(scene.x, contacts.bodies[0, 1]), row(contacts.arm_b, 0))
    before, after, given, scale = np.empty(7), np.empty(7), np.empty(7), np.zeros(3)
    state = (scene.x, scene.v, scene.L, scene.w)
    carried_by(bodies, members, *state, point, before, scale)
    parts = (cluster.restitution, cluster.friction, rules.law)
    status = collide(
        bodies, contacts, count, *parts, scene.v, scene.R, scene.L, scene.w, cluster.impulse, cluster.report
    )
    if status == BLOCKED:
        return status
    carried_by(bodies, members, *state, point, after, scale)
    given_by(bodies, contacts, count, scene.x, cluster.impulse, cluster.report.book, point, given)
    audit(before, after, given, scale, queue.log.books)
    note_impacts(queue, scene)
    return status
