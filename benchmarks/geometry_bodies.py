"""Many bodies: the broad phase, pairs on two threads, and what distant bodies cost a step."""

import time

import numpy as np
from geometry_shapes import ball, rod, torus

from comotion_server.kernels.broad_phase import pairs_in_reach
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.pair_threads import PairThreads
from comotion_server.scene import Body, Collisions, Free, Scene
from comotion_server.simulation import Simulation

FILLED = 0.2  # of space, by bodies that do not mind overlaps
NEAR, DISTANT = 200, (200, 2000)
DT = 0.01  # [s]
STEPS = 25  # while the jam lasts


def clock(run, *arguments):
    begin = time.perf_counter()
    run(*arguments)
    return time.perf_counter() - begin


def broad_phase(rounds):
    """Least times [ms] for 1000, 10 000 and 100 000 spheres that reach for 5 % of their radius; and for two kinds."""
    rng, least = np.random.default_rng(1), {}
    for name, count, sizes in (("1000", 1000, 1), ("10000", 10**4, 1), ("100000", 10**5, 1), ("two sizes", 10**5, 4)):
        radius = np.where(np.arange(count) % 50, 0.5, 0.5 * sizes)
        side = ((4 / 3 * np.pi * radius**3).sum() / FILLED) ** (1 / 3)
        x, pairs = rng.uniform(0, side, (count, 3)), np.empty((8 * count, 2), np.int64)
        arguments = x, radius, 0.05 * radius, np.ones(count, bool), pairs
        least[name] = 1e3 * min(clock(pairs_in_reach, *arguments) for _ in range(5 * rounds))
        found = pairs_in_reach(*arguments)
        print(f"broad phase, {name:>9}: {least[name]:8.3f} ms, {found} pairs")
    return least


def two_threads(rounds):
    """Time on one thread / time on two, of some hundred pairs of unlike bodies; and whether the bits agree."""
    rng = np.random.default_rng(2)
    store = MeshStore.build([ball(4, 0.05), torus(48, 24), rod(32)])
    count = 40
    x, R = 2.5 * rng.normal(size=(count, 3)), np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    R[np.linalg.det(R) < 0] *= -1
    pairs = np.array([(i, j) for i in range(count) for j in range(i + 1, count)])
    rows, reach = np.arange(len(pairs)), np.full(len(pairs), np.inf)
    least, bits, threads = {}, {}, {number: PairThreads(number) for number in (1, 2)}
    for _ in range(2 * rounds):
        for number, workers in threads.items():
            k = len(pairs)
            out = np.full((k, 2), -1), np.empty(k), np.empty((k, 3)), np.empty((k, 3)), np.empty((k, 3))
            shapes = np.arange(count) % 3
            spent = clock(workers.closest_points, rows, store.arrays, shapes, x, R, pairs, reach, *out)
            least[number], bits[number] = min(spent, least.get(number, np.inf)), [array.tobytes() for array in out]
    print(f"{len(pairs)} pairs: {1e3 * least[1]:.2f} ms on one thread, {1e3 * least[2]:.2f} ms on two")
    return least[1] / least[2], bits[1] == bits[2]


def stones(distant):
    """A jam of NEAR stones on the move, and `distant` ones beside it that lie close together and hardly move."""
    rng, shape = np.random.default_rng(3), ball(2, 0.05)
    stone = TriangleMesh(0.2 * shape.vertices, shape.triangles)
    bodies = []
    for i in range(NEAR + distant):
        near = i < NEAR
        row, wide = (i, 10) if near else (i - NEAR, 50)
        at = [0.46 * (row % wide) + (0 if near else 10), 0.46 * (row // wide), 0.0]
        velocity = (0.5 if near else 1e-3) * rng.normal(size=3)
        bodies.append(
            Body(
                f"stone{i:05d}", "stones", Free(), 1.0, 0.016 * np.eye(3), stone, np.array(at),
                velocity=velocity, angular_velocity=2.0 * velocity,
            )
        )  # fmt: skip
    collisions = Collisions(rule="paper", restitution=0.5)
    return Simulation(Scene("stones", np.zeros(3), 1.0, DT, collisions, tuple(bodies)))


def distant_bodies():
    """Time of a step with ten times more distant bodies / without; [ms] each."""
    simulations, spent = [stones(count) for count in DISTANT], ([], [])
    for _ in range(STEPS):
        for simulation, times in zip(simulations, spent, strict=True):
            times.append(clock(simulation.step, DT))
    few, many = (1e3 * float(np.median(times[5:])) for times in spent)
    print(
        f"{NEAR} stones on the move: {few:.2f} ms a step with {DISTANT[0]} distant ones, {many:.2f} with {DISTANT[1]}"
    )
    return many / few


def checks(rounds):
    """(name, figure, target, whether it holds) of all."""
    least = broad_phase(rounds)
    ratio = least["100000"] / least["10000"]
    yield "100 000 bodies [ms]", least["100000"], "at most 10", least["100000"] <= 10.0
    yield "100 000 to 10 000", ratio, "at most 13", ratio <= 13.0
    ratio, same = two_threads(rounds)
    yield "two threads / one", ratio, "at least 1.6, same bits", ratio >= 1.6 and same
    ratio = distant_bodies()
    yield "ten times more distant", ratio, "at most 1.5", ratio <= 1.5
