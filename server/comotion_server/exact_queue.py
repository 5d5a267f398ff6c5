"""Rule `exact`: every contact at its time, answered in clusters, and held where bodies rest (docs/event_queue.md).

The compiled queue of events plays the flights of a world and answers impacts; it comes back where bodies come to rest
(`islands`), where no motion satisfies the contacts, and at the end. Between steps it keeps what it knows of pairs.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.exact_scene import queue_of, rules_of, scene_of, solids_of
from comotion_server.islands import Islands
from comotion_server.kernels import event_queue as events
from comotion_server.kernels.event_scene import HITS, LEFT, NOW, ROW, TIMER
from comotion_server.kernels.impact_log import ROWS
from comotion_server.results import Blocked, Books, Budget, CollisionRecord, Contact, Impact
from comotion_server.scene import Problem, SceneError
from comotion_server.world import World

Array = NDArray[np.float64]


class ExactQueue:
    """Plays the flights of a world through the contacts of a step."""

    def __init__(self, world: World) -> None:
        self.world, self.settings = world, world.scene.collisions
        self.solids = solids_of(world.scene.bodies)
        self.rules, self.scene = rules_of(world.scene), scene_of(world, self.solids)
        self.queue = queue_of(world, self.solids)
        while not events.start(self.queue, self.scene):
            self.queue = enlarged(self.queue)
        self.islands = Islands(self.scene, self.queue, self.rules)
        self.elapsed = 0.0
        self.blocked: list[Blocked] = []

    def begin(self, start_time: float) -> None:
        """Starts a step at `start_time` [s] with all bodies on new flights from local time 0."""
        self.start_time = start_time
        self.blocked.clear()
        events.begin_step(self.queue, self.scene, self.elapsed)
        self.queue.tally[LEFT], self.queue.tally[HITS] = self.settings.budget, 0

    def play(self, until: float) -> None:
        """Moves all bodies to local time `until` [s]."""
        self.islands.begin(until)
        queue = self.queue
        while True:
            code = events.play(queue, self.scene, self.rules, until)
            if code == events.DONE:
                break
            if code == events.REST:
                self.islands.rest(queue.pairs.bodies[queue.tally[ROW]], queue.clock[NOW], until)
            elif code == events.ISLAND:
                self.islands.rest(queue.tally[TIMER : TIMER + 1], queue.clock[NOW], until)
            else:
                raise RuntimeError(f"code {code}")
        self.world.advance(until)
        self.islands.end(until)
        self.elapsed = until
