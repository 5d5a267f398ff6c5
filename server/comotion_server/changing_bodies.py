"""Plays the steps of a world whose bodies may change on the way: joined (`merging`) or scaled down (`healing`).

The queue stops where bodies have to change; they do, the inner world is made afresh, and the step goes on in it. In the
outer world every row stays its own body, carried by its group: regions, forces and results know nothing of groups.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.healing import candidates, depth_of, shrunk, wear_of
from comotion_server.inner_world import Inner, Part, Queue, alone, place, world_of, wrenches
from comotion_server.meetings import Meeting
from comotion_server.merging import merge_record, merged
from comotion_server.results import CollisionRecord, together
from comotion_server.scene import SceneError
from comotion_server.world import World

Array = NDArray[np.float64]

MOST_HEALINGS = 100  # in a step (P16); after them what is pinched is blocked


class ChangingBodies:
    """Plays the steps of a world whose bodies may change on the way."""

    def __init__(self, world: World) -> None:
        self.world, self.settings = world, world.scene.collisions
        inner = World(world.scene)
        inner.thrust[:] = 0.0  # it is among the wrenches of the members, because of its arms
        self._inner = Inner(inner, _queue_of(inner), alone(world))
        place(self._inner, world)

    def step(
        self, start_time: float, duration: float, force: Array, moment: Array, *, drifting: bool
    ) -> CollisionRecord:
        """Moves all bodies by `duration` [s] under fluid forces and moments (n,3), held; or drifting without any."""
        records, done, healings = list[CollisionRecord](), 0.0, 0
        while done < duration:
            inner = self._inner
            inner.queue.heals = self.settings.heal != "off" and healings < MOST_HEALINGS
            if drifting:
                inner.world.take_off_drifting()
            else:
                inner.world.take_off(*wrenches(inner, force + self.world.thrust, moment))
            reached = self._play(start_time + done, duration - done)
            done = duration if reached == duration - done else done + reached
            records.append(inner.queue.record())
            if inner.queue.joined:
                self._merge(inner.queue.joined, start_time + done, records)
            elif inner.queue.pinched:
                healings = healings + 1 if self._heal(start_time + done, duration - done, records) else MOST_HEALINGS
            place(self._inner, self.world)
        return together(records)

    def checkpoint(self) -> Any:
        """Everything that a step changes."""
        return self._inner, self._inner.world.checkpoint(), self._inner.queue.checkpoint(), self.world.mass.copy()

    def restore(self, kept: Any) -> None:
        """Goes back to a checkpoint, which stays usable."""
        self._inner, world, queue, self.world.mass[:] = kept
        self._inner.world.restore(world)
        self._inner.queue.restore(queue)

    def _play(self, start_time: float, duration: float) -> float:
        """The inner queue plays on: to the end, or to the time returned, at which bodies have to change."""
        world, queue = self._inner.world, self._inner.queue
        queue.begin(start_time)
        for until in world.stops(start_time, duration):
            reached = queue.play(until)
            if reached < until or queue.joined or queue.pinched:
                return reached
            world.follow_tables(start_time + until, until)
        return duration

    def _merge(self, joints: Sequence[Meeting], time: float, records: list[CollisionRecord]) -> None:
        before = self._inner
        self._inner = self._made(merged(before, joints))
        records.append(merge_record(before, self._inner, joints, time))

    def _heal(self, time: float, left: float, records: list[CollisionRecord]) -> bool:
        """Scales one of the bodies that are pinched; False where none can be."""
        before = self._inner
        pinches = before.queue.pinched
        depth = depth_of(pinches, left, self.settings.depth_min)
        for i in candidates(before, pinches):
            part = shrunk(before, i, pinches, depth, self.settings)
            if part is None:
                continue
            parts = [part if k == i else before.part(k) for k in range(before.world.body_count)]
            try:
                after = self._made(parts)
            except SceneError:  # a body that is not star-shaped, scaled, may overlap what it holds or is held by
                continue
            self._inner = after
            scale = part.members[0].scale
            records.append(CollisionRecord(wear=(wear_of(before.world, after.world, i, scale, depth, time),)))
            return True
        return False

    def _made(self, parts: Sequence[Part]) -> Inner:
        world = world_of(parts, self._inner.world)
        return Inner(world, _queue_of(world, self._inner.queue), tuple(part.members for part in parts))


def _queue_of(world: World, before: Queue | None = None) -> Queue:
    if world.scene.collisions.rule == "exact":
        from comotion_server.exact_queue import ExactQueue

        return ExactQueue(world)
    from comotion_server.collision_queue import CollisionQueue

    return CollisionQueue(world, before if isinstance(before, CollisionQueue) else None)
