"""How bodies come to rest on each other, stay, turn and slide, and part (docs/rest.md).

Islands live from one sub-step to the next. At the end of each, or when something hits one, its bodies are landed, the
contacts are found afresh from the geometry, and

  (1) contacts that close are answered: with e = 0 where the bounce would be no higher than `delta`, else as an impact;
  (2) contacts that are pressed together and open no faster than such a bounce are closed;
  (3) contacts that have come off the middle of `delta` are put back there, which takes no momentum;
  (4) the bodies take off on a flight under the contact forces, as far as that flight is true (`held_flight`).

An island whose bodies all stand still sleeps: nothing is done until a force on it changes or somebody comes.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from comotion_server.island import Island
from comotion_server.kernels.contact_manifold import gap_of_pair
from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.event_answer import answer, contacts_of
from comotion_server.kernels.event_cluster import gather_about
from comotion_server.kernels.event_queue import set_timer, take_off
from comotion_server.kernels.event_scene import BODIES, CONTACTS, DELTA, PAIRS, Queue, Rules, Scene
from comotion_server.kernels.flight import fly_rows
from comotion_server.kernels.held_contacts import (
    begin_rows,
    contacts_of_pairs,
    eases,
    kinetic_energy,
    move,
    opening_speeds,
)
from comotion_server.kernels.held_flight import STAGES, Course, correct, evaluate, new_course, straying, try_flight
from comotion_server.kernels.impact_cluster import (
    BLOCKED,
    SOLVED,
    TOGETHER,
    collide,
    displacements,
    new_report,
    settle_velocities,
)
from comotion_server.touching import ROUNDING, Judgement, Pair, RestRecord, SoftImpact, Touching, meetings_of

if TYPE_CHECKING:
    from comotion_server.meetings import Meeting

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]

TURN = 0.02  # [rad] per sub-step at most; larger: contact forces are less well known on the way
STRAY = 0.125  # of delta: how far a flight may stray from its contacts on the way; above 0.4 they touch
BAND = 0.25  # of delta: how far a held gap may be off its middle before it is put back; above 0.4 it touches or opens
KEEP = 0.1  # of delta: the gap that all others keep when some are put back; below, they touch
LEAST = 0.05  # of delta: nothing is put back where it would bring bodies closer than this
SLIGHT = 1e-6  # of the speed of a hop as high as delta: slower closing or opening of a pressed contact changes nothing
ATTEMPTS = 60  # to find the length of a sub-step before it is taken as it is
SHORTEST = 1e-6  # of the first length tried: what has no motion for so long is blocked
LOCATED = 1e-7  # of the first length tried: how well is found where a contact parts or slides off
SLID = 1e-9  # of a body's size: how far beyond its face a point may be where it is found to have slid off
PARTED = 1e-3  # of the speed of a hop as high as delta: how fast a contact may open where it is found to have parted
STEADY = 1e-12  # of the free acceleration: what is left of less counts as none
STILL = 1e-9  # of the speed of a hop as high as delta: slower bodies stand still
EXCURSION = 4.0  # deltas: a contact that came back from no farther off does not bounce again
STRIDES = 5  # of time-stepping in a step; its error is of first order
MOST_RESTS = 300  # of a body in a step, by flights; more: its island goes on by time-stepping
MOST_AT_ONCE = 20  # of a body at one time, likewise
PASSES = 50  # of impacts and closings at one time; in the second half of them all is taken with e = 0


class Islands:
    """The islands of a world."""

    def __init__(self, scene: Scene, queue: Queue, rules: Rules) -> None:
        self.scene, self.queue, self.rules = scene, queue, rules
        count = len(scene.x)
        self.all: list[Island] = []
        self.record = RestRecord()
        self.blocked: list[Meeting] = []  # contacts that exclude each other, approaching by motion that is given
        self._trial = tuple(array.copy() for array in self.state)
        self._room = np.zeros((count, 3)), np.zeros((count, 3))
        self._acceleration, self._torque, self._force = (np.zeros((count, 3)) for _ in range(3))
        self._stepping = np.zeros(count, dtype=np.bool_)  # whose island has used up its work of the step
        self._work_done = np.zeros(count, dtype=np.int64)  # how often bodies were asked to rest in the step
        self._at_once = np.zeros(count, dtype=np.int64)  # and of these, at the last time
        self._last = np.full(count, -1.0)  # which is this [s]
        self._stride = np.inf  # of time-stepping [s]
        self._work = queue.patch_work

    @property
    def state(self) -> tuple[Array, ...]:
        """In the order of kernels: x, v, R, L, w."""
        scene = self.scene
        return scene.x, scene.v, scene.R, scene.L, scene.w

    # a step

    def begin(self) -> None:
        """All bodies have begun the free flights of a step at local time 0."""
        flights, ease = self.scene.flights, self.scene.bodies.inverse_mass
        force = np.divide(flights.acceleration, ease, out=np.zeros_like(ease), where=ease > 0.0)
        changed = (force != self._force).any(axis=1) | (flights.torque != self._torque).any(axis=1)
        self._force, self._torque, self._acceleration = force, flights.torque.copy(), flights.acceleration.copy()
        self.record = RestRecord()
        self._stepping[:], self._work_done[:], self._last[:] = False, 0, -1.0
        for island in self.all:
            island.begin = 0.0
            island.asleep = island.asleep and not changed[island.members].any() and self._others_stand(island)
            if island.asleep:
                self._stand_still(island, 0.0)

    def take_up(self, time: float, until: float) -> bool:
        """All islands go on from a local time, to `until` [s] at most: whether motion is possible, as in `rest`."""
        self._stride = (until - time) / STRIDES
        for island in list(self.all):
            stays = island.asleep and self._others_stand(island)
            if island in self.all and not stays and not self.rest(island.members, time, until):
                return False
        return True

    def end(self, time: float) -> None:
        """All bodies have flown to the end of the step: what the islands' velocities lack is added."""
        for island in self.all:
            self._complete(island, time)

    def rest(self, seeds: Rows, time: float, until: float) -> bool:
        """Lets `seeds` and all they touch at a local time come to rest on each other, or part.

        No flight goes beyond `until` [s]. False where no motion satisfies the contacts of `blocked`: all these bodies
        are then on free flights.
        """
        touching = self._gather(seeds, time)
        plastic = self._is_spent(touching.members, time)
        found = self._judge(touching, time, plastic=plastic)
        for turn in range(PASSES):
            if found.hard.any():
                possible = self._bounce(touching, found)
            elif found.closing.any() or found.stick.any():
                possible = self._close(touching, found, time)
            else:
                break
            if not possible:
                return False
            found = self._judge(touching, time, plastic=plastic or turn >= PASSES // 2)
        held = touching.of(found.inside)
        self._put_back(touching, found, time)
        return self._take_off(held, found.force[found.inside], time, until)

    def _is_spent(self, members: Rows, time: float) -> bool:
        """Counts a rest of these bodies; whether they have come to rest too often to go on by flights in this step."""
        again = self._last[members] == time
        self._work_done[members] += 1
        self._at_once[members] = np.where(again, self._at_once[members] + 1, 0)
        self._last[members] = time
        often = (self._work_done[members] > MOST_RESTS) | (self._at_once[members] > MOST_AT_ONCE)
        self._stepping[members] |= bool(often.any())
        return bool(self._stepping[members].any())

    def leave(self, bodies: Rows, time: float) -> None:
        """Islands of these bodies end; their bodies are on free flights from `time` [s] on."""
        for island in [island for island in self.all if np.isin(island.members, bodies).any()]:
            self._land(island, time)
            for i in island.members:
                take_off(self.queue, self.scene, i, time)
        fly_rows(bodies, self.scene.flights, self.scene.bodies, time, *self.state)

    def checkpoint(self) -> tuple[list[Island], Array, Array]:
        """What a step hands on to the next."""
        return [replace(island) for island in self.all], self._force, self._torque

    def restore(self, kept: tuple[list[Island], Array, Array]) -> None:
        """Goes back to a checkpoint, which stays usable."""
        islands, self._force, self._torque = kept
        self.all = [replace(island) for island in islands]

    # where bodies are, and which touch

    def _complete(self, island: Island, time: float) -> None:
        """The bodies of an island, flown to `time`, get the velocities they should have there; impulses are booked."""
        if island.course is None and not island.asleep:
            self.record.fallback += (time - island.begin) * len(island.members)
        if not island.asleep:
            correct(self.scene.bodies, island.members, island.gains(time), self.state)
        self.record.add_held(island.contacts.bodies, island.impulses(time))
        island.begin = time

    def _land(self, island: Island, time: float) -> None:
        """An island ends: its bodies are where they are at `time`, on free flights from there."""
        self.all.remove(island)
        self.queue.held[island.members] = False
        set_timer(self.queue, island.members[0], np.inf)
        if island.begin < time:
            fly_rows(island.members, self.scene.flights, self.scene.bodies, time, *self.state)
            if time < island.end and island.course is not None and not island.asleep:
                self._cut_short(island, time)
            self._complete(island, time)
        self._begin(island.members, self._acceleration, self._torque, time)

    def _cut_short(self, island: Island, time: float) -> None:
        """A sub-step that ends early is taken again with the length it has: its velocities are of fourth order then.

        Bodies stay where the flight has brought them, as others have met them there.
        """
        scene, members = self.scene, island.members
        x, R = scene.x[members].copy(), scene.R[members].copy()
        fly_rows(island.touched, scene.flights, scene.bodies, island.begin, *self.state)
        course, contacts = new_course(len(members), len(island.push)), island.contacts
        status = try_flight(
            scene.solids, scene.flights, scene.bodies, Contacts(*(column.copy() for column in contacts)),
            len(island.push), members, island.touched, (self._force, self._torque), island.begin, time - island.begin,
            self.state, self._trial, course, np.zeros(len(island.push), dtype=np.bool_), self._room,
        )  # fmt: skip
        if status == SOLVED:
            island.course, island.end = course, time
        fly_rows(island.touched, scene.flights, scene.bodies, time, *self.state)
        scene.x[members], scene.R[members] = x, R

    def _begin(self, rows: Rows, acceleration: Array, torque: Array, time: float) -> None:
        begin_rows(self.scene.flights, self.scene.bodies, rows, acceleration, torque, time, self.state)

    def _gather(self, seeds: Rows, time: float) -> Touching:
        """The contacts of `seeds` and all that they touch, islands that are met landed."""
        known: set[Pair] = set()
        met = [island for island in self.all if np.isin(island.members, seeds).any()]
        cluster = self.queue.cluster
        while True:
            for island in met:
                self._land(island, time)
                known.update(map(tuple, island.contacts.bodies.tolist()))
                seeds = np.union1d(seeds, island.members)
            gather_about(self.queue, self.scene, seeds, time)
            bodies = cluster.bodies[: cluster.size[BODIES]]
            met = [island for island in self.all if np.isin(island.members, bodies).any()]
            if not met:
                break
        return self._touching(np.sort(bodies), known)

    def _touching(self, bodies: Rows, known: set[Pair]) -> Touching:
        """All points within delta of the cluster that was gathered."""
        queue, scene, rules = self.queue, self.scene, self.rules
        cluster, pairs = queue.cluster, queue.pairs
        rows = cluster.pairs[: cluster.size[PAIRS]].copy()
        reach = DELTA * pairs.tolerance[rows]
        of, contacts = np.empty(len(cluster.pair), dtype=np.int64), cluster.contacts
        parts = (scene.solids, pairs.bodies[rows], scene.x, scene.R, reach, 0.0, reach)
        count = contacts_of_pairs(*parts, contacts, of, self._work)
        of = of[:count]
        a, b = (rules.material[contacts.bodies[:count, side]] for side in (0, 1))
        return Touching(
            bodies[scene.bodies.reacts[bodies]],
            Contacts(*(column[:count].copy() for column in contacts)),
            rows[of],
            reach[of],
            rules.restitution[a, b] == 1.0,
            rules.friction[a, b],
            np.array([(i, j) in known for i, j in contacts.bodies[:count].tolist()], dtype=np.bool_),
        )

    # what becomes of the contacts

    def _judge(self, touching: Touching, time: float, *, plastic: bool) -> Judgement:
        """Which contacts close, stay and part at the present velocities; where all is `plastic`, none bounces."""
        queue, count = self.queue, touching.count
        speed, scale, ease = np.empty(count), np.empty(count), np.empty(count)
        opening_speeds(self.scene.solids, touching.contacts, count, self.state, speed, scale)
        eases(self.scene.bodies, touching.contacts, count, self.scene.R, ease)
        none = ROUNDING * scale
        resting = ~touching.elastic | touching.known
        inside, force, pressing = np.ones(count, dtype=np.bool_), np.zeros(count), np.zeros(count)
        while inside.any():
            force[:] = 0.0
            force[inside] = self._forces(touching.of(inside))
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

    def _forces(self, touching: Touching) -> Array:
        """What would hold each contact (c,) [N]."""
        course, count = new_course(len(touching.members), touching.count), touching.count
        self._evaluate(touching.copy(), count, touching.members, course)
        force: Array = course.force[0]
        return force

    def _evaluate(self, contacts: Contacts, count: int, members: Rows, course: Course) -> int:
        scene, certificate = self.scene, np.zeros(count, dtype=np.bool_)
        free = self._force, self._torque
        return int(
            evaluate(
                scene.solids, scene.flights, scene.bodies, contacts, count, members, free, self.state, course, 0,
                certificate, self._room,
            )
        )  # fmt: skip

    def _bounce(self, touching: Touching, found: Judgement) -> bool:
        """An impact of the whole cluster; pairs whose contacts close softly take it with e = 0."""
        queue, scene = self.queue, self.scene
        cluster = queue.cluster
        contacts_of(queue, scene, self.rules)
        soft = np.setdiff1d(touching.pair[found.closing], touching.pair[found.hard])
        count = cluster.size[CONTACTS]
        cluster.restitution[:count][np.isin(cluster.pair[:count], soft)] = 0.0
        status = answer(queue, scene, self.rules)
        return self._possible(status, cluster.contacts, cluster.report.certificate[:count])

    def _possible(self, status: int, contacts: Contacts, certificate: Mask) -> bool:
        """Whether there is a motion; otherwise the contacts that exclude each other are noted."""
        if status == BLOCKED:
            given = ~self.scene.bodies.reacts
            self.blocked = meetings_of(self.scene, contacts, np.flatnonzero(certificate), given)
        return status != BLOCKED

    def _close(self, touching: Touching, found: Judgement, time: float) -> bool:
        """Contacts that close, stop, whatever others do then; where none closes, those that stick are closed."""
        scene, pairs, count = self.scene, self.queue.pairs, touching.count
        impulse, certificate = np.zeros(count), np.zeros(count, dtype=np.bool_)
        motion = scene.v, scene.R, scene.L, scene.w
        before = kinetic_energy(scene.bodies, touching.members, scene.v, scene.L, scene.w)
        exactly = found.inside & (found.force > 0.0) & (not found.closing.any())
        status = BLOCKED
        for equal in (exactly, np.zeros_like(exactly)):  # what cannot be closed exactly is no pinch
            parts = (scene.bodies, touching.contacts, count, equal, np.zeros(count))
            if status == BLOCKED:
                status = settle_velocities(*parts, *motion, impulse, certificate)
        if not self._possible(status, touching.contacts, certificate):
            return False
        after = kinetic_energy(scene.bodies, touching.members, scene.v, scene.L, scene.w)
        contacts, pushed = touching.contacts, np.flatnonzero(impulse)
        given = meetings_of(scene, contacts, pushed, ~scene.bodies.reacts)
        work = sum(impulse[i] * meeting.approach for i, meeting in zip(pushed, given, strict=True))
        self.record.rest_energy += before - after + float(work)
        self.record.add_held(contacts.bodies, impulse[:, None] * contacts.normal)
        rows = touching.pair[found.closing]
        pairs.hit_time[rows], pairs.hit_speed[rows] = time, 0.0
        for i in np.flatnonzero(found.closing & ~touching.known & (impulse > 0.0)):
            a, b = contacts.bodies[i].tolist()
            point = scene.x[b] + contacts.arm_b[i]
            soft = SoftImpact(time, (a, b), point, contacts.normal[i].copy(), float(impulse[i]), -float(found.speed[i]))
            self.record.soft.append(soft)
        return True

    def _put_back(self, touching: Touching, found: Judgement, time: float) -> None:
        """Moves bodies so that loaded contacts are in the middle of delta; all others keep a gap.

        Where not all of them can be there at once, those that are too near at least come off as far.
        """
        delta, gap = touching.delta, touching.contacts.gap
        off, loaded = gap - 0.5 * delta, found.inside & (found.force > 0.0)
        near = found.inside & (off < -BAND * delta)
        if not (near | (loaded & (off > BAND * delta))).any():
            return
        keeps = np.minimum(KEEP * delta - gap, 0.0)
        if not self._shift(touching, loaded, np.where(loaded, -off, keeps), time):
            self._shift(touching, np.zeros_like(loaded), np.where(near, -off, keeps), time)

    def _shift(self, touching: Touching, exactly: Mask, target: Array, time: float) -> bool:
        """Moves bodies as little as opens gaps by `target` (c,) [m], some exactly; whether that is possible."""
        scene, members = self.scene, touching.members
        shift, turn = np.zeros_like(scene.x), np.zeros_like(scene.x)
        certificate = np.zeros(touching.count, dtype=np.bool_)
        parts = (scene.bodies, touching.contacts, touching.count, exactly, target, scene.R)
        if displacements(*parts, shift, turn, certificate) != SOLVED or not self._move(members, shift, turn, time):
            return False
        work = (self._force[members] * shift[members]).sum() + (self._torque[members] * turn[members]).sum()
        self.record.shift_work += float(work)
        return True

    def _move(self, members: Rows, shift: Array, turn: Array, time: float) -> bool:
        """Moves bodies by shift [m] and turn [rad] (n,3), unless that would bring any of their pairs together."""
        scene, pairs = self.scene, self.queue.pairs
        x, R = scene.x[members].copy(), scene.R[members].copy()
        concerned = np.flatnonzero(np.isin(pairs.bodies, members).any(axis=1))
        others = np.setdiff1d(pairs.bodies[concerned], members)
        fly_rows(others, scene.flights, scene.bodies, time, *self.state)
        gaps = {k: self._gap_of_row(k) for k in concerned.tolist()}
        move(scene.bodies, members, 1.0, shift, turn, self.state)
        for k, before in gaps.items():
            if self._gap_of_row(k) < min(LEAST * DELTA * float(pairs.tolerance[k]), before):
                scene.x[members], scene.R[members] = x, R
                nothing = np.zeros((len(members), 3)), np.zeros((len(members), 3))
                correct(scene.bodies, members, nothing, self.state)
                return False
        return True

    def _gap_of_row(self, k: int) -> float:
        """The gap of pair k [m] where it is below delta; at least delta elsewhere."""
        pairs, (a, b) = self.queue.pairs, self.queue.pairs.bodies[k].tolist()
        return self._gap(a, b, DELTA * float(pairs.tolerance[k]), pairs.witness[k])

    def _gap(self, a: int, b: int, limit: float, witness: Rows) -> float:
        """The gap of two bodies [m] where it is below `limit`."""
        scene = self.scene
        return float(gap_of_pair(scene.solids, a, b, scene.x, scene.R, limit, witness.copy(), self._work))

    # the next flights

    def _take_off(self, held: Touching, force: Array, time: float, until: float) -> bool:
        """New flights for all: islands where contacts are loaded, free bodies elsewhere; whether that is possible."""
        members = held.members
        of_body = _parts(held.contacts.bodies, members)
        loaded = {of_body[i] for i in held.contacts.bodies[force > 0.0].ravel().tolist() if i in of_body}
        free = np.array([i for i in members.tolist() if of_body[i] not in loaded], dtype=np.int64)
        self._begin(free, self._acceleration, self._torque, time)
        for part in sorted(loaded):
            rows = np.array([i for i in members.tolist() if of_body[i] == part])
            contacts = held.of(np.asarray(np.isin(held.contacts.bodies, rows).any(axis=1)))
            contacts.members = rows
            steps = contacts.friction.any() or self._stepping[rows].any()
            if (steps or not self._fly(contacts, time, until)) and not self._step(contacts, time, until):
                return False
        for i in members:
            take_off(self.queue, self.scene, i, time)
        return True

    def _fly(self, touching: Touching, time: float, until: float) -> bool:
        """One island takes off on a flight as long as it is true; whether that is possible."""
        scene, count, members = self.scene, touching.count, touching.members
        bodies = touching.bodies
        spin = float(np.linalg.norm(scene.w[bodies], axis=1).max())
        h = first = min(until - time, TURN / spin) if spin > 0.0 else until - time
        free, certificate = (self._force, self._torque), np.zeros(count, dtype=np.bool_)
        low, high = 0.0, np.inf  # until the first no contact parts, until the second one does
        for _ in range(ATTEMPTS):
            course, contacts = new_course(len(members), count), touching.copy()
            status = try_flight(
                scene.solids, scene.flights, scene.bodies, contacts, count, members, bodies, free, time, h,
                self.state, self._trial, course, certificate, self._room,
            )  # fmt: skip
            if status == BLOCKED and h > SHORTEST * first:  # on the way, where contacts have gone past each other
                h *= 0.25
                continue
            if not self._possible(status, contacts, certificate):
                self._begin(members, self._acceleration, self._torque, time)
                return False
            stray = straying(scene.bodies, contacts, count, members, course, h, scene.R)
            limit = STRAY * float(touching.delta.min())
            if stray > limit:
                h *= max(0.1, 0.9 * (limit / stray) ** (1.0 / 3.0))
                continue
            parts, guess = self._parting(touching, course, h)
            if parts:
                high = h
            else:
                low = h
            if parts == (high - low <= LOCATED * first) or high == np.inf:
                break
            h = (
                high
                if high - low <= LOCATED * first
                else min(max(guess, 0.95 * low + 0.05 * high), 0.05 * low + 0.95 * high)
            )
        push = course.force[0][:, None] * course.normal[0]
        island = Island(members, bodies, touching.contacts, course, time, time + h, push)
        self._add(island, until, asleep=self._is_still(island, course, touching))
        return True

    def _add(self, island: Island, until: float, *, asleep: bool) -> None:
        """A new island, whose bodies are on its flights; or asleep."""
        self.all.append(island)
        self.queue.held[island.members] = True
        if asleep:
            island.asleep = True
            for array in (self.scene.v, self.scene.L, self.scene.w):
                array[island.members] = 0.0
            self._stand_still(island, island.begin)
        elif island.end < until:
            set_timer(self.queue, island.members[0], island.end)

    def _step(self, touching: Touching, time: float, until: float) -> bool:
        """One island takes a step of first order at constant velocities: forces first, then contacts with e = 0.

        (Moreau 1988; Jean 1999.) With friction, and where the work of a step is used up.
        """
        scene, members, count = self.scene, touching.members, touching.count
        h = min(until - time, self._stride)
        ease = scene.bodies.inverse_mass[members]
        before = tuple(array[members].copy() for array in (scene.v, scene.L, scene.w))
        scene.v[members] += h * ease * self._force[members]
        scene.L[members] += h * self._torque[members]
        correct(scene.bodies, members, (np.zeros((len(members), 3)), np.zeros((len(members), 3))), self.state)
        impulse, report = np.zeros((count, 3)), new_report(count)
        parts = (scene.bodies, touching.contacts, count, np.zeros(count), touching.friction, TOGETHER)
        status = collide(*parts, scene.v, scene.R, scene.L, scene.w, impulse, report)
        if not self._possible(status, touching.contacts, report.certificate[:count]):
            for array, values in zip((scene.v, scene.L, scene.w), before, strict=True):
                array[members] = values
            return False
        nothing = np.zeros_like(self._force)
        self._begin(members, nothing, nothing, time)
        island = Island(members, touching.bodies, touching.contacts, None, time, time + h, impulse / h)
        turning = scene.solids.radius[members] * np.linalg.norm(scene.w[members], axis=1)
        speed = np.linalg.norm(scene.v[members], axis=1) + turning
        pull = float(np.linalg.norm(self._acceleration[members], axis=1).max())
        slow = STILL * np.sqrt(2.0 * pull * float(touching.delta.min()))
        self._add(island, until, asleep=bool((speed <= slow).all()) and self._others_stand(island))
        return True

    def _parting(self, touching: Touching, course: Course, h: float) -> tuple[bool, float]:
        """Whether a contact has parted or slid off by the end of a sub-step `h` [s], and about when [s]."""
        last, half = STAGES - 1, 1
        slack = SLID * 2.0 * self.scene.solids.radius[touching.contacts.bodies].min(axis=1)
        loaded, guesses = course.force[0] > 0.0, [0.5 * h]
        slides = loaded & (course.margin[0] > 0.0) & (course.margin[last] < -slack)
        if slides.any():
            m1, m2 = (course.margin[stage][slides] + 0.5 * slack[slides] for stage in (half, last))
            fall = np.where(m1 > m2, m1 - m2, np.inf)
            guesses.append(float((0.5 * h * (1.0 + m1 / fall)).min()))
        pull = float(np.linalg.norm(self._acceleration[touching.members], axis=1).max())
        parts = loaded & (course.force[last] == 0.0)
        parts &= course.speed[last] > PARTED * np.sqrt(2.0 * pull * touching.delta)
        if parts.any():
            f0, f1 = course.force[0][parts], course.force[half][parts]
            fall = np.where((f1 > 0.0) & (f1 < f0), f0 - f1, np.inf)
            guesses.append(float((0.5 * h * f0 / fall).min()))
        guess = min(guesses[1:], default=guesses[0])
        return bool(slides.any() or parts.any()), guess

    def _is_still(self, island: Island, course: Course, touching: Touching) -> bool:
        """Whether nothing moves, and no force moves it."""
        scene, rows = self.scene, island.members
        pull = float(np.linalg.norm(self._acceleration[rows], axis=1).max())
        slow = STILL * np.sqrt(2.0 * pull * float(touching.delta.min()))
        turning = scene.solids.radius[rows] * np.linalg.norm(scene.w[rows], axis=1)
        if (np.linalg.norm(scene.v[rows], axis=1) + turning > slow).any() or not self._others_stand(island):
            return False
        lightness = np.maximum(scene.bodies.inverse_mass[rows].max(axis=1), 1e-300)
        weight = pull / lightness * scene.solids.radius[rows]
        acceleration, torque = (np.linalg.norm(k[0], axis=1) for k in (course.acceleration, course.torque))
        return bool((acceleration <= STEADY * pull).all() and (torque <= STEADY * weight).all())

    def _others_stand(self, island: Island) -> bool:
        """Whether what an island stands on does not move."""
        others = np.setdiff1d(island.touched, island.members)
        return not (self.scene.v[others].any() or self.scene.w[others].any())

    def _stand_still(self, island: Island, time: float) -> None:
        """The bodies of a sleeping island stay where they are, held by the same forces."""
        nothing = np.zeros_like(self._acceleration)
        self._begin(island.members, nothing, nothing, time)
        island.begin = time


def _parts(pairs: Rows, members: Rows) -> dict[int, int]:
    """The least body of the part that contacts join each member to."""
    root = {i: i for i in members.tolist()}

    def find(i: int) -> int:
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    for a, b in pairs.tolist():
        if a in root and b in root:
            low, high = sorted((find(a), find(b)))
            root[high] = low
    return {i: find(i) for i in root}
