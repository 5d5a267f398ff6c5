"""The simulation: a scene stepped under fluid forces. No network; a notebook, a test or the service drives it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from comotion_server.clock import Clock
from comotion_server.forces import StepInputError, Wrenches, check_dt, no_wrenches, wrenches_given, wrenches_of_forces
from comotion_server.plan import Plan, Step
from comotion_server.quaternions import quaternions_from_rotations
from comotion_server.regions import Region, Sample, regions_of
from comotion_server.results import StepResult
from comotion_server.scene import Scene
from comotion_server.world import World

Array = NDArray[np.float64]


class BodiesView:
    """The bodies now, in the order of their names; copies, world frame, SI units."""

    def __init__(self, world: World) -> None:
        self._world = world

    @property
    def names(self) -> tuple[str, ...]:
        """In order."""
        return self._world.names

    @property
    def scale(self) -> Array:
        """Of the geometry, relative to the scene's, shape (n,): 1 unless healing scaled a body down (P16)."""
        return self._world.state.scale.copy()

    @property
    def mass(self) -> Array:
        """[kg], shape (n,); nan for a fixed or prescribed body that was given none."""
        return self._world.mass.copy()

    @property
    def position(self) -> Array:
        """Centres of mass [m], shape (n,3)."""
        return self._world.state.position.copy()

    @property
    def quaternion(self) -> Array:
        """(w, x, y, z), body to world, shape (n,4)."""
        return quaternions_from_rotations(self._world.state.rotation)

    @property
    def velocity(self) -> Array:
        """Of the centres of mass [m/s], shape (n,3)."""
        return self._world.state.velocity.copy()

    @property
    def angular_velocity(self) -> Array:
        """[rad/s], shape (n,3)."""
        return self._world.state.spin.copy()


class Simulation:
    """Rigid bodies of a scene, moved step by step.

    Raises:
        SceneError: two bodies overlap at the start.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.plan = Plan(scene)
        self.regions = regions_of(scene)
        self._world = World(scene)
        self._regions = {region.name: region for region in self.regions}
        self._clock = Clock()
        self._actions = self.plan.build(self._world)
        self.bodies = BodiesView(self._world)
        self._sent: Sample | None = None

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """The simulation of a scene file.

        Raises:
            SceneError: all mistakes in the file, or two bodies that overlap at the start.
        """
        from comotion_server.scene import load_scene

        return cls(load_scene(path))

    @property
    def time(self) -> float:
        """Seconds since the start of the scene."""
        return self._clock.time

    def step(
        self, dt: float, forces: Mapping[str, ArrayLike] | None = None, wrenches: ArrayLike | None = None
    ) -> StepResult:
        """Moves the bodies by one CFD step under forces held constant over it (P2).

        Args:
            dt: step size [s].
            forces: per region, nodal forces [N], shape (n,3), world frame, at the vertices last sent (`mark_sent`),
                else at the present ones; none means none.
            wrenches: instead, force [N] and moment [N m] about the centres of mass last sent, shape (bodies,6).

        Raises:
            StepInputError: an input that cannot be used; the state is untouched.
            OverlapError: two bodies were put into each other; the state stays where that was found, and a
                checkpoint goes back.
        """
        dt = check_dt(dt)
        given = self._wrenches(forces, wrenches)
        if not self._world.stays_in_range(given.force, given.moment, dt):
            raise StepInputError(f"dt = {dt} with these forces: the motion leaves the range of numbers")
        sums = given.sums(self._last_sent().state.position)
        step = Step(self.time, dt, given)
        self._run(step)
        self._clock, self._sent = self._clock.after(dt), None
        done = step.collisions
        status = "blocked" if done.blocked else "ok"
        return StepResult(
            self.time, dt, status, sums, done.impacts, done.contacts, done.books, done.budget, done.blocked, done.wear
        )

    def vertices(self, region: str) -> Array:
        """World positions [m] of a region's vertices now, shape (n,3)."""
        return self._region(region).vertices(self._world.state).copy()

    def velocities(self, region: str) -> Array:
        """World velocities [m/s] of a region's vertices now, shape (n,3)."""
        return self._region(region).velocities(self._world.state)

    def sample(self, offset: float, *, vertices: bool = True, velocities: bool = False) -> Sample:
        """The bodies `offset` [s] ahead: now for 0, else drifting with their present velocities, colliding on the way.

        The state is untouched. The prediction is what midpoint sampling sends (second order for explicit coupling).
        """
        if offset == 0.0:
            return self._sample(vertices=vertices, velocities=velocities, time=self.time)
        offset = check_dt(offset)
        kept = self._world.checkpoint()
        try:
            step = Step(self.time, offset, no_wrenches(self._world.body_count), drifting=True)
            self._run(step)
            return self._sample(vertices=vertices, velocities=velocities, time=self.time + offset)
        finally:
            self._world.restore(kept)

    def mark_sent(self, sample: Sample) -> None:
        """Forces of the next step act at the vertices and centres of this sample; by default, where they are now."""
        self._sent = sample

    def checkpoint(self) -> Any:
        """Everything that a step changes, to go back to with `restore` as often as wanted."""
        return self._world.checkpoint(), self._clock, self._sent

    def restore(self, checkpoint: Any) -> None:
        """Goes back to a checkpoint, bit for bit."""
        kept, self._clock, self._sent = checkpoint
        self._world.restore(kept)

    def _run(self, step: Step) -> None:
        for action in self._actions:
            action(step)

    def _sample(self, *, vertices: bool, velocities: bool, time: float) -> Sample:
        state = self._world.state
        return Sample(
            time,
            state.copy(),
            {region.name: region.vertices(state) for region in self.regions} if vertices else {},
            {region.name: region.velocities(state) for region in self.regions} if velocities else {},
        )

    def _wrenches(self, forces: Mapping[str, ArrayLike] | None, wrenches: ArrayLike | None) -> Wrenches:
        if forces is not None and wrenches is not None:
            raise StepInputError("forces and wrenches: expected one of them; got both")
        if wrenches is not None:
            return wrenches_given(wrenches, self._world.body_count)
        if forces is not None:
            return wrenches_of_forces(forces, self._regions, self._last_sent())
        return no_wrenches(self._world.body_count)

    def _last_sent(self) -> Sample:
        return self._sent or Sample(self.time, self._world.state.copy(), {}, {})

    def _region(self, name: str) -> Region:
        if name not in self._regions:
            raise KeyError(f"unknown region {name!r}; the regions are {', '.join(map(repr, self._regions))}")
        return self._regions[name]
