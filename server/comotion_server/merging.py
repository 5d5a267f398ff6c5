"""Bodies that meet with restitution 0 become one (P11), where the scene says `merge = true`.

The first body of a group, by name, carries it: its row of the world's arrays is that of the whole, about the common
centre of mass; the others have no motion of their own. Between steps every row is its own body's again, so regions,
forces and results know nothing of groups. A body that meets one that is fixed, or told to move straight, stays with it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.flight import SPIN_FREE, SPIN_GIVEN, SPIN_NONE, angular_velocity_of
from comotion_server.meshes import TriangleMesh
from comotion_server.world import World, principal_axes

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Member:
    """A body of a group: its pose in the axes of the group, about the common centre."""

    row: int
    turn: Array  # (3,3) from the body's axes
    offset: Array  # (3,) of its centre [m]


@dataclass(frozen=True, slots=True)
class Group:
    """Bodies that move as one, carried by the first of `members`."""

    members: tuple[Member, ...]
    mass: float  # [kg]
    inertia: Array  # (3,3) in its axes [kg m2]
    state: tuple[Array, ...]  # x, v, R, L, w of the whole

    @property
    def carrier(self) -> int:
        """The row of the whole."""
        return self.members[0].row


class Merging:
    """The groups of a world."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.groups: tuple[Group, ...] = ()

    # from step to step

    def load(self, force: Array, moment: Array) -> tuple[Array, Array]:
        """Rows of carriers become those of their groups; wrenches (n,3) are summed about the common centres."""
        force, moment = force.copy(), moment.copy()
        for group in self.groups:
            x = group.state[0]
            at = self.world.state.position
            total = sum((force[m.row] for m in group.members), np.zeros(3))
            turning = sum((moment[m.row] + np.cross(at[m.row] - x, force[m.row]) for m in group.members), np.zeros(3))
            for member in group.members:
                force[member.row] = moment[member.row] = 0.0
            force[group.carrier], moment[group.carrier] = total, turning
            for array, value in zip(self.world.state.arrays, group.state, strict=True):
                array[group.carrier] = value
        return force, moment

    def unload(self) -> None:
        """Every row becomes that of its own body."""
        groups = []
        for group in self.groups:
            state = tuple(array[group.carrier].copy() for array in self.world.state.arrays)
            groups.append(Group(group.members, group.mass, group.inertia, state))
            self._place(groups[-1])
        self.groups = tuple(groups)

    def _place(self, group: Group) -> None:
        """The members where their group has them."""
        x, v, R, _, w = group.state
        state = self.world.state
        for member in group.members:
            arm = R @ member.offset
            state.position[member.row], state.velocity[member.row] = x + arm, v + np.cross(w, arm)
            state.rotation[member.row], state.spin[member.row] = R @ member.turn, w
            state.momentum[member.row] = 0.0

    # a new member

    def join(self, a: int, b: int) -> TriangleMesh | None:
        """The groups carried by rows a < b, which react both, become one, carried by a: its surface."""
        whole = self._group_of(a), self._group_of(b)
        x, v, R, L, _ = self.world.state.arrays
        masses = [group.mass for group in whole]
        mass = sum(masses)
        centre = (masses[0] * x[a] + masses[1] * x[b]) / mass
        velocity = (masses[0] * v[a] + masses[1] * v[b]) / mass
        momentum, inertia, members = np.zeros(3), np.zeros((3, 3)), []
        for i, group in zip((a, b), whole, strict=True):
            arm = x[i] - centre
            momentum += L[i] + group.mass * np.cross(arm, v[i] - velocity)
            square = (arm @ arm) * np.eye(3) - np.outer(arm, arm)
            inertia += R[a].T @ (R[i] @ group.inertia @ R[i].T + group.mass * square) @ R[a]
            turn = R[a].T @ R[i]
            members += [Member(m.row, turn @ m.turn, R[a].T @ (R[i] @ m.offset + arm)) for m in group.members]
        self._write(a, b, mass, inertia, centre, velocity, momentum)
        state = tuple(array[a].copy() for array in self.world.state.arrays)
        group = Group(tuple(members), mass, inertia, state)
        self.groups = (*(g for g in self.groups if g not in whole), group)
        return self._surface(group)

    def stay(self, other: int, carrier: int) -> None:
        """The body or group of row `other` moves from now on like the body of row `carrier`, which does not react."""
        bodies, state = self.world.bodies, self.world.state
        bodies.reacts[other] = False
        bodies.inverse_mass[other] = bodies.gravity[other] = 0.0
        bodies.spin[other] = SPIN_GIVEN
        state.velocity[other] = state.velocity[carrier]
        state.momentum[other] = state.spin[other] = 0.0

    def _group_of(self, row: int) -> Group:
        """The group that a row carries; of a body alone, one of its own."""
        for group in self.groups:
            if group.carrier == row:
                return group
        mass, inertia = self.world.scene.bodies[row].mass, self.world.scene.bodies[row].inertia
        return Group((Member(row, np.eye(3), np.zeros(3)),), mass, inertia, ())

    def _write(
        self, a: int, b: int, mass: float, inertia: Array, centre: Array, velocity: Array, momentum: Array
    ) -> None:
        """Row a becomes that of the whole, and row b of a body without motion."""
        bodies, (x, v, R, L, w) = self.world.bodies, self.world.state.arrays
        free = (bodies.inverse_mass[a] > 0.0) & (bodies.inverse_mass[b] > 0.0)
        bodies.moments[a], bodies.principal[a] = principal_axes(inertia)
        bodies.inverse_mass[a] = np.where(free, 1.0 / mass, 0.0)
        bodies.gravity[a] = np.where(free, self.world.scene.gravity, 0.0)
        bodies.spin[a] = _common_spin(int(bodies.spin[a]), int(bodies.spin[b]))
        x[a], v[a], L[a] = centre, np.where(free, velocity, 0.0), 0.0
        if bodies.spin[a] == SPIN_FREE:
            L[a] = momentum
            angular_velocity_of(R[a], L[a], bodies.moments[a], bodies.principal[a], w[a])
        elif bodies.spin[a] >= 0:
            k = bodies.spin[a]
            L[a, k] = momentum[k]
            w[a] = 0.0
            w[a, k] = momentum[k] / (R[a] @ inertia @ R[a].T)[k, k]
        else:
            w[a] = 0.0
        bodies.reacts[b], bodies.spin[b] = False, SPIN_NONE
        bodies.inverse_mass[b] = bodies.gravity[b] = 0.0
        v[b] = L[b] = w[b] = 0.0

    def _surface(self, group: Group) -> TriangleMesh:
        """The surfaces of all members as one."""
        vertices, triangles, first = [], [], 0
        for member in group.members:
            mesh = self.world.scene.bodies[member.row].mesh
            vertices.append(mesh.vertices @ member.turn.T + member.offset)
            triangles.append(mesh.triangles + np.uint32(first))
            first += len(mesh.vertices)
        return TriangleMesh(np.concatenate(vertices), np.concatenate(triangles))


def _common_spin(a: int, b: int) -> int:
    """What rotation two bodies leave each other."""
    if SPIN_FREE in (a, b):
        return b if a == SPIN_FREE else a
    return a if a == b else SPIN_NONE
