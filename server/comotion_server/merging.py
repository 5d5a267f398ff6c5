"""Bodies that meet with restitution 0 become one (P11), where the scene says `merge = true`.

The queue then works on an inner world, whose bodies are the scene's or groups of them: combined mass, centre, inertia
and surface, axes parallel to the world's when the group was made. At the time of a contact that merges, the inner world
is made afresh and the step goes on in it. In the outer world every row stays its own body, carried by its group:
regions, forces and results know nothing of groups. A group goes by the name of its first member. A body that meets one
that is fixed is fixed; with bodies that move as they are told nothing merges.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.exact_queue import ExactQueue, Joint
from comotion_server.meshes import TriangleMesh
from comotion_server.results import Books, Budget, CollisionRecord, Contact, Impact
from comotion_server.scene import Body, Fixed, Free
from comotion_server.world import World

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Member:
    """A body of the scene as part of a body of the inner world."""

    row: int  # in the outer world
    offset: Array  # (3,) of its centre from that of the group, axes of the group [m]
    turn: Array  # (3,3) from its axes to the group's


@dataclass(frozen=True, slots=True)
class Inner:
    """The world of the groups, the queue that plays it, and who belongs to which of its bodies, in their order."""

    world: World
    queue: ExactQueue
    members: tuple[tuple[Member, ...], ...]


class Merging:
    """Plays the steps of a world whose bodies merge."""

    def __init__(self, world: World) -> None:
        self.world = world
        alone = tuple((Member(row, np.zeros(3), np.eye(3)),) for row in range(world.body_count))
        inner = World(world.scene)
        inner.thrust[:] = 0.0  # the members' thrust is among the wrenches, because of its arms
        self._inner = Inner(inner, ExactQueue(inner), alone)
        self._place()

    def step(
        self, start_time: float, duration: float, force: Array, moment: Array, *, drifting: bool
    ) -> CollisionRecord:
        """Moves all bodies by `duration` [s] under fluid forces and moments (n,3), held; or drifting without any."""
        records, done = [], 0.0
        while done < duration:
            inner = self._inner
            if drifting:
                inner.world.take_off_drifting()
            else:
                inner.world.take_off(*self._sums(force + self.world.thrust, moment))
            inner.queue.begin(start_time + done)
            left = duration - done
            for until in inner.world.stops(start_time + done, left):
                reached = inner.queue.play(until)
                if reached < until:
                    break
                inner.world.follow_tables(start_time + done + until, until)
            done = duration if reached == left else done + reached
            records.append(inner.queue.record())
            if inner.queue.joined:
                records.append(self._merge(inner.queue.joined, start_time + done))
            self._place()
        return _together(records)

    def _sums(self, force: Array, moment: Array) -> tuple[Array, Array]:
        """The wrenches of the inner bodies about their centres, from those of all members."""
        state = self._inner.world.state
        total, turning = np.zeros_like(state.position), np.zeros_like(state.position)
        for i, members in enumerate(self._inner.members):
            for member in members:
                arm = state.rotation[i] @ member.offset
                total[i] += force[member.row]
                turning[i] += moment[member.row] + np.cross(arm, force[member.row])
        return total, turning

    def _place(self) -> None:
        """The bodies of the scene where their groups have them."""
        inner, outer = self._inner.world.state, self.world.state
        for i, members in enumerate(self._inner.members):
            if len(members) == 1:
                for theirs, own in zip(outer.arrays, inner.arrays, strict=True):
                    theirs[members[0].row] = own[i]
                continue
            R, w = inner.rotation[i], inner.spin[i]
            for member in members:
                arm, row = R @ member.offset, member.row
                outer.position[row] = inner.position[i] + arm
                outer.velocity[row] = inner.velocity[i] + np.cross(w, arm)
                outer.rotation[row], outer.spin[row] = R @ member.turn, w
                outer.momentum[row] = outer.rotation[row] @ self._body(row).inertia @ outer.rotation[row].T @ w

    def _body(self, row: int) -> Body:
        return self.world.scene.bodies[row]

    # new groups

    def _merge(self, joints: Sequence[Joint], time: float) -> CollisionRecord:
        """The inner world is made afresh, with groups of the bodies that `joints` join."""
        before = self._inner
        energy, momenta = _energy(before.world), before.world.mass[:, None] * before.world.state.velocity
        parts = [part for group in _groups(joints, before.world.body_count) for part in self._parts(group)]
        parts.sort(key=lambda part: part.body.name)
        world = World(replace(before.world.scene, bodies=tuple(part.body for part in parts)))
        world.thrust[:] = 0.0
        for i, part in enumerate(parts):
            for array, values in zip(world.state.arrays, part.state, strict=True):
                array[i] = values
        self._inner = Inner(world, ExactQueue(world), tuple(part.members for part in parts))
        self._place()
        changes = self._changes(before, momenta)
        books = Books(impacts=len(joints), rest_energy=energy - _energy(world))
        return CollisionRecord(*_records(joints, changes, before.world, time), books)

    def _parts(self, group: tuple[int, ...]) -> list["Part"]:
        """What becomes of inner bodies that meet: one body, or all stand still where one of them is fixed."""
        world, members = self._inner.world, self._inner.members
        bodies = [world.scene.bodies[i] for i in group]
        states = [tuple(array[i].copy() for array in world.state.arrays) for i in group]
        if len(group) == 1:
            return [Part(bodies[0], members[group[0]], states[0])]
        if any(isinstance(body.motion, Fixed) for body in bodies):
            still = [(x, np.zeros(3), R, np.zeros(3), np.zeros(3)) for x, _, R, _, _ in states]
            fixed = [replace(body, motion=Fixed()) for body in bodies]
            return [Part(body, members[i], state) for body, i, state in zip(fixed, group, still, strict=True)]
        return [_combined(bodies, states, [members[i] for i in group])]

    def _changes(self, before: Inner, momenta: Array) -> Array:
        """How much the momentum of each body of the world before (k,3) has changed by merging [N s]."""
        mass, velocity = self.world.mass, self.world.state.velocity
        after = [sum((mass[m.row] * velocity[m.row] for m in group), np.zeros(3)) for group in before.members]
        moves = np.array([isinstance(body.motion, Free) for body in before.world.scene.bodies])
        return np.where(moves[:, None], np.array(after) - momenta, 0.0)

    # from step to step

    def checkpoint(self) -> Any:
        """Everything that a step changes."""
        return self._inner, self._inner.world.checkpoint(), self._inner.queue.checkpoint()

    def restore(self, kept: Any) -> None:
        """Goes back to a checkpoint, which stays usable."""
        self._inner, world, queue = kept
        self._inner.world.restore(world)
        self._inner.queue.restore(queue)


@dataclass(frozen=True, slots=True)
class Part:
    """A body of a new inner world: its members, and its state x, v, R, L, w."""

    body: Body
    members: tuple[Member, ...]
    state: tuple[Array, ...]


def _combined(bodies: list[Body], states: list[tuple[Array, ...]], members: list[tuple[Member, ...]]) -> Part:
    """Bodies that are free as one, its axes parallel to the world's."""
    mass = sum(body.mass for body in bodies)
    masses = np.array([body.mass for body in bodies])
    x, v, L = (np.array([state[k] for state in states]) for k in (0, 1, 3))
    locked = np.logical_or.reduce([body.motion.locked for body in bodies if isinstance(body.motion, Free)], axis=0)
    centre = masses @ x / mass
    velocity = np.where(locked[:3], 0.0, masses @ v / mass)
    inertia, momentum, vertices, triangles, inside, first = np.zeros((3, 3)), np.zeros(3), [], [], [], 0
    for body, own, state, parts in zip(bodies, L, states, members, strict=True):
        R, arm = state[2], state[0] - centre
        inertia += R @ body.inertia @ R.T + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        momentum += own + body.mass * np.cross(arm, state[1] - velocity)
        mesh = body.collision_mesh  # nobody but the queue sees the whole's surface
        vertices.append(mesh.vertices @ R.T + arm)
        triangles.append(mesh.triangles + np.uint32(first))
        inside += [Member(part.row, R @ part.offset + arm, R @ part.turn) for part in parts]
        first += len(mesh.vertices)
    momentum = np.where(locked[3:], 0.0, momentum)
    turning = np.flatnonzero(~locked[3:])
    spin = np.zeros(3)
    if len(turning):
        spin[turning] = np.linalg.solve(inertia[np.ix_(turning, turning)], momentum[turning])
    whole = Body(
        name=bodies[0].name,
        region=bodies[0].region,
        motion=Free(locked=tuple(locked.tolist())),
        mass=mass,
        inertia=inertia,
        shape=TriangleMesh(np.concatenate(vertices), np.concatenate(triangles)),
        material=bodies[0].material,
    )
    return Part(whole, tuple(inside), (centre, velocity, np.eye(3), momentum, spin))


def _groups(joints: Sequence[Joint], count: int) -> list[tuple[int, ...]]:
    """Rows that are joined, ascending, and all others alone."""
    group = {i: {i} for i in range(count)}
    for joint in joints:
        both = group[joint.a] | group[joint.b]
        for i in both:
            group[i] = both
    return sorted({tuple(sorted(rows)) for rows in group.values()})


def _energy(world: World) -> float:
    """Kinetic energy of the bodies that are free [J]."""
    free = np.array([isinstance(body.motion, Free) for body in world.scene.bodies])
    _, v, _, L, w = (array[free] for array in world.state.arrays)
    return 0.5 * float((world.mass[free, None] * v * v).sum() + (L * w).sum())


def _records(
    joints: Sequence[Joint], changes: Array, world: World, time: float
) -> tuple[tuple[Impact, ...], tuple[Contact, ...]]:
    """The impulses that joints carried, given how the momenta (k,3) of the bodies changed.

    A joint passes on what all bodies beyond it got; where joints close a ring, those that close it pass on nothing.
    """
    tree: list[Joint] = []
    for joint in joints:
        if joint.b not in _reached(tree, joint.a, None):
            tree.append(joint)
    impacts, contacts = [], []
    for joint in tree:
        a, b = world.names[joint.a], world.names[joint.b]
        beyond, sign = _reached(tree, joint.b, joint), 1.0
        if any(isinstance(world.scene.bodies[i].motion, Fixed) for i in beyond):
            beyond, sign = _reached(tree, joint.a, joint), -1.0
        impulse = sign * changes[sorted(beyond)].sum(axis=0)
        along = float(impulse @ joint.normal)
        slip = impulse - along * joint.normal
        impacts.append(Impact(time, a, b, joint.point, joint.normal, along, joint.approach, 0.0, "merge", slip))
        contacts.append(Contact(a, b, impulse, 1))
    return tuple(impacts), tuple(contacts)


def _reached(tree: Sequence[Joint], start: int, without: Joint | None) -> set[int]:
    """Bodies that are joined to `start` by joints, but for one."""
    found, ways = {start}, [joint for joint in tree if joint is not without]
    grown = True
    while grown:
        more = {i for joint in ways if found & {joint.a, joint.b} for i in (joint.a, joint.b)} - found
        found |= more
        grown = bool(more)
    return found


def _together(records: Sequence[CollisionRecord]) -> CollisionRecord:
    """What the parts of a step did."""
    contacts: dict[tuple[str, str], Contact] = {}
    for contact in (contact for record in records for contact in record.contacts):
        pair = contact.body_a, contact.body_b
        before = contacts.get(pair, Contact(*pair, np.zeros(3), 0))
        held, count = before.held + contact.held, before.count + contact.count
        contacts[pair] = Contact(*pair, before.impulse + contact.impulse, count, held)
    books = Books()
    for part in (record.books for record in records):
        books.momentum = max(books.momentum, part.momentum)
        books.angular_momentum = max(books.angular_momentum, part.angular_momentum)
        books.energy = max(books.energy, part.energy)
        books.impacts += part.impacts
        books.rest_energy += part.rest_energy
        books.shift_work += part.shift_work
    budgets = [record.budget for record in records]
    budget = Budget(
        max(budget.limit for budget in budgets),
        sum(budget.used for budget in budgets),
        sum(budget.capped for budget in budgets),
        sum(budget.fallback for budget in budgets),
    )
    return CollisionRecord(
        tuple(impact for record in records for impact in record.impacts),
        tuple(contacts[pair] for pair in sorted(contacts)),
        books,
        budget,
        tuple(blocked for record in records for blocked in record.blocked),
    )
