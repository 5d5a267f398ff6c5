"""Bodies that touch at the start are moved apart by less than anybody sees; bodies that overlap are refused.

Rule `exact` needs a gap between all bodies. Whoever puts a box on a floor puts it there exactly, or as exactly as a
mesh file can say it, so overlaps up to a millionth of the smaller body are taken as contact.
"""

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.contact_manifold import gap_of_pair
from comotion_server.kernels.event_scene import DELTA, Queue, Scene
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.sphere_impact import are_smooth, smooth_gap
from comotion_server.scene import Problem, SceneError
from comotion_server.world import World

Array = NDArray[np.float64]

SLIGHT = 1e-6  # of the smaller body's size: overlaps that are taken as contact
SWEEPS = 1000  # over all pairs that touch: a column of some thirty bodies comes apart
LEAST = 0.1  # of delta: a gap that is enough; below, the first contact would be where the bodies are
MIDDLE = 0.5  # of delta: the gap that bodies are given
OVERLAP = "overlap at the start; expected a gap, or that they just touch"


def open_gaps(world: World, scene: Scene, queue: Queue) -> None:
    """Moves bodies that touch apart.

    Raises:
        SceneError: bodies overlap, one is inside another, or they touch where neither can give way.
    """
    pairs = queue.pairs.bodies
    rows = [k for k in np.flatnonzero(pairs[:, 0] >= 0).tolist() if scene.bodies.reacts[pairs[k]].any()]
    if scene.solids.meshes is not None:
        from comotion_server.nesting import INSIDE, nested

        solid = [k for k in rows if (scene.solids.kind[pairs[k]] != PLANE).all()]
        for inner, outer in nested(scene.solids.meshes, scene.solids.shape, pairs[solid], scene.x, scene.R):
            raise SceneError([_problem(world, inner, outer, INSIDE)])
    work, touching = queue.patch_work, (0, 0)
    for _ in range(SWEEPS):
        apart = True
        for k in rows:
            a, b = pairs[k].tolist()
            delta = DELTA * float(queue.pairs.tolerance[k])
            gap = gap_of_pair(scene.solids, a, b, scene.x, scene.R, delta, queue.pairs.witness[k], work)
            if gap < LEAST * delta:
                way = _way_out(scene, queue, k, gap)
                _part(world, scene, a, b, way, MIDDLE * delta)
                apart, touching = False, (a, b)
        if apart:
            return
    raise SceneError([_problem(world, *touching, OVERLAP)])


def _problem(world: World, a: int, b: int, words: str) -> Problem:
    return Problem(world.scene.name, None, f'bodies "{world.names[a]}" and "{world.names[b]}"', words)


def _part(world: World, scene: Scene, a: int, b: int, way: tuple[Array, float], wanted: float) -> None:
    """Moves two bodies apart along the direction in which they overlap least."""
    direction, depth = way
    slight = SLIGHT * 2.0 * float(min(scene.solids.radius[[a, b]]))
    free = [np.where(scene.bodies.inverse_mass[i] > 0.0, direction, 0.0) * scene.bodies.reacts[i] for i in (a, b)]
    ease = float((free[0] + free[1]) @ direction)  # whatever their masses: columns come apart in fewer sweeps
    if depth > slight or ease == 0.0:
        raise SceneError([_problem(world, a, b, OVERLAP)])
    scene.x[a] -= (wanted + depth) / ease * free[0]
    scene.x[b] += (wanted + depth) / ease * free[1]


def _way_out(scene: Scene, queue: Queue, k: int, gap: float) -> tuple[Array, float]:
    """The direction (3,) from a to b of pair k, world, along which the bodies overlap least, and how much [m]."""
    solids = scene.solids
    a, b = queue.pairs.bodies[k].tolist()
    if are_smooth(solids, a, b):
        depth, normal = smooth_gap(solids, a, b, tuple(scene.x[a]), tuple(scene.x[b]), scene.R[a], scene.R[b])
        return np.array(normal), -depth
    from comotion_server.mesh_scene import way_out

    return way_out(scene, queue, k, gap)
