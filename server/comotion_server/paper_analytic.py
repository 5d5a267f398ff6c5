"""The paper's collision queue for analytic bodies, to the letter (P19): spheres, planes and pipes.

There are no sub-steps. Over the whole step: (1) find the time to collision of every pair, (2) drop those that do not
collide within the step, (3) sort; pairs that intersect have time zero; (4) while there is a first pair: respond to it
and to all with the same time, then build the queue anew over the *whole* step with the changed velocities, leaving out
the pairs that collided last; (5) advance all bodies by the whole step.

Bodies are not moved before they are answered: an impact has the normal of where they are at the beginning of the step,
and whoever is pushed early misses what it would have met on its way. A pair that intersects and parts is no collision.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.contact_response import Ledger, Touch, respond
from comotion_server.exact_scene import solids_of
from comotion_server.kernels.paper_times import pairs_of, times_of, touch_of
from comotion_server.results import Budget, CollisionRecord, Contact
from comotion_server.world import World

SAME_TIME = 1e-12  # of the step: collisions closer in time count as simultaneous


class AnalyticQueue:
    """Plays the flights of a world through the collisions of a step."""

    def __init__(self, world: World) -> None:
        self.world, self.settings = world, world.scene.collisions
        self.solids = solids_of([body.shape for body in world.scene.bodies])
        pairs = np.empty((0, 2), dtype=np.int64)
        count = pairs_of(self.solids, world.bodies, world.flights, pairs)
        self.pairs = np.empty((count, 2), dtype=np.int64)
        pairs_of(self.solids, world.bodies, world.flights, self.pairs)

    def begin(self, start_time: float) -> None:
        """Starts a step at `start_time` [s]: all bodies have begun flights at local time 0."""
        self.now, self.start_time = 0.0, start_time
        self.ledger, self.rounds = Ledger(), 0

    def play(self, until: float) -> None:
        """Moves all bodies to local time `until` [s]."""
        last = np.zeros(len(self.pairs), dtype=np.bool_)
        seconds = np.empty(len(self.pairs))
        while self.rounds < self.settings.budget:
            times_of(self.solids, self.world.flights, self.pairs, self.now, until, seconds)
            seconds[last] = np.inf
            if not seconds.min(initial=np.inf) < until:
                break
            self.rounds += 1
            last = seconds <= seconds.min() + SAME_TIME * (until - self.now)
            self._respond(self.pairs[last])
        self.now = until
        self.world.advance(until)

    def _respond(self, pairs: NDArray[np.int64]) -> None:
        """Responds to pairs in the order of their bodies' names."""
        points = np.empty((3, 3))
        for a, b in pairs.tolist():
            gap = touch_of(self.solids, self.world.flights, a, b, self.now, points)
            point_a, point_b, normal = points.copy()
            touch = Touch(a, b, point_a, point_b, normal)
            if gap <= 0.0:
                touch = touch.at_midpoint()
            respond(self.world, self.ledger, touch, self.now, self.start_time, parallel=False)

    def record(self) -> CollisionRecord:
        """What happened since `begin`."""
        names = self.world.names
        contacts = tuple(
            Contact(names[a], names[b], impulse, count)
            for (a, b), (impulse, count) in sorted(self.ledger.contacts.items())
        )
        budget = Budget(self.settings.budget, self.rounds)
        return CollisionRecord(tuple(self.ledger.impacts), contacts, self.ledger.books, budget)

    def checkpoint(self) -> Any:
        """Nothing is carried from step to step."""

    def restore(self, kept: Any) -> None:
        """Likewise."""
