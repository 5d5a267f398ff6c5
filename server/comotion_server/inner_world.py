"""The bodies as the queue plays them, where they may change within a step: joined (P11) or scaled (P16).

The outer world has a row for each body of the scene, always. The inner world has a row for each body that moves by
itself: a body, or a group whose members it carries. It is made afresh whenever bodies change.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from comotion_server.meetings import Meeting
from comotion_server.results import CollisionRecord
from comotion_server.scene import Body, Free
from comotion_server.world import Memory, World

Array = NDArray[np.float64]


class Queue(Memory, Protocol):
    """What plays the inner world."""

    joined: list[Meeting]
    pinched: list[Meeting]
    heals: bool

    def begin(self, start_time: float) -> None:
        """Starts a step: all bodies have begun flights at local time 0."""

    def play(self, until: float) -> float:
        """Moves all bodies to a local time [s], or to an earlier one, returned, at which bodies have to change."""

    def record(self) -> CollisionRecord:
        """What happened since `begin`."""


@dataclass(frozen=True, slots=True)
class Member:
    """A body of the scene as part of a body of the inner world."""

    row: int  # in the outer world
    offset: Array  # (3,) of its centre from that of the group, axes of the group [m]
    turn: Array  # (3,3) from its axes to the group's
    scale: float = 1.0
    mass: float = np.nan  # [kg]
    inertia: Array | None = None  # (3,3) its own axes [kg m2]


@dataclass(frozen=True, slots=True)
class Part:
    """A body of the inner world: its members, and its state x, v, R, L, w."""

    body: Body
    members: tuple[Member, ...]
    state: tuple[Array, ...]


@dataclass(frozen=True, slots=True)
class Inner:
    """The inner world, the queue that plays it, and the members of each of its bodies, in their order."""

    world: World
    queue: Queue
    members: tuple[tuple[Member, ...], ...]

    def part(self, i: int) -> Part:
        """Body i as it is."""
        return Part(
            self.world.scene.bodies[i], self.members[i], tuple(array[i].copy() for array in self.world.state.arrays)
        )


def alone(world: World) -> tuple[tuple[Member, ...], ...]:
    """Every body by itself."""
    return tuple(
        (Member(row, np.zeros(3), np.eye(3), 1.0, body.mass, body.inertia),)
        for row, body in enumerate(world.scene.bodies)
    )


def world_of(parts: Sequence[Part], before: World) -> World:
    """A world of these parts, in the order of their bodies' names."""
    world = World(replace(before.scene, bodies=tuple(part.body for part in parts)))
    world.thrust[:] = 0.0  # it is among the wrenches of the members, because of its arms
    for i, part in enumerate(parts):
        for array, values in zip(world.state.arrays, part.state, strict=True):
            array[i] = values
    return world


def wrenches(inner: Inner, force: Array, moment: Array) -> tuple[Array, Array]:
    """Forces and moments of the inner bodies about their centres, from those of all members (n,3)."""
    state = inner.world.state
    total, turning = np.zeros_like(state.position), np.zeros_like(state.position)
    for i, members in enumerate(inner.members):
        for member in members:
            arm = state.rotation[i] @ member.offset
            total[i] += force[member.row]
            turning[i] += moment[member.row] + np.cross(arm, force[member.row])
    return total, turning


def place(inner: Inner, outer: World) -> None:
    """Puts the bodies of the scene where the inner world has them."""
    state, ours = outer.state, inner.world.state
    for i, members in enumerate(inner.members):
        for member in members:
            state.scale[member.row], outer.mass[member.row] = member.scale, member.mass
        if len(members) == 1:
            for theirs, own in zip(state.arrays, ours.arrays, strict=True):
                theirs[members[0].row] = own[i]
            continue
        R, w = ours.rotation[i], ours.spin[i]
        for member in members:
            arm, row = R @ member.offset, member.row
            state.position[row] = ours.position[i] + arm
            state.velocity[row] = ours.velocity[i] + np.cross(w, arm)
            state.rotation[row], state.spin[row] = R @ member.turn, w
            state.momentum[row] = state.rotation[row] @ member.inertia @ state.rotation[row].T @ w


def kinetic_energy(world: World) -> float:
    """Of the bodies that are free [J]."""
    free = np.array([isinstance(body.motion, Free) for body in world.scene.bodies])
    _, v, _, L, w = (array[free] for array in world.state.arrays)
    return 0.5 * float((world.mass[free, None] * v * v).sum() + (L * w).sum())
