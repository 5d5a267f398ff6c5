"""Contacts that close are answered, and held ones put back in the middle of delta (docs/rest.md)."""

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.event_answer import answer, contacts_of
from comotion_server.kernels.event_queue import CONTACTS_FULL
from comotion_server.kernels.event_scene import CONTACTS, DELTA
from comotion_server.kernels.flight import fly_rows
from comotion_server.kernels.held_contacts import gaps_at, gaps_of_pairs, kinetic_energy, move
from comotion_server.kernels.held_flight import correct
from comotion_server.kernels.impact_cluster import BLOCKED, SOLVED, displacements, settle_velocities
from comotion_server.queue_room import enlarged
from comotion_server.resting import Resting
from comotion_server.touching import Judgement, SoftImpact, Touching, approach_of

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]

BAND = 0.25  # of delta: how far a held gap may be off its middle before it is put back; above 0.4 it touches or opens
KEEP = 0.1  # of delta: the gap that all others keep when some are put back; below, they touch
LEAST = 0.05  # of delta: nothing is put back where it would bring bodies closer than this


def bounce(rest: Resting, touching: Touching, found: Judgement) -> bool:
    """An impact of the whole cluster; pairs whose contacts close softly take it with e = 0."""
    scene = rest.scene
    while not contacts_of(rest.queue, scene, rest.rules):
        rest.queue = enlarged(rest.queue, CONTACTS_FULL)
    queue, cluster = rest.queue, rest.queue.cluster
    soft = np.setdiff1d(touching.pair[found.closing], touching.pair[found.hard])
    count = cluster.size[CONTACTS]
    cluster.restitution[:count][np.isin(cluster.pair[:count], soft)] = 0.0
    status = answer(queue, scene, rest.rules)
    return rest.possible(status, cluster.contacts, cluster.report.certificate[:count])


def close(rest: Resting, touching: Touching, found: Judgement, time: float) -> bool:
    """Contacts that close, stop, whatever others do then; where none closes, those that stick are closed."""
    scene, pairs, count = rest.scene, rest.queue.pairs, touching.count
    impulse, certificate = np.zeros(count), np.zeros(count, dtype=np.bool_)
    motion = scene.v, scene.R, scene.L, scene.w
    before = kinetic_energy(scene.bodies, touching.members, scene.v, scene.L, scene.w)
    exactly = found.inside & (found.force > 0.0) & (not found.closing.any())
    status = BLOCKED
    for equal in (exactly, np.zeros_like(exactly)):  # what cannot be closed exactly is no pinch
        parts = (scene.bodies, touching.contacts, count, equal, np.zeros(count))
        if status == BLOCKED:
            status = settle_velocities(*parts, *motion, impulse, certificate)
    if not rest.possible(status, touching.contacts, certificate):
        return False
    after = kinetic_energy(scene.bodies, touching.members, scene.v, scene.L, scene.w)
    contacts, pushed = touching.contacts, np.flatnonzero(impulse)
    work = impulse[pushed] @ approach_of(scene, contacts, pushed, ~scene.bodies.reacts)
    rest.record.rest_energy += before - after + float(work)
    rest.record.add_held(contacts.bodies, impulse[:, None] * contacts.normal)
    rows = touching.pair[found.closing]
    pairs.hit_time[rows], pairs.hit_speed[rows] = time, 0.0
    for i in np.flatnonzero(found.closing & ~touching.known & (impulse > 0.0)):
        a, b = contacts.bodies[i].tolist()
        point = scene.x[b] + contacts.arm_b[i]
        soft = SoftImpact(time, (a, b), point, contacts.normal[i].copy(), float(impulse[i]), -float(found.speed[i]))
        rest.record.soft.append(soft)
    return True


def put_back(rest: Resting, touching: Touching, found: Judgement, time: float) -> None:
    """Moves bodies so that loaded contacts are in the middle of delta; all others keep a gap.

    Where not all of them can be there at once, those that are too near at least come off as far.
    """
    delta, gap = touching.delta, touching.contacts.gap
    off, loaded = gap - 0.5 * delta, found.inside & (found.force > 0.0)
    near = found.inside & (off < -BAND * delta)
    if not (near | (loaded & (off > BAND * delta))).any():
        return
    keeps = np.minimum(KEEP * delta - gap, 0.0)
    if not _shift(rest, touching, loaded, np.where(loaded, -off, keeps), time):
        _shift(rest, touching, np.zeros_like(loaded), np.where(near, -off, keeps), time)


def come_off(rest: Resting, touching: Touching, time: float) -> None:
    """Moves bodies so that contacts that are too near are in the middle of delta; no other comes nearer than that."""
    off = touching.contacts.gap - 0.5 * touching.delta
    near = off < -BAND * touching.delta
    if near.any():
        target = np.where(near, -off, np.minimum(-off, 0.0))
        _shift(rest, touching, np.zeros_like(near), target, time)
        gaps_at(rest.scene.solids, touching.contacts, touching.count, rest.state, np.empty(touching.count))


def _shift(rest: Resting, touching: Touching, exactly: Mask, target: Array, time: float) -> bool:
    """Moves bodies as little as opens gaps by `target` (c,) [m], some exactly; whether that is possible."""
    scene, members = rest.scene, touching.members
    shift, turn = np.zeros_like(scene.x), np.zeros_like(scene.x)
    certificate = np.zeros(touching.count, dtype=np.bool_)
    parts = (scene.bodies, touching.contacts, touching.count, exactly, target, scene.R)
    if displacements(*parts, shift, turn, certificate) != SOLVED or not _move(rest, members, shift, turn, time):
        return False
    work = (rest.force[members] * shift[members]).sum() + (rest.torque[members] * turn[members]).sum()
    rest.record.shift_work += float(work)
    return True


def _move(rest: Resting, members: Rows, shift: Array, turn: Array, time: float) -> bool:
    """Moves bodies by shift [m] and turn [rad] (n,3), unless that would bring any of their pairs together."""
    scene, pairs = rest.scene, rest.queue.pairs
    x, R = scene.x[members].copy(), scene.R[members].copy()
    moves = np.zeros(len(scene.x), dtype=np.bool_)
    moves[members] = True
    rows = np.flatnonzero((moves[pairs.bodies] & (pairs.bodies >= 0)).any(axis=1))
    others = np.setdiff1d(pairs.bodies[rows], members)
    fly_rows(others, scene.flights, scene.bodies, time, *rest.state)
    before = _gaps(rest, rows)
    move(scene.bodies, members, 1.0, shift, turn, rest.state)
    possible = bool((_gaps(rest, rows) >= np.minimum(LEAST * DELTA * pairs.tolerance[rows], before)).all())
    if not possible:
        scene.x[members], scene.R[members] = x, R
        nothing = np.zeros((len(members), 3)), np.zeros((len(members), 3))
        correct(scene.bodies, members, nothing, rest.state)
    return possible


def _gaps(rest: Resting, rows: Rows) -> Array:
    """The gaps (p,) of pairs [m] where they are below delta; at least delta elsewhere."""
    scene, pairs, gap = rest.scene, rest.queue.pairs, np.empty(len(rows))
    parts = (scene.solids, pairs.bodies[rows], scene.x, scene.R, DELTA * pairs.tolerance[rows], pairs.witness[rows])
    gaps_of_pairs(*parts, gap, rest.queue.patch_work)
    return gap
