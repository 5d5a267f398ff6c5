"""Rule `exact`: every contact at its time, answered in clusters, and held where bodies rest (docs/event_queue.md).

The compiled queue of events plays the flights of a world and answers impacts. It comes back here where it needs help:
bodies come to rest on each other (`islands`), no motion satisfies the contacts, or the work of a step is used up.
Between steps it keeps what it knows of pairs.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.exact_scene import queue_of, rules_of, scene_of, solids_of
from comotion_server.impact_records import impacts_of, soft_impacts_of, totals_of
from comotion_server.islands import Islands
from comotion_server.kernels import event_queue as events
from comotion_server.kernels.event_heap import take_out
from comotion_server.kernels.event_scene import CONTACTS, CUT_SHORT, LEFT, ROW, TIMER, Queue
from comotion_server.kernels.flight import begin
from comotion_server.meetings import Meeting
from comotion_server.queue_room import enlarged
from comotion_server.results import Blocked, Books, Budget, CollisionRecord, Contact
from comotion_server.starting_gaps import open_gaps
from comotion_server.touching import meetings_of
from comotion_server.world import World

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

MORE = 100  # hits granted after bodies were frozen
MOST_AT_ONCE = 200  # times of help at one local time; more: it does not help
LASTING = ("heap", "cells", "pairs", "held", "now", "tally")  # of the queue: what a step hands on to the next


class OverlapError(RuntimeError):
    """Two bodies intersect, which rule `exact` never lets happen: they were put so."""

    def __init__(self, body_a: str, body_b: str, time: float) -> None:
        super().__init__(f'bodies "{body_a}" and "{body_b}" intersect at t = {time:.6g} s; expected a gap between them')


class _PinchedError(Exception):
    """Bodies have to change before the step can go on."""


def copied(arrays: Any) -> Any:
    """The same arrays, tuples of them, and so on, as copies."""
    if isinstance(arrays, np.ndarray):
        return arrays.copy()
    return type(arrays)(*(copied(part) for part in arrays))


class ExactQueue:
    """Plays the flights of a world through the contacts of a step."""

    def __init__(self, world: World) -> None:
        self.world, self.settings = world, world.scene.collisions
        self.solids = solids_of([body.collision_shape for body in world.scene.bodies])
        self._rules = self.rules = rules_of(world.scene)
        self.scene = scene_of(world, self.solids)
        queue = queue_of(world, self.solids)
        while not events.start(queue, self.scene):
            queue = enlarged(queue, events.PAIRS_FULL)
        open_gaps(world, self.scene, queue)
        self.islands = Islands(self.scene, queue, self.rules)
        self._elapsed = 0.0
        self._at_once = (-1.0, 0)  # the last time of help, and how often it was asked for then
        self._eased = (-1.0, -1)  # the last time at which a pair stalled, and its row
        self._frozen: list[int] = []
        self._stopped: dict[int, tuple[Array, Array]] = {}
        self._blocked: list[Blocked] = []
        self.joined: list[Meeting] = []  # contacts that make one body of two
        self.pinched: list[Meeting] = []  # contacts that exclude each other
        self.heals = False  # whether `play` stops at such contacts

    @property
    def queue(self) -> Queue:
        """All that the event queue remembers; grows as it needs to."""
        return self.islands.resting.queue

    def begin(self, start_time: float) -> None:
        """Starts a step at `start_time` [s]: all bodies have begun flights at local time 0."""
        self.start_time = start_time
        self._blocked, self.joined, self.pinched = [], [], []
        self.rules = self.islands.resting.rules = self._rules
        self.islands.begin()
        events.begin_step(self.queue, self.scene, self._elapsed)
        self.queue.tally[LEFT] = self._granted = self.settings.budget
        self.queue.tally[CUT_SHORT] = 0
        self._elapsed = 0.0

    def play(self, until: float) -> float:
        """Moves all bodies to the local time `until` [s], from where the last call ended: the time reached.

        It is less where bodies `joined` on the way, or are `pinched`.
        """
        if self._elapsed > 0.0:
            for i in self.world.tables:  # on new flights since
                events.take_off(self.queue, self.scene, i, self._elapsed)
        code = -1
        try:
            while not self.islands.take_up(self._elapsed, until):
                self._block(self._elapsed, self.islands.resting.blocked)
            while code not in {events.DONE, events.MERGES}:
                code = events.play(self.queue, self.scene, self.rules, until)
                self._help(code, until)
        except _PinchedError:
            pass
        reached = until if code == events.DONE else float(self.queue.now[0])
        self._elapsed = reached
        self.world.advance(reached)
        self.islands.end(reached)
        self._thaw()
        if code == events.MERGES:
            self.joined = self._joints()
        return reached

    def _help(self, code: int, until: float) -> None:
        """Does what the compiled queue came back for."""
        queue, now = self.queue, float(self.queue.now[0])
        self._at_once = (now, self._at_once[1] + 1 if now == self._at_once[0] else 0)
        if self._at_once[1] > MOST_AT_ONCE and code in {events.REST, events.ISLAND}:
            code = events.STALLED
        elif code == events.STALLED and self._eased != (now, int(queue.tally[ROW])):
            self._eased = (now, int(queue.tally[ROW]))
            code = events.REST  # once: bodies that hit each other without end rest on each other
        if code in {events.REST, events.ISLAND}:
            seeds = queue.pairs.bodies[queue.tally[ROW]] if code == events.REST else queue.tally[TIMER : TIMER + 1]
            while not self.islands.rest(seeds.copy(), now, until):
                self._block(now, self.islands.resting.blocked)
        elif code == events.BLOCKED:
            cluster = queue.cluster
            rows = np.flatnonzero(cluster.report.certificate[: cluster.size[CONTACTS]])
            self._block(now, meetings_of(self.scene, cluster.contacts, rows, ~self.scene.bodies.reacts))
        elif code == events.SPENT:
            self._spend(now)
        elif code == events.STALLED:
            pair = queue.pairs.bodies[queue.tally[ROW]].copy()
            self._stop(pair, pair[None], now)
            take_out(queue.heap, 2 * len(queue.held) + int(queue.tally[ROW]))  # both stand still to the end of the step
        elif code in {events.LOG_FULL, events.PAIRS_FULL, events.CONTACTS_FULL}:
            self._enlarge(code, now)
        elif code == events.OVERLAPPING:
            a, b = queue.pairs.bodies[queue.tally[ROW]]
            raise OverlapError(self.world.names[a], self.world.names[b], self.start_time + now)

    def _enlarge(self, code: int, now: float) -> None:
        """More room; a body that could not get all its pairs gets them."""
        resting = self.islands.resting
        resting.queue = enlarged(resting.queue, code)
        body = int(self.queue.heap.item[0])
        while code == events.PAIRS_FULL and not events.look_around(self.queue, self.scene, body, now):
            resting.queue = enlarged(resting.queue, code)

    def _joints(self) -> list[Meeting]:
        """The contacts of the cluster that merge, one of each pair of bodies."""
        cluster, bodies = self.queue.cluster, self.scene.bodies
        contacts, first = cluster.contacts, dict[tuple[int, int], int]()
        for i in range(cluster.size[CONTACTS]):
            a, b = contacts.bodies[i].tolist()
            if events.joins(bodies, a, b, cluster.restitution[i]):
                first.setdefault((a, b), i)
        rows = np.array(sorted(first.values()), dtype=np.int64)
        return meetings_of(self.scene, contacts, rows, np.ones(len(bodies.reacts), dtype=np.bool_))

    # what cannot go on

    def _block(self, now: float, excluded: list[Meeting]) -> None:
        """Prescribed bodies that ask for the impossible stay where they are for the rest of the step (P15)."""
        if self.heals:
            self.pinched = excluded
            raise _PinchedError
        scene, pairs = self.scene, np.unique([(meeting.a, meeting.b) for meeting in excluded], axis=0)
        concerned = np.unique(pairs)
        pushing = concerned[~scene.bodies.reacts[concerned] & (scene.v[concerned].any(1) | scene.w[concerned].any(1))]
        self._stop(pushing if len(pushing) else concerned, pairs, now)

    def _stop(self, bodies: Rows, pairs: Rows, now: float) -> None:
        """Bodies stay where they are because of contacts, and the reply says so."""
        names = self.world.names
        contacts = tuple((names[a], names[b]) for a, b in pairs.tolist())
        self._blocked.append(Blocked(self.start_time + now, tuple(names[i] for i in bodies), contacts))
        self._freeze(bodies, now)

    def _spend(self, now: float) -> None:
        """The work of a step is used up: the rest of it is taken with e = 0; then bodies stay where they are."""
        if self.rules.restitution.any():
            self.rules = self.islands.resting.rules = self.rules._replace(
                restitution=np.zeros_like(self.rules.restitution)
            )
            self._grant(self.settings.budget)
            return
        bodies = self.islands.joined_to(self.queue.pairs.bodies[self.queue.tally[ROW]])
        self._freeze(bodies[self.scene.bodies.reacts[bodies]], now)
        self._grant(MORE)

    def _grant(self, left: int) -> None:
        """So much work is allowed from here on."""
        self._granted += left - int(self.queue.tally[LEFT])
        self.queue.tally[LEFT] = left

    def _freeze(self, bodies: Rows, now: float) -> None:
        """Bodies stay where they are for the rest of the step; nothing moves them."""
        scene = self.scene
        self.islands.leave(bodies, now)
        for i in bodies.tolist():
            if scene.bodies.reacts[i]:
                self._frozen.append(i)
                scene.bodies.reacts[i] = False
            else:
                self._stopped.setdefault(i, (scene.v[i].copy(), scene.w[i].copy()))
            for array in (scene.v, scene.L, scene.w, scene.flights.acceleration, scene.flights.torque):
                array[i] = 0.0
            begin(scene.flights, scene.bodies, i, now, scene.x[i], scene.v[i], scene.R[i], scene.L[i], scene.w[i])
            events.take_off(self.queue, scene, i, now)

    def _thaw(self) -> None:
        """Frozen bodies are free again, and those that move as told have their velocities back."""
        self.scene.bodies.reacts[self._frozen] = True
        for i, (v, w) in self._stopped.items():
            self.scene.v[i], self.scene.w[i] = v, w
        self._frozen.clear()
        self._stopped.clear()

    # what is handed on

    def record(self) -> CollisionRecord:
        """What happened since `begin`."""
        queue, rest, names = self.queue, self.islands.resting.record, self.world.names
        impacts = impacts_of(queue.log, self.settings, names, self.start_time)
        impacts += soft_impacts_of(rest.soft, names, self.start_time)
        impacts.sort(key=lambda impact: impact.time)
        momentum, angular_momentum, energy = map(float, queue.log.books)
        books = Books(momentum, angular_momentum, energy, len(impacts))
        books.rest_energy, books.shift_work = rest.rest_energy, rest.shift_work
        used, cut_short = int(self._granted - queue.tally[LEFT]), int(queue.tally[CUT_SHORT])
        moving = max(int(np.count_nonzero(self.scene.bodies.reacts)), 1) * self._elapsed
        budget = Budget(self.settings.budget, used, cut_short, rest.fallback / moving if rest.fallback else 0.0)
        return CollisionRecord(tuple(impacts), self._contacts(), books, budget, tuple(self._blocked))

    def _contacts(self) -> tuple[Contact, ...]:
        """The impulses of each pair over the step, of impacts and of held contacts."""
        held, names = self.islands.resting.record.held, self.world.names
        hit = totals_of(self.queue.log)
        none = np.zeros(3)
        found = []
        for a, b in sorted(hit.keys() | held.keys()):
            impulse, count = hit.get((a, b), (none, 0))
            share = held.get((a, b), none)
            found.append(Contact(names[a], names[b], impulse + share, count, share))
        return tuple(found)

    def checkpoint(self) -> Any:
        """Everything that a step changes."""
        return [copied(getattr(self.queue, name)) for name in LASTING], self.islands.checkpoint(), self._elapsed

    def restore(self, kept: Any) -> None:
        """Goes back to a checkpoint, which stays usable."""
        lasting, islands, self._elapsed = kept
        arrays = dict(zip(LASTING, map(copied, lasting), strict=True))
        self.islands.resting.queue = self.queue._replace(**arrays)
        self.islands.restore(islands)
