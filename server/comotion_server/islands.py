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

import numpy as np
from numpy.typing import NDArray

from comotion_server.island import Island
from comotion_server.island_flight import fly, fly_again
from comotion_server.judging import judge, touching_among
from comotion_server.kernels.event_cluster import gather_about
from comotion_server.kernels.event_queue import set_timer, take_off
from comotion_server.kernels.event_scene import BODIES, LEFT, Queue, Rules, Scene
from comotion_server.kernels.flight import fly_rows
from comotion_server.kernels.held_flight import correct
from comotion_server.resting import Resting
from comotion_server.settling import bounce, close, come_off, put_back
from comotion_server.time_stepping import step, stride
from comotion_server.touching import Pair, RestRecord, Touching

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

STRIDES = 5  # of time-stepping in a step; its error is of first order
MOST_PASSES = 600  # of a body in a step, by flights; more: its island goes on by time-stepping
LARGE = 10  # bodies: islands of more may take fewer, so that the product stays
MOST_AT_ONCE = 20  # rests of a body at one time, likewise
PASSES = 50  # of impacts and closings in a rest; in the second half of them all is taken with e = 0
RESPONSES = 100  # of the step's budget that a stride of time-stepping counts as


class Islands:
    """The islands of a world."""

    def __init__(self, scene: Scene, queue: Queue, rules: Rules) -> None:
        self.resting = Resting(scene, queue, rules)
        self.all: list[Island] = []
        count = len(scene.x)
        self._stepping = np.zeros(count, dtype=np.bool_)  # whose island has used up its work of the step
        self._work_done = np.zeros(count, dtype=np.int64)  # passes of the step, times the bodies that took part
        self._at_once = np.zeros(count, dtype=np.int64)  # how often bodies were asked to rest at the last time
        self._last = np.full(count, -1.0)  # which is this [s]
        self._stride = np.inf  # of time-stepping [s]

    # a step

    def begin(self) -> None:
        """All bodies have begun the free flights of a step at local time 0."""
        changed = self.resting.take_forces()
        self.resting.record = RestRecord()
        self._stepping[:], self._work_done[:], self._last[:] = False, 0, -1.0
        for island in self.all:
            island.begin = 0.0
            island.asleep = island.asleep and not changed[island.members].any() and self.resting.others_stand(island)
            if island.asleep:
                self._stand_still(island, 0.0)

    def take_up(self, time: float, until: float) -> bool:
        """All islands go on from a local time, to `until` [s] at most: whether motion is possible, as in `rest`."""
        self._stride = (until - time) / STRIDES
        for island in list(self.all):
            stays = island.asleep and self.resting.others_stand(island)
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
        touching = self._gather(seeds, time, 0.0)
        if self._is_spent(touching.members, time):
            return self._stride_off(touching.members, time, until)
        found = judge(self.resting, touching, time, plastic=False)
        for turn in range(PASSES):
            self._work_done[touching.members] += max(len(touching.members), LARGE)
            if found.hard.any():
                possible = bounce(self.resting, touching, found)
            elif found.closing.any() or found.stick.any():
                possible = close(self.resting, touching, found, time)
            else:
                break
            if not possible:
                return False
            found = judge(self.resting, touching, time, plastic=turn >= PASSES // 2)
        held = touching.of(found.inside)
        put_back(self.resting, touching, found, time)
        return self._take_off(held, found.force[found.inside], time, until)

    def _is_spent(self, members: Rows, time: float) -> bool:
        """Notes a rest of these bodies; whether they have done too much to go on by flights in this step."""
        again = self._last[members] == time
        self._at_once[members] = np.where(again, self._at_once[members] + 1, 0)
        self._last[members] = time
        often = (self._work_done[members] > MOST_PASSES * LARGE) | (self._at_once[members] > MOST_AT_ONCE)
        self._stepping[members] |= bool(often.any())
        return bool(self._stepping[members].any())

    def joined_to(self, bodies: Rows) -> Rows:
        """These bodies and all that are in islands with them."""
        return np.unique(np.concatenate([bodies, *(island.members for island in self._of(bodies))]))

    def leave(self, bodies: Rows, time: float) -> None:
        """Islands of these bodies end; their bodies are on free flights from `time` [s] on."""
        for island in self._of(bodies):
            self._land(island, time)
            self._look_ahead(island.members, time)
        fly_rows(bodies, self.resting.scene.flights, self.resting.scene.bodies, time, *self.resting.state)

    def checkpoint(self) -> tuple[list[Island], Array, Array]:
        """What a step hands on to the next."""
        return [replace(island) for island in self.all], *self.resting.free

    def restore(self, kept: tuple[list[Island], Array, Array]) -> None:
        """Goes back to a checkpoint, which stays usable."""
        islands, self.resting.force, self.resting.torque = kept
        self.all = [replace(island) for island in islands]

    # where bodies are, and which touch

    def _of(self, bodies: Rows) -> list[Island]:
        """The islands that any of these bodies is in."""
        marked = np.zeros(len(self._stepping), dtype=np.bool_)
        marked[bodies] = True
        return [island for island in self.all if marked[island.members].any()]

    def _complete(self, island: Island, time: float) -> None:
        """The bodies of an island, flown to `time`, get the velocities they should have there; impulses are booked."""
        resting = self.resting
        if island.course is None and not island.asleep:
            resting.record.fallback += (time - island.begin) * len(island.members)
        if not island.asleep:
            correct(resting.scene.bodies, island.members, island.gains(time), resting.state)
        resting.record.add_held(island.contacts.bodies, island.impulses(time))
        island.begin, island.change = time, None

    def _land(self, island: Island, time: float) -> None:
        """An island ends: its bodies are where they are at `time`, on free flights from there."""
        self.all.remove(island)
        resting, scene = self.resting, self.resting.scene
        resting.queue.held[island.members] = False
        set_timer(resting.queue, island.members[0], np.inf)
        if island.begin < time or island.change is not None:
            fly_rows(island.members, scene.flights, scene.bodies, time, *resting.state)
            if time < island.end and island.course is not None and not island.asleep:
                fly_again(resting, island, time)
            self._complete(island, time)
        resting.begin(island.members, resting.acceleration, resting.torque, time)

    def _gather(self, seeds: Rows, time: float, ahead: float) -> Touching:
        """The contacts of `seeds` and all that they touch, or may within `ahead` [s]; islands that are met landed."""
        known: set[Pair] = set()
        met = self._of(seeds)
        queue = self.resting.queue
        while True:
            for island in met:
                self._land(island, time)
                known.update(map(tuple, island.contacts.bodies.tolist()))
                seeds = np.union1d(seeds, island.members)
            gather_about(queue, self.resting.scene, seeds, time, ahead)
            bodies = queue.cluster.bodies[: queue.cluster.size[BODIES]]
            met = self._of(bodies)
            if not met:
                break
        return touching_among(self.resting, np.sort(bodies), known, ahead)

    # the next flights

    def _take_off(self, held: Touching, force: Array, time: float, until: float) -> bool:
        """New flights for all: islands where contacts are loaded, free bodies elsewhere; whether that is possible."""
        resting, members = self.resting, held.members
        of_body = _parts(held.contacts.bodies, members)
        loaded = {of_body[i] for i in held.contacts.bodies[force > 0.0].ravel().tolist() if i in of_body}
        free = np.array([i for i in members.tolist() if of_body[i] not in loaded], dtype=np.int64)
        resting.begin(free, resting.acceleration, resting.torque, time)
        for part in sorted(loaded):
            rows = np.array([i for i in members.tolist() if of_body[i] == part])
            contacts = held.of(np.asarray(np.isin(held.contacts.bodies, rows).any(axis=1)))
            contacts.members = rows
            island = None if contacts.friction.any() else fly(resting, contacts, time, until)
            if island is None:
                island = step(resting, contacts, time, min(until - time, self._stride))
            if island is None:
                return False
            self._add(island, until)
        self._look_ahead(members, time)
        return True

    def _stride_off(self, seeds: Rows, time: float, until: float) -> bool:
        """These go on by time-stepping, and all that they may come into contact with; whether that is possible."""
        resting, h = self.resting, min(until - time, self._stride)
        found = self._gather(seeds, time, h)
        found = found.of(found.near | ~found.elastic)
        come_off(resting, found, time)
        resting.queue.tally[LEFT] -= RESPONSES
        island = stride(resting, found, time, h)
        if island is None:
            return False
        self._stepping[found.members] = True
        self._add(island, until)
        self._look_ahead(found.members, time)
        return True

    def _add(self, island: Island, until: float) -> None:
        """A new island, whose bodies are on its flights; or asleep."""
        resting, rows = self.resting, island.members
        self.all.append(island)
        resting.queue.held[rows] = True
        if island.asleep:
            for array in (resting.scene.v, resting.scene.L, resting.scene.w):
                array[rows] = 0.0
            self._stand_still(island, island.begin)
        elif island.end < until:
            set_timer(resting.queue, rows[0], island.end)

    def _look_ahead(self, members: Rows, time: float) -> None:
        """The queue asks anew whom these bodies hit, as they are on new flights."""
        for i in members:
            take_off(self.resting.queue, self.resting.scene, i, time)

    def _stand_still(self, island: Island, time: float) -> None:
        """The bodies of a sleeping island stay where they are, held by the same forces."""
        nothing = np.zeros_like(self.resting.force)
        self.resting.begin(island.members, nothing, nothing, time)
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
