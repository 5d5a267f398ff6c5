"""Bodies that are pinched are scaled down until they are free (P15, P16): wear and crushing.

Which one: the lightest that may be scaled, of those whose contacts exclude each other; of bodies of one mass the first
by name. By how much: twice the overlap is to be cleared, along the normal n of a contact at p, so
s = 1 - 2 depth / (n . (p - c)), c the centre of mass. Mass scales as s^3, inertia as s^5; the body keeps its velocity
and its angular velocity, so momentum and energy go with the mass that wears off, and are booked.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from comotion_server.inner_world import Inner, Part, kinetic_energy
from comotion_server.meetings import Meeting
from comotion_server.meshes import TriangleMesh
from comotion_server.results import Wear
from comotion_server.scene import Body, Collisions, Free
from comotion_server.world import World

Array = NDArray[np.float64]

MARGIN = 2.0  # times the overlap that is cleared (P16)


def candidates(inner: Inner, pinches: Sequence[Meeting]) -> list[int]:
    """The bodies that may be scaled to end a pinch, in the order in which they are tried."""
    rows = {i for pinch in pinches for i in (pinch.a, pinch.b)}
    bodies = inner.world.scene.bodies
    free = [i for i in rows if isinstance(motion := bodies[i].motion, Free) and motion.reacts and bodies[i].scalable]
    return sorted(free, key=lambda i: (bodies[i].mass, i))


def depth_of(pinches: Sequence[Meeting], seconds: float, least: float) -> float:
    """The overlap to be cleared [m]: the one there is, or the one that given motion would cause in the time left."""
    closing: dict[tuple[int, int], float] = {}
    for pinch in pinches:
        pair = pinch.a, pinch.b
        closing[pair] = max(closing.get(pair, 0.0), pinch.approach)
    ahead = seconds * sum(closing.values())
    return max(least, ahead, *(pinch.depth for pinch in pinches))


def shrunk(inner: Inner, i: int, pinches: Sequence[Meeting], depth: float, settings: Collisions) -> Part | None:
    """Body i, scaled to clear twice the depth [m]; None where it would be scaled below the least scale."""
    part = inner.part(i)
    x, v, R, L, w = part.state
    heights = [
        pinch.normal @ (pinch.point - x) * (1.0 if pinch.a == i else -1.0)
        for pinch in pinches
        if i in (pinch.a, pinch.b)
    ]
    height = float(max(heights))
    if not height > MARGIN * depth:
        return None
    s = 1.0 - MARGIN * depth / height
    wears = settings.heal == "wear"
    lighter, easier = (s**3, s**5) if wears else (1.0, 1.0)
    members = tuple(
        replace(
            member,
            offset=s * member.offset,
            scale=s * member.scale,
            mass=lighter * member.mass,
            inertia=easier * member.inertia if member.inertia is not None else None,
        )
        for member in part.members
    )
    if min(member.scale for member in members) < settings.scale_min:
        return None
    return Part(_scaled(part.body, s, lighter, easier), members, (x, v, R, easier * L, w))


def _scaled(body: Body, s: float, lighter: float, easier: float) -> Body:
    shape, frame = _smaller(body.mesh, s), None if body.frame is None else _smaller(body.frame, s)
    return replace(body, shape=shape, frame=frame, mass=lighter * body.mass, inertia=easier * body.inertia)


def _smaller(mesh: TriangleMesh, s: float) -> TriangleMesh:
    return TriangleMesh(s * mesh.vertices, mesh.triangles)


def wear_of(before: World, after: World, i: int, scale: float, depth: float, time: float) -> Wear:
    """What body i lost by being scaled."""
    v = before.state.velocity[i]
    mass = float(before.mass[i] - after.mass[i])
    turning = before.state.momentum[i] - after.state.momentum[i]
    momentum = mass * v
    return Wear(
        time=time,
        body=before.names[i],
        scale=scale,
        depth=depth,
        mass=mass,
        momentum=momentum,
        angular_momentum=turning + np.cross(before.state.position[i], momentum),
        energy=kinetic_energy(before) - kinetic_energy(after),
    )
