"""The bodies as arrays: what never changes (`Bodies`), and the state that a step changes (`State`).

Rows follow the bodies in the order of their names. Frames: world, unless a name ends in `_body`.
"""

from dataclasses import dataclass, fields
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.flight import (
    SPIN_FREE,
    SPIN_GIVEN,
    SPIN_NONE,
    Bodies,
    Flights,
    angular_velocity_of,
    begin,
    begin_all,
    begin_drift,
    fly_all,
    fly_rows,
)
from comotion_server.quaternions import rotation_from_quaternion
from comotion_server.scene import Body, Fixed, Free, Prescribed, Scene

Array = NDArray[np.float64]

FARTHEST = 1e15  # [m] in a step; beyond it coordinates have lost their decimals
MOST_TURNED = 1e12  # [rad] in a step, by its bound; likewise


@dataclass(slots=True)
class State:
    """Position, velocity, attitude, angular momentum and angular velocity of all bodies, world frame, SI units."""

    position: Array  # (n,3) of the centres of mass
    velocity: Array  # (n,3)
    rotation: Array  # (n,3,3) body to world
    momentum: Array  # (n,3) angular, about the centres of mass
    spin: Array  # (n,3) angular velocity
    scale: Array  # (n,) of the bodies, relative to the scene's (P16)

    def copy(self) -> "State":
        """The same numbers in arrays of their own."""
        return State(*(getattr(self, f.name).copy() for f in fields(self)))

    def assign(self, other: "State") -> None:
        """Takes over the numbers of `other`; the arrays stay the same objects."""
        for f in fields(self):
            getattr(self, f.name)[:] = getattr(other, f.name)

    @property
    def arrays(self) -> tuple[Array, Array, Array, Array, Array]:
        """In the order in which kernels take them: x, v, R, L, w."""
        return self.position, self.velocity, self.rotation, self.momentum, self.spin


class Memory(Protocol):
    """What a stage carries from step to step, beside the state of the bodies."""

    def checkpoint(self) -> Any:
        """All of it, as a copy."""

    def restore(self, kept: Any) -> None:
        """Goes back to a checkpoint, which stays usable."""


class World:
    """All bodies of a scene, their state at a local time, and the flights they are on."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.names = tuple(body.name for body in scene.bodies)
        self.mass = np.array([body.mass for body in scene.bodies], dtype=np.float64)
        self.thrust = np.array([_thrust_of(body) for body in scene.bodies])
        self.bodies = _compile_bodies(scene)
        self.state = _initial_state(scene, self.bodies)
        self.flights = _empty_flights(len(scene.bodies))
        self.memories: list[Memory] = []
        self.tables = {
            row: body.motion.table
            for row, body in enumerate(scene.bodies)
            if isinstance(body.motion, Prescribed) and body.motion.table is not None
        }

    @property
    def body_count(self) -> int:
        """How many bodies there are."""
        return len(self.names)

    def take_off(self, force: Array, moment: Array) -> None:
        """Begins the step's flights under fluid forces [N] and moments [N m] (n,3), held to its end (P2)."""
        begin_all(self.flights, self.bodies, force + self.thrust, moment, *self.state.arrays)

    def stays_in_range(self, force: Array, moment: Array, duration: float) -> bool:
        """Whether flights of `duration` [s] under forces [N] and moments [N m] (n,3) stay within what is computed."""
        bodies, state = self.bodies, self.state
        with np.errstate(over="ignore", invalid="ignore"):
            pull = bodies.inverse_mass * (force + self.thrust) + bodies.gravity
            way = duration * (np.abs(state.velocity) + 0.5 * duration * np.abs(pull))
            turn = duration * (np.abs(state.momentum) + duration * np.abs(moment)) / bodies.moments[:, :1]
        turn[bodies.spin == SPIN_NONE] = 0.0
        return bool((way < FARTHEST).all() and (turn < MOST_TURNED).all())

    def take_off_drifting(self) -> None:
        """Begins flights with the present velocities held: the prediction for midpoint sampling."""
        begin_drift(self.flights, *self.state.arrays)

    def follow_tables(self, time: float, local_time: float) -> None:
        """Puts the bodies with a table of poses where it says for `time` [s], on flights from `local_time` [s]."""
        x, v, R, L, w = self.state.arrays
        for row, table in self.tables.items():
            position, quaternion = table.pose(time)
            x[row], R[row] = position, rotation_from_quaternion(quaternion)
            v[row], w[row] = table.twist(time)
            begin(self.flights, self.bodies, row, local_time, x[row], v[row], R[row], L[row], w[row])

    def stops(self, time: float, duration: float) -> list[float]:
        """Local times [s] at which a step from `time` stops: rows of the tables inside it, and its end."""
        rows = {
            float(row) - time for table in self.tables.values() for row in table.times if 0.0 < row - time < duration
        }
        return [*sorted(rows), duration]

    def checkpoint(self) -> tuple[State, list[Any]]:
        """Everything a step changes."""
        return self.state.copy(), [memory.checkpoint() for memory in self.memories]

    def restore(self, kept: tuple[State, list[Any]]) -> None:
        """Goes back to a checkpoint, which stays usable."""
        state, memories = kept
        self.state.assign(state)
        for memory, before in zip(self.memories, memories, strict=True):
            memory.restore(before)

    def advance(self, time: float) -> None:
        """Moves all bodies to the local `time` [s] of their flights."""
        fly_all(self.flights, self.bodies, time, *self.state.arrays)

    def advance_some(self, time: float, rows: NDArray[np.int64]) -> None:
        """Moves the bodies in `rows` (k,) alone, for as long as nothing asks where the others are."""
        fly_rows(rows, self.flights, self.bodies, time, *self.state.arrays)


def _thrust_of(body: Body) -> Array:
    return body.motion.thrust if isinstance(body.motion, Free) else np.zeros(3)


@dataclass(frozen=True, slots=True)
class Mobility:
    """What a body's motion leaves free."""

    translation: tuple[bool, bool, bool]
    spin: int
    reacts: bool

    @classmethod
    def of(cls, body: Body) -> Self:
        """From the motion that the scene gives the body."""
        if isinstance(body.motion, Fixed):
            return cls((False, False, False), SPIN_NONE, reacts=False)
        if isinstance(body.motion, Prescribed):
            return cls((False, False, False), SPIN_GIVEN, reacts=False)
        x, y, z, *turns = body.motion.locked
        free_axes = [axis for axis, locked in enumerate(turns) if not locked]
        spin = {0: SPIN_NONE, 1: free_axes[0] if free_axes else SPIN_NONE, 3: SPIN_FREE}[len(free_axes)]
        return cls((not x, not y, not z), spin, body.motion.reacts)


def _compile_bodies(scene: Scene) -> Bodies:
    count = len(scene.bodies)
    moments, principal = np.ones((count, 3)), np.tile(np.eye(3), (count, 1, 1))
    inverse_mass, gravity = np.zeros((count, 3)), np.zeros((count, 3))
    spin, reacts = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.bool_)
    for i, body in enumerate(scene.bodies):
        mobility = Mobility.of(body)
        spin[i], reacts[i] = mobility.spin, mobility.reacts
        free = np.array(mobility.translation)
        if free.any():
            inverse_mass[i, free] = 1.0 / body.mass
            gravity[i, free] = scene.gravity[free]
        if mobility.spin >= SPIN_FREE:
            moments[i], principal[i] = principal_axes(body.inertia)
    return Bodies(moments, principal, spin, inverse_mass, gravity, reacts)


def principal_axes(inertia: Array) -> tuple[Array, Array]:
    """Ascending principal moments (3,) and right-handed axes as columns (3,3) of an inertia tensor (3,3)."""
    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    return moments, np.ascontiguousarray(axes)


def _initial_state(scene: Scene, bodies: Bodies) -> State:
    count = len(scene.bodies)
    x, v, R, L, w = ((count, 3), (count, 3), (count, 3, 3), (count, 3), (count, 3))
    state = State(np.zeros(x), np.zeros(v), np.zeros(R), np.zeros(L), np.zeros(w), np.ones(count))
    for i, body in enumerate(scene.bodies):
        state.position[i] = body.position
        state.rotation[i] = rotation_from_quaternion(body.quaternion)
        free = bodies.inverse_mass[i] > 0.0
        state.velocity[i, free] = body.velocity[free]
        spin = bodies.spin[i]
        if isinstance(body.motion, Prescribed):
            state.velocity[i], state.spin[i] = body.motion.velocity, body.motion.angular_velocity
        if spin >= SPIN_FREE:
            axes = state.rotation[i] @ bodies.principal[i]
            turning = body.angular_velocity if spin == SPIN_FREE else body.angular_velocity * (np.arange(3) == spin)
            momentum = axes @ (bodies.moments[i] * (axes.T @ turning))
            state.momentum[i] = momentum if spin == SPIN_FREE else momentum * (np.arange(3) == spin)
            state.spin[i] = turning
        if spin == SPIN_FREE:
            angular_velocity_of(
                state.rotation[i], state.momentum[i], bodies.moments[i], bodies.principal[i], state.spin[i]
            )
    return state


def _empty_flights(count: int) -> Flights:
    vector = (count, 3)
    return Flights(
        origin=np.zeros(count),
        position=np.zeros(vector),
        velocity=np.zeros(vector),
        acceleration=np.zeros(vector),
        rotation=np.zeros((count, 3, 3)),
        momentum=np.zeros(vector),
        torque=np.zeros(vector),
        axis=np.zeros(vector),
        rate=np.zeros((count, 2)),
        kind=np.zeros(count, dtype=np.int64),
    )
