"""The event queue: bodies fly, the earliest contact is answered, and only what changed is asked again.

`play` is one loop over the heap. Its first item is either a body that leaves its room, which gets new neighbours; or a
timer of the caller; or a pair, which is followed until its contact, or until the next item is earlier (a search of the
A* kind: times in the heap are proven lower bounds, so a contact that is first in the heap is the first of all). At a
contact the cluster is gathered and answered, its bodies take off anew, and their pairs are asked again from then on.
"""

from math import inf

import numpy as np

from comotion_server.kernels.event_answer import answer, contacts_of
from comotion_server.kernels.event_cluster import gather
from comotion_server.kernels.event_heap import first, put, second_time, take_out
from comotion_server.kernels.event_rest import comes_to_rest, stays_at_rest
from comotion_server.kernels.event_scene import (
    ANSWERED,
    ASKED,
    BODIES,
    CONTACTS,
    HITS,
    ITEMS,
    LEFT,
    LONGEST_RUN,
    NOW,
    ROOMS,
    ROW,
    RUN,
    TIMER,
    UNTIL,
)
from comotion_server.kernels.flight import SPIN_NONE, begin, motion_of
from comotion_server.kernels.impact_cluster import BLOCKED as LAW_BLOCKED
from comotion_server.kernels.impact_log import ROWS, clear
from comotion_server.kernels.impact_query import MEETS, OVERLAPS, STALLS, TARGET, TIME, TOUCHES, forget_flight
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.motion_bounds import spin_line
from comotion_server.kernels.neighbour_cells import is_amid, leaving_time, make_room, neighbours, rooms_meet
from comotion_server.kernels.pair_bounds import apart_for
from comotion_server.kernels.pair_memory import NO_ROW, join, part, partner
from comotion_server.kernels.solid_impact import advance_pair
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.sphere_impact import foresee, has_closed_form
from comotion_server.kernels.vectors import largest, row

DONE, REST, ISLAND, MERGES, BLOCKED, LOG_FULL, PAIRS_FULL, CONTACTS_FULL, SPENT, STALLED, OVERLAPPING = range(11)

MOST_AT_ONCE = 100  # hits of one pair at one time; laws settle it in one or two
QUERY_BUDGET = 1_000_000  # distance queries and steps of one pair in one go


@lean_jit
def rank_of(queue, k):
    """Where pair k stands among items of the same time."""
    return queue.pairs.bodies[k, 0] * len(queue.held) + queue.pairs.bodies[k, 1]


@lean_jit
def _put_pair(queue, k, time):
    put(queue.heap, 2 * len(queue.held) + k, time, rank_of(queue, k))


@lean_jit
def _put_again(queue, scene, k):
    """Put pair k, of which nothing is known beyond its proven time: at its contact where that has a closed form."""
    pairs = queue.pairs
    memory, a, b = pairs.memory[k], pairs.bodies[k, 0], pairs.bodies[k, 1]
    if has_closed_form(scene.solids, scene.flights, a, b):
        queue.tally[ASKED] += 1
        foresee(scene.solids, scene.flights, a, b, pairs.tolerance[k], queue.now[UNTIL], memory)
    if memory[TIME] < inf:
        _put_pair(queue, k, memory[TIME])
    else:
        take_out(queue.heap, 2 * len(queue.held) + k)


@lean_jit
def set_timer(queue, i, time):
    """`play` returns ISLAND for body i at a local time [s]; inf: never."""
    item = len(queue.held) + i
    if time < inf:
        put(queue.heap, item, time, item - 2 * len(queue.held))
    else:
        take_out(queue.heap, item)


@lean_jit
def _time_room(queue, scene, i, time):
    """When body i leaves its room is an item of the heap, if ever."""
    leaves = leaving_time(queue.cells, scene.flights, i, time)
    if leaves < inf:
        put(queue.heap, i, max(leaves, time), i - 2 * len(queue.held))
    else:
        take_out(queue.heap, i)


@lean_jit
def _may_meet(scene, i, j):
    """Whether a contact of two bodies means anything: one of them reacts, and not both are planes."""
    kind = scene.solids.kind
    return (scene.bodies.reacts[i] or scene.bodies.reacts[j]) and not (kind[i] == PLANE and kind[j] == PLANE)


@lean_jit
def look_around(queue, scene, i, time):
    """Pairs of body i with all whose rooms meet its own, and no others; False where there are more than room for."""
    cells, pairs = queue.cells, queue.pairs
    link = pairs.first[i]
    while link >= 0:
        after, k, j = pairs.next[link], link >> 1, partner(pairs, link)
        if not rooms_meet(cells, i, j):
            take_out(queue.heap, 2 * len(queue.held) + k)
            part(pairs, k)
        link = after
    count = neighbours(cells, i, queue.found)
    link = pairs.first[i]
    while link >= 0:
        cells.seen[partner(pairs, link)] = -1
        link = pairs.next[link]
    for f in range(count):
        j = queue.found[f]
        if cells.seen[j] == -1 or not _may_meet(scene, i, j):
            continue
        tolerance = max(min(queue.tolerance[i], queue.tolerance[j]), queue.grain[i], queue.grain[j])
        k = join(pairs, i, j, time, tolerance)
        if k == NO_ROW:
            return False
        _put_again(queue, scene, k)
    return True


@jit
def _new_room(queue, scene, i, time):
    """A new room for body i, which may be about to leave its own; False where there are more pairs than room for."""
    x, v = motion_of(scene.flights, i, time)
    if not is_amid(queue.cells, i, x):
        queue.tally[ROOMS] += 1
        make_room(queue.cells, i, x, v)
        if not look_around(queue, scene, i, time):
            return False
    _time_room(queue, scene, i, time)
    return True


@lean_jit
def take_off(queue, scene, i, time):
    """Body i is on a new flight from a local time [s]: its pairs are asked again from then on."""
    pairs = queue.pairs
    link = pairs.first[i]
    while link >= 0:
        k = link >> 1
        forget_flight(pairs.memory[k], time)
        _put_again(queue, scene, k)
        link = pairs.next[link]
    _time_room(queue, scene, i, time)


@lean_jit
def start(queue, scene):
    """Find the pairs of all bodies; False where there are more than room for."""
    complete = True
    for i in range(len(queue.held)):
        complete &= look_around(queue, scene, i, 0.0)
    return complete


@jit
def begin_step(queue, scene, elapsed):
    """All bodies are on new flights from local time 0, where the scene has their states; 0 was `elapsed` [s] before."""
    pairs, flights, R = queue.pairs, scene.flights, np.empty((3, 3))
    clear(queue.log)
    queue.now[NOW] = 0.0
    spin = np.empty((len(queue.held), 2))
    for i in range(len(queue.held)):
        spin[i] = spin_line(flights, scene.bodies, i, row(flights.momentum, i), row(scene.w, i))
        _time_room(queue, scene, i, 0.0)
    for k in range(len(pairs.bodies)):
        a, b = pairs.bodies[k, 0], pairs.bodies[k, 1]
        if a >= 0:
            memory, tolerance = pairs.memory[k], pairs.tolerance[k]
            pairs.hit_time[k] -= elapsed
            time = apart_for(scene.solids, flights, a, b, spin, tolerance, memory, R)
            forget_flight(memory, time)
            memory[TARGET] = 0.5 * tolerance if time > 0.0 else 0.0
            _put_pair(queue, k, time)


@lean_jit
def _follow(queue, scene, k, until):
    """How the time of impact of pair k ended, followed as long as it is the first in the heap; it gets a new time."""
    pairs = queue.pairs
    memory, a, b = pairs.memory[k], pairs.bodies[k, 0], pairs.bodies[k, 1]
    key = max(second_time(queue.heap), np.nextafter(memory[TIME], inf))
    limits = (until, key, pairs.tolerance[k], QUERY_BUDGET)
    bodies = (scene.solids, scene.flights, scene.bodies, a, b)
    status = advance_pair(*bodies, *limits, memory, pairs.witness[k], queue.findings, queue.work, queue.counts)
    queue.tally[ASKED] += 1
    if memory[TIME] < inf:
        _put_pair(queue, k, memory[TIME])
    else:
        take_out(queue.heap, 2 * len(queue.held) + k)
    return status


@lean_jit
def _count_run(queue, k, time):
    """Note a hit of pair k, and how many it had at this very time; False where they do not end."""
    tally = queue.tally
    tally[LEFT] -= 1
    tally[HITS] += 1
    tally[RUN] = tally[RUN] + 1 if time == queue.pairs.hit_time[k] else 0
    tally[LONGEST_RUN] = max(tally[LONGEST_RUN], tally[RUN])
    return tally[RUN] < MOST_AT_ONCE


@lean_jit
def joins(bodies, a, b, restitution):
    """Whether a contact of bodies a and b makes one of them: plastic, and none of them moves as it is told."""
    for i in (a, b):
        if not bodies.reacts[i] and (bodies.spin[i] != SPIN_NONE or largest(row(bodies.inverse_mass, i)) > 0.0):
            return False
    return restitution == 0.0


@lean_jit
def _for_caller(queue, scene, rules, time):
    """Whether the cluster is to be handed to the caller before anything is changed, and as what; else DONE."""
    cluster = queue.cluster
    if rules.merging:
        for i in range(cluster.size[CONTACTS]):
            a, b = cluster.contacts.bodies[i, 0], cluster.contacts.bodies[i, 1]
            if joins(scene.bodies, a, b, cluster.restitution[i]):
                return MERGES
    for m in range(cluster.size[BODIES]):
        if queue.held[cluster.bodies[m]]:
            return REST
    return REST if rules.resting and comes_to_rest(queue, scene, time) else DONE


@lean_jit
def _hit(queue, scene, rules, k, time):
    """Answer the hit of pair k: DONE, or why the caller must go on."""
    cluster, tally = queue.cluster, queue.tally
    tally[ROW], tally[ANSWERED] = k, 0
    if tally[LEFT] <= 0:
        return SPENT
    gather(queue, scene, k, time)
    if not contacts_of(queue, scene, rules):
        return CONTACTS_FULL
    if queue.log.total[ROWS] + cluster.size[CONTACTS] > len(queue.log.time):
        return LOG_FULL
    code = _for_caller(queue, scene, rules, time)
    if code != DONE:
        return code
    if cluster.size[CONTACTS] == 0 or not _count_run(queue, k, time):
        return STALLED
    if answer(queue, scene, rules) == LAW_BLOCKED:
        return BLOCKED
    tally[ANSWERED] = 1
    for m in range(cluster.size[BODIES]):
        i = cluster.bodies[m]
        if scene.bodies.reacts[i]:
            begin(scene.flights, scene.bodies, i, time, scene.x[i], scene.v[i], scene.R[i], scene.L[i], scene.w[i])
            take_off(queue, scene, i, time)
    return REST if rules.resting and stays_at_rest(queue, scene) else DONE


@jit
def play(queue, scene, rules, until):
    """Move all bodies on their flights to the local time `until` [s], answering impacts on the way.

    DONE       nothing more happens before `until`
    REST       the cluster comes to rest, or one of its bodies is held; if tally[ANSWERED], after its impact
    ISLAND     the timer of body tally[TIMER] is due
    MERGES     contacts of the cluster make one of their bodies (`joins`): nothing was changed
    BLOCKED    no motion satisfies the contacts marked in the report: nothing was changed
    LOG_FULL, PAIRS_FULL, CONTACTS_FULL  an array is full: with a larger one the queue can be taken up again
    SPENT      as many hits were answered as tally[LEFT] allowed
    STALLED    numbers are too coarse to follow pair tally[ROW]
    OVERLAPPING  the bodies of pair tally[ROW] intersect
    The local time is in queue.now[NOW]; the cluster, with its states at that time, is in queue.cluster and the
    scene; all other bodies are where their flights have them. Calling again goes on.
    """
    n = len(queue.held)
    queue.now[UNTIL] = until
    while True:
        time, item = first(queue.heap)
        if not time < until:
            queue.now[NOW] = until
            return DONE
        queue.now[NOW] = time
        queue.tally[ITEMS] += 1
        if item < n:
            if not _new_room(queue, scene, item, time):
                return PAIRS_FULL
            continue
        if item < 2 * n:
            queue.tally[TIMER] = item - n
            return ISLAND
        k = item - 2 * n
        status = _follow(queue, scene, k, until)
        if status in (OVERLAPS, STALLS):
            queue.tally[ROW] = k
            return OVERLAPPING if status == OVERLAPS else STALLED
        if status in (MEETS, TOUCHES) and first(queue.heap)[1] == item:
            queue.now[NOW] = queue.pairs.memory[k, TIME]
            code = _hit(queue, scene, rules, k, queue.now[NOW])
            if code != DONE:
                return code
