"""Bodies that meet with restitution 0 become one (P11), where the scene says `merge = true`.

A group has combined mass, centre, inertia and surface, axes parallel to the world's when it was made, and goes by the
name of its first member. A body that meets one that is fixed is fixed; with bodies that move as they are told nothing
merges.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from comotion_server.inner_world import Inner, Part, kinetic_energy
from comotion_server.meetings import Meeting
from comotion_server.meshes import TriangleMesh
from comotion_server.results import Books, CollisionRecord, Contact, Impact
from comotion_server.scene import Body, Fixed, Free
from comotion_server.world import World

Array = NDArray[np.float64]


def merged(inner: Inner, joints: Sequence[Meeting]) -> list[Part]:
    """The bodies of the inner world, in the order of their names, after `joints` have made groups of them."""
    parts = [part for group in _groups(joints, inner.world.body_count) for part in _group_of(inner, group)]
    return sorted(parts, key=lambda part: part.body.name)


def merge_record(before: Inner, after: Inner, joints: Sequence[Meeting], time: float) -> CollisionRecord:
    """The impulses that joints carried, and the energy that merging took."""
    books = Books(impacts=len(joints), rest_energy=kinetic_energy(before.world) - kinetic_energy(after.world))
    return CollisionRecord(*_records(joints, _changes(before, after), before.world, time), books)


def _group_of(inner: Inner, rows: tuple[int, ...]) -> list[Part]:
    """What becomes of bodies that meet: one body, or all stand still where one of them is fixed."""
    group = [inner.part(i) for i in rows]
    if len(group) > 1 and any(isinstance(part.body.motion, Fixed) for part in group):
        nothing = np.zeros(3)
        return [
            Part(replace(body, motion=Fixed()), members, (x, nothing, R, nothing, nothing))
            for body, members, (x, _, R, _, _) in ((part.body, part.members, part.state) for part in group)
        ]
    return group if len(group) == 1 else [_combined(group)]


def _changes(before: Inner, after: Inner) -> Array:
    """How much the momentum of each body of the world before (k,3) has changed by merging [N s]."""
    place = {member.row: (i, member) for i, members in enumerate(after.members) for member in members}
    changes = np.zeros((before.world.body_count, 3))
    _, v, R, _, w = after.world.state.arrays
    for i, members in enumerate(before.members):
        if isinstance(before.world.scene.bodies[i].motion, Free):
            changes[i] = -before.world.mass[i] * before.world.state.velocity[i]
            for j, member in (place[member.row] for member in members):
                changes[i] += member.mass * (v[j] + np.cross(w[j], R[j] @ member.offset))
    return changes


def _combined(group: Sequence[Part]) -> Part:
    """Bodies that are free as one, its axes parallel to the world's."""
    bodies, states = [part.body for part in group], [part.state for part in group]
    mass = sum(body.mass for body in bodies)
    masses = np.array([body.mass for body in bodies])
    x, v, L = (np.array([state[k] for state in states]) for k in (0, 1, 3))
    locked = np.logical_or.reduce([body.motion.locked for body in bodies if isinstance(body.motion, Free)], axis=0)
    centre = masses @ x / mass
    velocity = np.where(locked[:3], 0.0, masses @ v / mass)
    inertia, momentum, vertices, triangles, inside, first = np.zeros((3, 3)), np.zeros(3), [], [], [], 0
    for part, own in zip(group, L, strict=True):
        body, state = part.body, part.state
        R, arm = state[2], state[0] - centre
        inertia += R @ body.inertia @ R.T + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        momentum += own + body.mass * np.cross(arm, state[1] - velocity)
        mesh = body.collision_mesh  # nobody but the queue sees the whole's surface
        vertices.append(mesh.vertices @ R.T + arm)
        triangles.append(mesh.triangles + np.uint32(first))
        inside += [replace(member, offset=R @ member.offset + arm, turn=R @ member.turn) for member in part.members]
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


def _groups(joints: Sequence[Meeting], count: int) -> list[tuple[int, ...]]:
    """Rows that are joined, ascending, and all others alone."""
    group = {i: {i} for i in range(count)}
    for joint in joints:
        both = group[joint.a] | group[joint.b]
        for i in both:
            group[i] = both
    return sorted({tuple(sorted(rows)) for rows in group.values()})


def _records(
    joints: Sequence[Meeting], changes: Array, world: World, time: float
) -> tuple[tuple[Impact, ...], tuple[Contact, ...]]:
    """The impulses that joints carried, given how the momenta (k,3) of the bodies changed.

    A joint passes on what all bodies beyond it got; where joints close a ring, those that close it pass on nothing.
    """
    tree: list[Meeting] = []
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


def _reached(tree: Sequence[Meeting], start: int, without: Meeting | None) -> set[int]:
    """Bodies that are joined to `start` by joints, but for one."""
    found, ways = {start}, [joint for joint in tree if joint is not without]
    grown = True
    while grown:
        more = {i for joint in ways if found & {joint.a, joint.b} for i in (joint.a, joint.b)} - found
        found |= more
        grown = bool(more)
    return found
