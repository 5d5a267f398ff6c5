"""A world as the event queue takes it: its shapes, its rules of impact, and room for what the queue remembers."""

from collections.abc import Sequence
from math import inf

import numpy as np

from comotion_server.kernels.event_scene import Queue, Rules, Scene, new_queue
from comotion_server.kernels.impact_cluster import SEQUENTIAL, TOGETHER
from comotion_server.kernels.impact_query import ROUNDINGS
from comotion_server.kernels.solids import CAPSULE, CYLINDER, MESH, PIPE, PLANE, RADIUS, SPHERE, Solids
from comotion_server.meshes import TriangleMesh
from comotion_server.scene import Capsule, Curved, Cylinder, Pipe, Plane, Sphere
from comotion_server.scene import Scene as SceneModel
from comotion_server.world import World

PAIRS_PER_BODY = 24  # of room to begin with; more is made where it is needed
CONTACT_ROOM = 4096  # contact points of one cluster to begin with
LOG_ROOM = 4096  # contact points of impacts


Shape = TriangleMesh | Plane | Curved


def solids_of(shapes: Sequence[Shape]) -> Solids:
    """The shapes of all bodies.

    Raises:
        TypeError: there are shapes that do not meet in this version.
    """
    count = len(shapes)
    meshes = {i: shape for i, shape in enumerate(shapes) if isinstance(shape, TriangleMesh)}
    curved = [shape for shape in shapes if isinstance(shape, Curved)]
    by_steps = bool(meshes) or any(isinstance(shape, Capsule | Cylinder) for shape in curved)
    if by_steps and any(isinstance(shape, Pipe) for shape in curved):
        raise TypeError("pipes meet neither meshes, capsules nor cylinders in this version")
    mixed = by_steps and bool(curved)
    core = np.zeros(count) if mixed else None
    kind, number, normal = np.full(count, MESH), np.full(count, -1), np.zeros((count, 3))
    radius, near = np.full(count, inf), np.full(count, inf)
    size, axis = np.zeros((count, 4)), np.zeros((count, 3))
    arrays = None
    if meshes or mixed:
        from comotion_server.mesh_scene import stored

        rows = list(meshes)
        arrays, number[rows], radius[rows], near[rows] = stored(list(meshes.values()))
    for i, shape in enumerate(shapes):
        if isinstance(shape, Plane):
            kind[i], normal[i] = PLANE, shape.normal
        elif isinstance(shape, Sphere):
            kind[i], radius[i], size[i, RADIUS] = SPHERE, shape.radius, shape.radius
        elif isinstance(shape, Capsule) and core is not None:
            core[i] = 0.5 * shape.length
            kind[i], radius[i], size[i, :2] = CAPSULE, shape.radius + core[i], (shape.radius, core[i])
            axis[i, shape.axis] = 1.0
        elif isinstance(shape, Cylinder) and core is not None:
            kind[i], radius[i], core[i] = CYLINDER, shape.radius_about_centre, shape.radius_about_centre
            size[i, :2], axis[i, shape.axis] = (shape.radius, 0.5 * shape.length), 1.0
        elif isinstance(shape, Pipe):
            half = 0.5 * shape.length
            kind[i], radius[i], axis[i, shape.axis] = PIPE, np.hypot(shape.outer_radius, half), 1.0
            size[i] = shape.inner_radius, shape.outer_radius, half, shape.caps
        elif not isinstance(shape, TriangleMesh):
            raise TypeError(f"a {shape.kind} collides with nothing in this version")
    cylinders = np.ones(1, dtype=bool) if (kind == CYLINDER).any() else None
    return Solids(arrays, kind, number, normal, radius, near, size, axis, core, cylinders)


def rules_of(scene: SceneModel) -> Rules:
    """Restitution and friction between the materials of a scene, and how contacts are answered."""
    settings, bodies = scene.collisions, scene.bodies
    names = sorted({body.material or "" for body in bodies})
    of_name = {name: next(body for body in bodies if (body.material or "") == name) for name in names}
    pairs = [(of_name[a], of_name[b]) for a in names for b in names]
    shape = (len(names), len(names))
    restitution = np.array([settings.restitution_between(a, b) for a, b in pairs], dtype=np.float64).reshape(shape)
    friction = np.array([settings.friction_between(a, b) for a, b in pairs], dtype=np.float64).reshape(shape)
    return Rules(
        material=np.array([names.index(body.material or "") for body in bodies]),
        restitution=restitution,
        friction=friction,
        law=TOGETHER if settings.simultaneous == "together" else SEQUENTIAL,
        angle=settings.patch_angle if settings.parallel == "patch" else 0.0,
        duration=0.0,
        resting=True,
        merging=settings.merge,
    )


def scene_of(world: World, solids: Solids) -> Scene:
    """The bodies of a world with their states, which are the same arrays."""
    return Scene(world.bodies, solids, world.flights, *world.state.arrays)


def queue_of(world: World, solids: Solids) -> Queue:
    """A queue that knows no pairs yet."""
    finite = np.isfinite(solids.radius)
    extent = np.abs(world.state.position[finite]).max(axis=1, initial=0.0) + solids.radius[finite]
    work, patch_work = None, None
    if solids.meshes is not None:
        from comotion_server.mesh_scene import rooms_for_meshes

        work, patch_work = rooms_for_meshes()
    grain = np.full(world.body_count, ROUNDINGS * np.spacing(max(extent, default=1.0)))
    queue: Queue = new_queue(
        world.state.position,
        solids.radius,
        world.scene.collisions.tolerance * 2.0 * solids.radius,
        grain,
        PAIRS_PER_BODY * world.body_count + 100,
        CONTACT_ROOM,
        LOG_ROOM,
        work,
        patch_work,
    )
    return queue
