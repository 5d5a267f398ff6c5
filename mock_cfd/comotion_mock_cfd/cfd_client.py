"""The mock's time loop: forces at the surfaces last received, a step of the server, and so on to the end.

    fluid_scene = load_fluid(path_of("channel"))
    with MotionClient.open("channel", wants=wants(), dt=fluid_scene.dt) as motion:
        CfdClient(motion, fluid_scene).run(on_step=print)

`run` is the loop to read for whoever writes a client of his own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from comotion_mock_cfd.added_mass import AddedMass
from comotion_mock_cfd.bodies import BodyTable
from comotion_mock_cfd.fluid import FluidError, FluidScene
from comotion_mock_cfd.fluid_forces import fluid_forces
from comotion_protocol.messages import OpenReply, StepReply, Wants

if TYPE_CHECKING:
    from collections.abc import Callable

    from comotion_mock_cfd.water_line import Floats
    from comotion_protocol.client import MotionClient

STEP_ROUNDING = 1e-6
"""A rest of the duration up to this share of dt belongs to the step before: it is the rounding of the sum of steps."""


def wants(sample: Literal["midpoint", "end"] = "midpoint") -> Wants:
    """What to ask for when opening a session for a `CfdClient`.

    `midpoint`: forces are computed for the predicted middle of the step that they are held over. Sampled at its start
    (`end`, that is, of the step before) and held, they pump energy into whatever floats.
    """
    return Wants(velocities=True, poses=True, twists=True, impacts=True, contacts=True, sample=sample)


@dataclass(frozen=True)
class StepRecord:
    """One step as it went."""

    step: int
    time: float
    """At the end of the step [s]."""
    dt: float
    wrenches: Floats
    """Fluid force [N] and moment about the centre of mass [N m], shape (bodies, 6), held over the step; world."""
    reply: StepReply


class CfdClient:
    """A CFD solver's side of the exchange, with formulas in place of a flow field."""

    def __init__(self, motion: MotionClient, scene: FluidScene) -> None:
        """Take a session that was opened with `wants()`.

        Raises:
            FluidError: the fluid names bodies that the run does not have, or the session was opened otherwise.
        """
        self.bodies = BodyTable.of(motion.opened.regions)
        self._motion = motion
        self._scene = scene
        self._vertices: dict[str, Floats] = {}
        self._velocities: dict[str, Floats] = {}
        self._still_forces: dict[str, Floats] = {}
        self._receive(motion.opened)
        self._added_mass = AddedMass(self.bodies, scene.fluid.added_mass if scene.fluid else {}, self._twists)

    def run(self, on_step: Callable[[StepRecord], None] | None = None) -> None:
        """Play the scene to its end; `on_step` sees every step and may raise to stop."""
        time = self._motion.opened.time
        while (dt := self._step_at(time)) > 0.0:
            forces = self._forces()
            wrenches = self.bodies.wrenches(forces, self._vertices, self._centres)
            reply = self._motion.step(dt, forces, dt_next=self._step_at(time + dt) or dt)
            self._receive(reply)
            self._added_mass.observe(self._twists, dt)
            time = reply.time
            if on_step is not None:
                on_step(StepRecord(reply.step, time, dt, wrenches, reply))

    def _step_at(self, time: float) -> float:
        """Size of the step that begins at `time` [s]: dt, the rest of the duration, or 0 at the end."""
        dt, rest = self._scene.dt, self._scene.duration - time
        if rest > dt * (1.0 + STEP_ROUNDING):
            return dt
        return rest if rest > dt * STEP_ROUNDING else 0.0

    def _forces(self) -> dict[str, Floats]:
        """Nodal forces [N], (n, 3) per region, at the surfaces last received."""
        for name in self._vertices.keys() - self._still_forces.keys():
            self._still_forces[name] = fluid_forces(
                self._scene, self._vertices[name], self._velocities[name], self._motion.triangles[name]
            )
        forces = {name: nodal.copy() for name, nodal in self._still_forces.items()}
        self._added_mass.add_to(forces, self._vertices, self._centres)
        return forces

    def _receive(self, reply: OpenReply | StepReply) -> None:
        """Take the surfaces of a reply; a region that it leaves out has not moved, and its forces stay as they are."""
        if reply.poses is None or reply.twists is None or reply.vertices.keys() - reply.velocities.keys():
            raise FluidError("poses, twists and velocities are needed: open the session with wants=wants()")
        self._vertices |= reply.vertices
        self._velocities |= reply.velocities
        self._centres, self._twists = reply.poses[:, :3], reply.twists
        for name in reply.vertices:
            self._still_forces.pop(name, None)
