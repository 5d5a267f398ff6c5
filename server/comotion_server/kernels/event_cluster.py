"""Which bodies an impact concerns: those in contact with the ones that hit, joined through bodies that react."""

import numpy as np

from comotion_server.kernels.event_scene import BODIES, DELTA, PAIRS
from comotion_server.kernels.flight import fly, motion_of
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.pair_memory import partner
from comotion_server.kernels.solid_impact import gap_within
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.vectors import dot, length, row, sub

NEAR = 0.1  # of the smaller body's radius: what is farther apart is not looked at ahead of time


@lean_jit
def _spheres_apart(scene, i, j, time, delta):
    """Whether the spheres about two meshes are more than delta [m] apart."""
    solids = scene.solids
    if solids.kind[i] == PLANE or solids.kind[j] == PLANE:
        return False
    D = sub(motion_of(scene.flights, i, time)[0], motion_of(scene.flights, j, time)[0])
    far = solids.radius[i] + solids.radius[j] + delta
    return dot(D, D) > far * far


@lean_jit
def place_body(scene, i, time):
    """Fly body i to a time; its state is then in the scene's arrays."""
    fly(scene.flights, scene.bodies, i, time, scene.x[i], scene.v[i], scene.R[i], scene.L[i], scene.w[i])


@lean_jit
def _include(queue, scene, i, time):
    """Body i belongs to the cluster."""
    cluster = queue.cluster
    if cluster.body_tick[i] != cluster.tick[0]:
        cluster.body_tick[i] = cluster.tick[0]
        cluster.bodies[cluster.size[BODIES]] = i
        cluster.size[BODIES] += 1
        place_body(scene, i, time)


@lean_jit
def reach_of(queue, scene, k, ahead):
    """Up to which gap [m] the bodies of pair k, placed, count: DELTA tolerances, and what `ahead` [s] closes."""
    closing, radius = 0.0, scene.solids.radius
    a, b = queue.pairs.bodies[k, 0], queue.pairs.bodies[k, 1]
    if ahead > 0.0:
        for i in (a, b):
            spin = length(row(scene.w, i))
            closing += ahead * (length(row(scene.v, i)) + (radius[i] * spin if spin > 0.0 else 0.0))
    return DELTA * queue.pairs.tolerance[k] + min(closing, NEAR * min(radius[a], radius[b]))


@lean_jit
def touches(queue, scene, k, i, j, time, ahead):
    """Whether the bodies i, in the cluster already, and j of pair k touch at a time, or may so within `ahead` [s]."""
    pairs = queue.pairs
    if ahead == 0.0 and _spheres_apart(scene, i, j, time, DELTA * pairs.tolerance[k]):
        return False
    if queue.cluster.body_tick[j] != queue.cluster.tick[0]:
        place_body(scene, j, time)
    a, b, reach = pairs.bodies[k, 0], pairs.bodies[k, 1], reach_of(queue, scene, k, ahead)
    return gap_within(scene.solids, a, b, scene.x, scene.R, reach, pairs.memory[k], pairs.witness[k], queue.work)


@lean_jit
def _begin(cluster):
    """A new cluster, empty."""
    cluster.size[:] = 0
    cluster.tick[0] += 1


@lean_jit
def _grow(queue, scene, time, ahead):
    """Include all that touch the bodies of the cluster, and so on."""
    cluster, pairs = queue.cluster, queue.pairs
    tick, done = cluster.tick[0], 0
    while done < cluster.size[BODIES]:
        i = cluster.bodies[done]
        done += 1
        link = pairs.first[i] if scene.bodies.reacts[i] else -1
        while link >= 0:
            k, j = link >> 1, partner(pairs, link)
            if cluster.pair_tick[k] != tick:
                cluster.pair_tick[k] = tick
                if touches(queue, scene, k, i, j, time, ahead):
                    cluster.pairs[cluster.size[PAIRS]] = k
                    cluster.size[PAIRS] += 1
                    _include(queue, scene, j, time)
            link = pairs.next[link]
    _sort_pairs(cluster, pairs)


@lean_jit
def gather(queue, scene, seed, time):
    """The cluster of the pair in row `seed` at a time, to `queue.cluster`; its bodies' states are those at that time.

    Two bodies are in contact when their gap is at most DELTA tolerances; contacts join through bodies that react.
    """
    cluster, pairs = queue.cluster, queue.pairs
    _begin(cluster)
    cluster.pairs[0], cluster.size[PAIRS] = seed, 1
    cluster.pair_tick[seed] = cluster.tick[0]
    _include(queue, scene, pairs.bodies[seed, 0], time)
    _include(queue, scene, pairs.bodies[seed, 1], time)
    _grow(queue, scene, time, 0.0)


@lean_jit
def gather_about(queue, scene, seeds, time, ahead):
    """The clusters of the bodies in `seeds` (k,), all as one, likewise; of bodies that may touch within `ahead` [s]."""
    _begin(queue.cluster)
    for i in seeds:
        _include(queue, scene, i, time)
    _grow(queue, scene, time, ahead)


@lean_jit
def reaches(queue, scene, ahead, reach):
    """Up to which gap reach (p,) [m] the bodies of each pair of the cluster are in contact, as in `gather_about`."""
    for p in range(queue.cluster.size[PAIRS]):
        reach[p] = reach_of(queue, scene, queue.cluster.pairs[p], ahead)


@jit
def _sort_pairs(cluster, pairs):
    """Pairs in the order of their bodies, so that nothing depends on where their rows are."""
    count = cluster.size[PAIRS]
    if count < 2:
        return
    rows, keys = cluster.pairs[:count].copy(), np.empty(count, np.int64)
    for k in range(count):
        keys[k] = pairs.bodies[rows[k], 0] * len(pairs.first) + pairs.bodies[rows[k], 1]
    cluster.pairs[:count] = rows[np.argsort(keys)]
