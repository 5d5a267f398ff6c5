"""Which contacts of a cluster close, stay and part at the present velocities (docs/rest.md)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.contacts import FULL, Contacts
from comotion_server.kernels.event_cluster import reaches
from comotion_server.kernels.event_queue import CONTACTS_FULL
from comotion_server.kernels.event_scene import DELTA, PAIRS
from comotion_server.kernels.foreseen import foreseen
from comotion_server.kernels.held_contacts import contacts_of_pairs, eases, gaps_at, opening_speeds
from comotion_server.kernels.held_flight import evaluate, new_course
from comotion_server.queue_room import enlarged
from comotion_server.resting import Resting
from comotion_server.touching import ROUNDING, Judgement, Pair, Touching

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

SLIGHT = 1e-6  # of the speed of a hop as high as delta: slower closing or opening of a pressed contact changes nothing
EXCURSION = 4.0  # deltas: a contact that came back from no farther off does not bounce again


def touching_among(rest: Resting, bodies: Rows, known: set[Pair], ahead: float) -> Touching:
    """All points of contact of the cluster that was gathered: within delta, and what may come so within `ahead` [s].

    `known` are the pairs that were held already.
    """
    queue, scene = rest.queue, rest.scene
    cluster, pairs = queue.cluster, queue.pairs
    rows = cluster.pairs[: cluster.size[PAIRS]].copy()
    reach = np.empty(len(rows))
    reaches(queue, scene, ahead, reach)
    parts = (scene.solids, pairs.bodies[rows], scene.x, scene.R, reach, 0.0, reach)
    members = bodies[scene.bodies.reacts[bodies]]
    return _found(rest, members, rows, known, lambda *room: contacts_of_pairs(*parts, *room))


def coming_up(rest: Resting, touching: Touching, pairs: Rows, time: float, h: float) -> Touching:
    """Contacts of some pairs that come up within `h` [s] of the bodies' flights, as they are at the beginning."""
    queue, scene = rest.queue, rest.scene
    parts = (scene.solids, scene.flights, scene.bodies, queue.pairs.bodies[pairs], DELTA * queue.pairs.tolerance[pairs])
    flight = (time, h, rest.trial, np.empty(2, dtype=np.int64))
    found = _found(rest, touching.members, pairs, set(), lambda *room: foreseen(*parts, *flight, *room))
    gaps_at(scene.solids, found.contacts, found.count, rest.state, np.empty(found.count))
    return found.of(found.contacts.gap > 0.0)


def _found(rest: Resting, members: Rows, pairs: Rows, known: set[Pair], find: Callable[..., int]) -> Touching:
    """The contacts that `find` writes to room for them, and for which of the `pairs` (p,) each is."""
    of = np.empty(len(rest.queue.cluster.pair), dtype=np.int64)
    while (count := find(rest.queue.cluster.contacts, of, rest.queue.patch_work)) == FULL:
        rest.queue = enlarged(rest.queue, CONTACTS_FULL)
        of = np.empty(len(rest.queue.cluster.pair), dtype=np.int64)
    rules, contacts = rest.rules, rest.queue.cluster.contacts
    rows = pairs[of[:count]]
    a, b = (rules.material[contacts.bodies[:count, side]] for side in (0, 1))
    return Touching(
        members,
        Contacts(*(column[:count].copy() for column in contacts)),
        rows,
        DELTA * rest.queue.pairs.tolerance[rows],
        rules.restitution[a, b] == 1.0,
        rules.friction[a, b],
        np.array([(i, j) in known for i, j in contacts.bodies[:count].tolist()], dtype=np.bool_),
    )


def judge(rest: Resting, touching: Touching, time: float, *, plastic: bool) -> Judgement:
    """Which contacts close, stay and part at the present velocities; where all is `plastic`, none bounces."""
    queue, count = rest.queue, touching.count
    speed, scale, ease = np.empty(count), np.empty(count), np.empty(count)
    opening_speeds(rest.scene.solids, touching.contacts, count, rest.state, speed, scale)
    eases(rest.scene.bodies, touching.contacts, count, rest.scene.R, ease)
    none = ROUNDING * scale
    resting = ~touching.elastic | touching.known
    inside, force, pressing = np.ones(count, dtype=np.bool_), np.zeros(count), np.zeros(count)
    while inside.any():
        force[:] = 0.0
        force[inside] = forces_of(rest, touching.of(inside))
        pressing = np.maximum(touching.totals(force), 0.0) * ease
        hop = np.maximum(np.where(resting, np.sqrt(2.0 * pressing * touching.delta), 0.0), none)
        parts = inside & (speed > hop)
        if not parts.any():
            break
        inside &= ~parts
    slight = np.maximum(none, SLIGHT * np.sqrt(2.0 * pressing * touching.delta))
    closing = speed < -slight
    back = (time - queue.pairs.hit_time[touching.pair]) * queue.pairs.hit_speed[touching.pair]
    low = resting & (-speed <= np.sqrt(2.0 * pressing * touching.delta))
    collapsed = bool((back[closing] <= EXCURSION * touching.delta[closing]).all())
    bounces = closing & ~low & (not (collapsed or plastic))
    hard = closing & (touching.totals(bounces.astype(np.float64)) > 0.0)
    stick = inside & (force > 0.0) & (speed > slight)
    return Judgement(speed, pressing, force, inside, closing, hard, stick)


def forces_of(rest: Resting, touching: Touching) -> Array:
    """What would hold each contact (c,) [N]."""
    scene, count = rest.scene, touching.count
    course, certificate = new_course(len(touching.members), count), np.zeros(count, dtype=np.bool_)
    evaluate(
        scene.solids, scene.flights, scene.bodies, touching.copy(), count, touching.members, rest.free, rest.state,
        course, 0, certificate, rest.room,
    )  # fmt: skip
    force: Array = course.force[0]
    return force
