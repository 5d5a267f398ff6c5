"""A world as the event queue takes it: its shapes, its rules of impact, and room for what the queue remembers."""

from math import inf

import numpy as np
from numpy.typing import NDArray

from comotion_server.geometry.contact_time import ROUNDINGS, near_distance
from comotion_server.kernels.event_scene import Queue, Rules, Scene, new_queue
from comotion_server.kernels.impact_cluster import SEQUENTIAL, TOGETHER
from comotion_server.kernels.solids import MESH, PLANE, Solids
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.scene import Body
from comotion_server.scene import Scene as SceneModel
from comotion_server.world import World

PAIRS_PER_BODY = 24  # of room to begin with; more is made where it is needed
CONTACT_ROOM = 4096  # contact points of one cluster to begin with
LOG_ROOM = 4096  # contact points of impacts


def solids_of(bodies: tuple[Body, ...]) -> Solids:
    """The shapes of all bodies."""
    count = len(bodies)
    meshes = [body.shape for body in bodies if isinstance(body.shape, TriangleMesh)]
    store = MeshStore.build(meshes)
    shapes = iter(store.shape_of_mesh)
    kind, shape, normal = np.full(count, MESH), np.full(count, -1), np.zeros((count, 3))
    radius, near = np.full(count, inf), np.full(count, inf)
    for i, body in enumerate(bodies):
        if isinstance(body.shape, TriangleMesh):
            shape[i], radius[i], near[i] = next(shapes), 0.5 * body.shape.size, near_distance(body.shape)
        else:
            kind[i], normal[i] = PLANE, body.shape.normal
    return Solids(store.arrays, kind, shape, normal, radius, near)


def rules_of(scene: SceneModel) -> Rules:
    """Restitution and friction between the materials of a scene, and how contacts are answered."""
    settings, bodies = scene.collisions, scene.bodies
    names = sorted({body.material or "" for body in bodies})
    of_name = {name: next(body for body in bodies if (body.material or "") == name) for name in names}
    pairs = [(of_name[a], of_name[b]) for a in names for b in names]
    shape = (len(names), len(names))
    restitution = np.array([settings.restitution_between(a, b) for a, b in pairs], dtype=np.float64).reshape(shape)
    friction = np.array([settings.friction_between(a, b) for a, b in pairs], dtype=np.float64).reshape(shape)
    sizes = [body.shape.size for body in bodies if isinstance(body.shape, TriangleMesh)]
    return Rules(
        material=np.array([names.index(body.material or "") for body in bodies]),
        restitution=restitution,
        friction=friction,
        law=TOGETHER if settings.simultaneous == "together" else SEQUENTIAL,
        angle=settings.patch_angle if settings.parallel == "patch" else 0.0,
        level=1.5 * settings.patch_angle * max(sizes, default=0.0),
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
    grain = np.full(world.body_count, ROUNDINGS * np.spacing(max(extent, default=1.0)))
    return new_queue(
        world.state.position,
        solids.radius,
        world.scene.collisions.tolerance * 2.0 * solids.radius,
        grain,
        PAIRS_PER_BODY * world.body_count + 100,
        CONTACT_ROOM,
        LOG_ROOM,
    )
