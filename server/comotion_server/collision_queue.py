"""The paper's collision queue for general bodies, to the letter (P9, P10, P12 to P14).

At time t, with the rest of the step as the window:
  (1) measure every pair, (2) drop those that cannot collide within the window, (3) sort by time to collision;
  (4) while there is a first pair and its time lies within the window:
      (a) respond to it and to all pairs with the same time, (b) advance *all* bodies by that time / N, (c) go to (1);
  (5) advance all bodies by what remains.
Rule `paper` is this. Rule `paper-advance` reads the same queue the other way: it advances by time / N until the first
gap is within the tolerance, and only then responds, so that bodies touch before they part.

Neither rule can exclude intersections. A pair found intersecting collides at once, with the closest points of the last
sub-step before, and is then left out until other pairs turn up in the queue or the step ends (P14).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.contact_features import ParallelCriteria
from comotion_server.contact_response import Ledger, Touch, respond
from comotion_server.meetings import Meeting
from comotion_server.nesting import INSIDE, nested
from comotion_server.pair_table import Closeness, PairTable
from comotion_server.results import Budget, CollisionRecord, Contact
from comotion_server.scene import Problem, SceneError
from comotion_server.world import World

BLOCKAGE = 2  # intersections of a pair in a row (P15)
MEETING = "touch or overlap at the start; expected a gap between all bodies that can collide"
SAME_TIME = 1e-12  # of the step: collisions closer in time count as simultaneous; rounding of the times is 1e-16 of it


@dataclass(slots=True)
class Queue:
    """The pairs that collide within the window, sorted: indices into the pair table, and times to collision [s]."""

    pairs: NDArray[np.int64]
    seconds: NDArray[np.float64]

    def simultaneous(self, window: float) -> NDArray[np.int64]:
        """The first pair and all with the same time."""
        together: NDArray[np.int64] = self.pairs[self.seconds <= self.seconds[0] + SAME_TIME * window]
        return together


class CollisionQueue:
    """Plays the flights of a world through the collisions of a step."""

    def __init__(self, world: World, before: "CollisionQueue | None" = None) -> None:
        """`before`: the queue of the same bodies, one of which has another scale now; what it remembers holds on."""
        self.world = world
        self.settings = world.scene.collisions
        self.table = PairTable(world)
        self._criteria = ParallelCriteria(self.table, self.settings) if self.settings.parallel == "paper" else None
        self.now = 0.0
        self.joined: list[Meeting] = []
        self.pinched: list[Meeting] = []  # a pair that was found intersecting again and again
        self.heals = False  # whether `play` stops there
        self._left_out: set[tuple[int, int]] = set()
        self._in_a_row: dict[tuple[int, int], int] = {}
        self.begin(0.0)
        if before is None:
            self._refuse_overlaps()
        else:
            self.restore(before.checkpoint())

    def checkpoint(self) -> tuple[Any, float, dict[tuple[int, int], int]]:
        """What a step changes: the memory of the pairs and the local clock."""
        return self.table.checkpoint(), self.now, dict(self._in_a_row)

    def restore(self, kept: tuple[Any, float, dict[tuple[int, int], int]]) -> None:
        """Goes back to a checkpoint."""
        table, self.now, in_a_row = kept
        self._in_a_row = dict(in_a_row)
        self.table.restore(table)

    def begin(self, start_time: float) -> None:
        """Starts a step at `start_time` [s]: the local clock is set to zero."""
        self.table.set_clock_back(self.now)
        self.now, self.start_time = 0.0, start_time
        self.ledger = Ledger()
        self.rounds = 0
        self.pinched = []
        self._left_out.clear()

    def play(self, until: float) -> float:
        """Moves all bodies to local time `until` [s], colliding on the way (P10): the time reached.

        It is less where bodies are `pinched`.
        """
        self.table.refresh(self.now, until)
        while self.rounds < self.settings.budget:
            closeness = self.table.measure(self.now, self.settings.tolerance)
            queue = self._build(closeness, until - self.now)
            if self.pinched:
                self.world.advance(self.now)
                return self.now
            if not len(queue.pairs):
                break
            self.rounds += 1
            if self.settings.rule == "paper":
                self._respond(closeness, queue.simultaneous(until - self.now), until)
            else:
                touching = self._in_contact(closeness, queue.pairs)
                if len(touching):
                    self._respond(closeness, touching, until)
                    continue
            self.now += float(queue.seconds[0] / self.settings.substeps)
            self.world.advance_some(self.now, self.table.bodies_in_play)
        self._advance(until)
        return self.now

    def record(self) -> CollisionRecord:
        """What happened since `begin`."""
        names = self.world.names
        contacts = tuple(
            Contact(names[a], names[b], impulse, count)
            for (a, b), (impulse, count) in sorted(self.ledger.contacts.items())
        )
        budget = Budget(self.settings.budget, self.rounds)
        return CollisionRecord(tuple(self.ledger.impacts), contacts, self.ledger.books, budget)

    def _advance(self, time: float) -> None:
        self.now = float(time)
        self.world.advance(self.now)

    def _build(self, closeness: Closeness, window: float) -> Queue:
        """The queue (P10, 1 to 3); pairs found intersecting have time zero, unless left out (P14)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            seconds = np.where(closeness.approach > 0.0, closeness.distance / closeness.approach, np.inf)
        overlapping = closeness.distance == 0.0
        self._count_overlaps(closeness, overlapping)
        inside = seconds <= window
        if self._left_out:
            out = np.array([tuple(pair) in self._left_out for pair in self.table.pairs.tolist()])
            inside &= ~(out & overlapping)
        order = np.flatnonzero(inside)
        order = order[np.argsort(seconds[order], kind="stable")]
        if (inside & ~overlapping).any():
            self._left_out.clear()
        return Queue(order, seconds[order])

    def _in_contact(self, closeness: Closeness, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
        """Those of the queue whose gap is within the tolerance (rule `paper-advance`)."""
        gap_allowed = self.settings.tolerance * self.table.smaller_size[pairs]
        return pairs[closeness.distance[pairs] <= gap_allowed]

    def _respond(self, closeness: Closeness, touching: NDArray[np.int64], until: float) -> None:
        """Responds to pairs in the order of time, then of their bodies' names (P10, 4a)."""
        outrun = False
        for k in touching:
            a, b = map(int, self.table.pairs[k])
            touch = Touch(a, b, closeness.point_a[k], closeness.point_b[k], closeness.normal[k])
            parallel = self._criteria is not None and self._criteria.met(k, touch)
            if closeness.distance[k] == 0.0:
                self._left_out.add((a, b))
                touch = touch.at_midpoint()
            if respond(self.world, self.ledger, touch, self.now, self.start_time, parallel=parallel):
                outrun |= self.table.outruns((a, b), until)
        if outrun:
            self.world.advance(self.now)
            self.table.refresh(self.now, until)

    def _refuse_overlaps(self) -> None:
        """The rules know a contact by where it was last apart, so a scene must start without one."""
        table, names, state = self.table, self.world.names, self.world.state
        table.refresh(0.0, 0.0)
        distance = table.measure(0.0, self.settings.tolerance).distance
        found = [(a, b, MEETING) for a, b in table.pairs[distance == 0.0]]
        parts = table.store.arrays, table.shape_of_body, table.pairs[distance > 0.0], state.position, state.rotation
        found += [(a, b, INSIDE) for a, b in nested(*parts)]
        problems = [
            Problem(self.world.scene.name, None, f'bodies "{names[a]}" and "{names[b]}"', how) for a, b, how in found
        ]
        if problems:
            raise SceneError(problems)

    def _count_overlaps(self, closeness: Closeness, overlapping: NDArray[np.bool_]) -> None:
        """Books the pairs that intersect now and did not at the last sub-step, and the depth of all that do (P8).

        Two or more intersections of a pair in a row, while it closes, are a blockage (P15).
        """
        in_a_row = {}
        for k in np.flatnonzero(overlapping):
            a, b = map(int, self.table.pairs[k])
            depth = self.table.overlap_depth(int(k), closeness.normal[k])
            self.ledger.books.meet_overlap(depth, new=not self.table.last.overlapping[k])
            in_a_row[a, b] = self._in_a_row.get((a, b), 0) + 1
            approach = float(closeness.approach[k])
            if self.heals and in_a_row[a, b] >= BLOCKAGE and approach > 0.0 and not self.pinched:
                self.pinched = [Meeting(a, b, closeness.point_b[k], closeness.normal[k], 0.0, depth)]
        self._in_a_row = in_a_row
        self.table.last.overlapping[:] = overlapping
