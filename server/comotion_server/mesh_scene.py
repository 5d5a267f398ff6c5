"""What only a scene with meshes needs, or one of round shapes whose kernels are compiled beside those of meshes."""

from collections.abc import Sequence
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.geometry.contact_time import near_distance
from comotion_server.kernels.event_scene import Queue, Scene
from comotion_server.kernels.flat_contact import new_patch_work
from comotion_server.kernels.mesh_arrays import MeshArrays
from comotion_server.kernels.mesh_room import PatchWork, Work
from comotion_server.kernels.pair_window import new_work
from comotion_server.kernels.penetration import overlap_depth
from comotion_server.kernels.solids import PLANE, are_flat
from comotion_server.meshes import TriangleMesh, box
from comotion_server.meshes.mesh_store import MeshStore

Array = NDArray[np.float64]


def stored(meshes: Sequence[TriangleMesh]) -> tuple[MeshArrays, NDArray[np.int64], list[float], list[float]]:
    """All meshes as the kernels take them; of each its number, its radius about the origin and `Solids.near` [m]."""
    store = MeshStore.build(meshes or [box([1.0, 1.0, 1.0])])  # kernels of a mixed scene are compiled for meshes
    numbers = store.shape_of_mesh[: len(meshes)]
    return store.arrays, numbers, [0.5 * mesh.size for mesh in meshes], [near_distance(mesh) for mesh in meshes]


def rooms_for_meshes() -> tuple[Work, PatchWork]:
    """Room for the kernels of contact times and of contact points."""
    return new_work(), new_patch_work()


def way_out(scene: Scene, queue: Queue, k: int, gap: float) -> tuple[Array, float]:
    """The direction (3,) from a to b of pair k, world, along which the bodies overlap least, and how much [m].

    gap: of the pair [m]; its closest triangles are the pair's witness.
    """
    solids, witness = scene.solids, queue.pairs.witness[k]
    a, b = queue.pairs.bodies[k].tolist()
    if not are_flat(solids, a, b):
        from comotion_server.kernels.mixed_impact import round_gap

        work: Any = queue.work  # None only where all bodies are smooth
        depth, normal = round_gap(solids, a, b, scene.x, scene.R, inf, witness, work.walk)
        return np.array(normal), -depth
    for plane, sign in ((a, 1.0), (b, -1.0)):
        if solids.kind[plane] == PLANE:
            return sign * scene.R[plane] @ solids.normal[plane], max(-gap, 0.0)
    m: Any = solids.meshes  # likewise
    i, j = witness.tolist()
    ways = [scene.R[a] @ m.normals[i], -scene.R[b] @ m.normals[j], scene.x[b] - scene.x[a]]
    ways = [way / np.linalg.norm(way) for way in ways if way.any()]
    if gap > 0.0:
        return min(ways, key=lambda way: -abs(float(way @ ways[0]))), -gap
    shapes = solids.shape[a], solids.shape[b]
    poses = scene.x[a], scene.R[a], scene.x[b], scene.R[b]
    depths = [float(overlap_depth(m, *shapes, *poses, way)) for way in ways]
    least = int(np.argmin(depths))
    return ways[least], depths[least]
