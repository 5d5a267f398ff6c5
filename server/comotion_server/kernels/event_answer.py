"""What happens at a hit: the contact points of the cluster, the answer of the law, and what is written down of it."""

from comotion_server.kernels.cluster_books import audit, carried_by, given_by
from comotion_server.kernels.contact_manifold import manifold
from comotion_server.kernels.event_scene import BODIES, CONTACTS, CUT_SHORT, DELTA, PAIRS
from comotion_server.kernels.impact_cluster import BLOCKED, SOLVED, collide
from comotion_server.kernels.impact_log import IMPACTS, ROWS
from comotion_server.kernels.impact_query import CLOSING
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import add, cross, dot, length, row, sub

LEVEL = 1.5  # times angle and size: how far apart faces that are level to within the angle may be at their far ends


@lean_jit
def opening_speed(scene, contacts, i):
    """Speed [m/s] at which contact i opens."""
    a, b, n = contacts.bodies[i, 0], contacts.bodies[i, 1], row(contacts.normal, i)
    speed_a = add(row(scene.v, a), cross(row(scene.w, a), row(contacts.arm_a, i)))
    speed_b = add(row(scene.v, b), cross(row(scene.w, b), row(contacts.arm_b, i)))
    return dot(n, sub(speed_b, speed_a))


@lean_jit
def note_impacts(queue, scene):
    """A row of the log for each contact point that took part, and the memory of the pairs."""
    cluster, log, pairs, time = queue.cluster, queue.log, queue.pairs, queue.now[0]
    contacts, report = cluster.contacts, cluster.report
    count = log.total[ROWS]
    for i in range(cluster.size[CONTACTS]):
        k, J = cluster.pair[i], row(cluster.impulse, i)
        opening = opening_speed(scene, contacts, i)
        again = pairs.hit_time[k] == time
        pairs.hit_speed[k] = max(opening, pairs.hit_speed[k] if again else 0.0)
        pairs.hit_time[k] = time
        approach = report.approach[i]
        if approach <= 0.0 and length(J) == 0.0:
            continue
        b = contacts.bodies[i, 1]
        log.bodies[count, 0], log.bodies[count, 1] = contacts.bodies[i, 0], b
        log.time[count] = time
        log.contact_time[count] = time + contacts.gap[i] / approach if approach > 0.0 else time
        log.point[count] = add(row(scene.x, b), row(contacts.arm_b, i))
        log.normal[count] = row(contacts.normal, i)
        log.impulse[count] = J
        log.approach[count] = approach
        log.restitution[count] = cluster.restitution[i]
        log.cluster[count] = log.total[IMPACTS]
        count += 1
    log.total[ROWS] = count
    log.total[IMPACTS] += 1


@lean_jit
def _level_gap(rules, size, reach, closing):
    """Up to which gap [m] points of level faces belong to a contact: faces of this size, tilted within the angle."""
    return max(reach, LEVEL * rules.angle * size, rules.duration * closing)


@lean_jit
def contacts_of(queue, scene, rules):
    """The contact points of all pairs of the cluster; False where there is no room for them."""
    cluster, solids = queue.cluster, scene.solids
    count = 0
    for p in range(cluster.size[PAIRS]):
        k = cluster.pairs[p]
        a, b = queue.pairs.bodies[k, 0], queue.pairs.bodies[k, 1]
        reach, size = DELTA * queue.pairs.tolerance[k], 2.0 * min(solids.radius[a], solids.radius[b])
        level = _level_gap(rules, size, reach, queue.findings[CLOSING])
        where = (reach, rules.angle, level, cluster.contacts, count)
        found = manifold(solids, a, b, scene.x, scene.R, *where, queue.patch_work)
        if found < 0:
            return False
        one, other = rules.material[a], rules.material[b]
        for i in range(count, count + found):
            cluster.pair[i] = k
            cluster.restitution[i], cluster.friction[i] = rules.restitution[one, other], rules.friction[one, other]
        count += found
    cluster.size[CONTACTS] = count
    return True


@lean_jit
def answer(queue, scene, rules):
    """Let the law answer the cluster; write down what happened. The law's status."""
    cluster, bodies = queue.cluster, scene.bodies
    contacts, count = cluster.contacts, cluster.size[CONTACTS]
    members = cluster.bodies[: cluster.size[BODIES]]
    point = add(row(scene.x, contacts.bodies[0, 1]), row(contacts.arm_b, 0))
    before, after, given, scale = cluster.ledgers[0], cluster.ledgers[1], cluster.ledgers[2], cluster.ledgers[3]
    scale[:] = 0.0
    state = (scene.x, scene.v, scene.L, scene.w)
    carried_by(bodies, members, *state, point, before, scale)
    parts = (cluster.restitution, cluster.friction, rules.law)
    status = collide(
        bodies, contacts, count, *parts, scene.v, scene.R, scene.L, scene.w, cluster.impulse, cluster.report
    )
    if status == BLOCKED:
        return status
    if status != SOLVED:
        queue.tally[CUT_SHORT] += 1
    carried_by(bodies, members, *state, point, after, scale)
    given_by(bodies, contacts, count, scene.x, cluster.impulse, cluster.report.book, point, given)
    audit(before, after, given, scale, cluster.ledgers[4], queue.log.books)
    note_impacts(queue, scene)
    return status
