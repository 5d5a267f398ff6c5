"""Distance of two meshes beside coal and python-fcl, in the same run, on one thread; then many bodies.

    python benchmarks/geometry.py [--quick]

Each cell is a pair of shapes at a kind of gap: far (0.2 to 1 m), middle (0.02 to 0.1 m), near (1e-4 to 1e-2 m),
intersecting. It holds 4 poses x 16 coherent frames. All take turns on the same frames, round after round, so that a
noisy machine troubles all alike; the figure of a cell is the least time of its rounds. `cold` knows nothing of the last
frame, `warm` starts from its closest triangles; coal is asked cold, and *seeded* with the distance of the last closest
points in their new places. Ours is one compiled call for all frames; a call of coal costs 1 us from Python. Counts, per
warm query: boxes against nodes, triangles against nodes (eight at a time each), pairs of triangles in full.

Targets are geometric means of (peer's time / our time) over all cells. Exit code 1 if one is missed, or a distance
differs.
"""

import argparse
import sys
import time
from dataclasses import dataclass, field

import geometry_bodies
import numba
import numpy as np
from geometry_peers import Coal, Fcl, coal_model
from geometry_shapes import pairs

from comotion_server.kernels.mesh_pair import closest_points, closest_points_of_pairs, work_space
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.vectors import rotated_back, row, sub
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.meshes.mesh_tree import binary_tree, lane_tree

POSES, FRAMES = 4, 16
GAPS = {"far": (0.2, 1.0), "middle": (0.02, 0.1), "near": (1e-4, 1e-2), "intersecting": (0.0, 0.0)}
STEP = 0.01  # [m] and [rad] from frame to frame
WHO = ("coal", "seeded", "fcl", "cold", "warm")
AGREE = 1e-9  # [m]; the peers' kernels lose digits on edges that are nearly parallel


def turn(axis, angle):
    """The rotation (3, 3) about an axis (3,)."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


@numba.njit
def play(m, shapes, x, R, table, reach, witness, carry, distance, p, q, n):
    """All frames in order; `carry`: from one to the next the closest triangles."""
    for f in range(len(table)):
        if not carry:
            witness[:] = -1
        closest_points_of_pairs(m, shapes, x, R, table[f], reach, witness, distance[f], p[f], q[f], n[f])


@numba.njit
def count(m, shapes, x, R, table, witness, relative, counts):
    """What the walks of some pairs (k, 2) count, given witness triangles (k, 2)."""
    work = work_space()
    for k in range(len(table)):
        a, b = table[k]
        relative_rotation(R[a], R[b], relative)
        t = rotated_back(R[a], sub(row(x, b), row(x, a)))
        i, j = witness[k, 0] + m.triangle_start[shapes[a]], witness[k, 1] + m.triangle_start[shapes[b]]
        closest_points(m, shapes[a], shapes[b], relative, t, np.inf, i, j, work)
    counts[:] = work[-1]


@dataclass
class Ours:
    """Bodies 2 k and 2 k + 1 are the two of query k = frame x POSES + pose."""

    store: MeshStore
    x: np.ndarray = field(default_factory=lambda: np.zeros((2 * POSES * FRAMES, 3)))
    R: np.ndarray = field(default_factory=lambda: np.tile(np.eye(3), (2 * POSES * FRAMES, 1, 1)))

    def __post_init__(self):
        self.shapes = np.tile(self.store.shape_of_mesh, POSES * FRAMES)
        self.table = np.arange(2 * POSES * FRAMES).reshape(FRAMES, POSES, 2)
        self.distance = np.empty((FRAMES, POSES))
        self.p, self.q, self.n = (np.empty((FRAMES, POSES, 3)) for _ in range(3))
        self.reach = np.full(POSES, np.inf)

    def ask(self, query):
        """The distance and the normal of one query."""
        out = np.empty(1), np.empty((1, 3)), np.empty((1, 3)), np.empty((1, 3))
        row, none = np.array([[2 * query, 2 * query + 1]]), np.full((1, 2), -1)
        closest_points_of_pairs(
            self.store.arrays, self.shapes, self.x, self.R, row, self.reach[:1], none, out[0], out[1], out[2], out[3]
        )
        return out[0][0], out[3][0]

    def run(self, *, carry):
        witness = np.full((POSES, 2), -1)
        m, out = self.store.arrays, (self.distance, self.p, self.q, self.n)
        play(m, self.shapes, self.x, self.R, self.table, self.reach, witness, int(carry), *out)

    def counted(self):
        """Per query, warm: see `count`."""
        counts, witness = np.zeros((FRAMES, 3)), np.full((POSES, 2), -1)
        m, out = self.store.arrays, (self.distance, self.p, self.q, self.n)
        for f in range(FRAMES):
            rows = slice(f, f + 1)
            if f > 0:
                count(m, self.shapes, self.x, self.R, self.table[f], witness, np.empty((3, 3)), counts[f])
            play(m, self.shapes, self.x, self.R, self.table[rows], self.reach, witness, 1, *(o[rows] for o in out))
        return counts[1:].mean(axis=0) / POSES

    def seeds(self):
        """Upper bounds [m] of all queries: the last closest points, moved with their bodies."""
        bounds = np.full(POSES * FRAMES, np.finfo(float).max)
        for k in range(POSES, POSES * FRAMES):
            ends, last = [], k - POSES
            for body, point in enumerate((self.p, self.q)):
                i, j = 2 * last + body, 2 * k + body
                own = self.R[i].T @ (point.reshape(-1, 3)[last] - self.x[i])
                ends.append(self.R[j] @ own + self.x[j])
            bounds[k] = np.linalg.norm(ends[0] - ends[1]) + 1e-12
        return bounds


def set_gap(ours, query, gap):
    """Move the second body along the normal until `gap` is left; False where the bodies intersect."""
    distance, normal = ours.ask(query)
    ours.x[2 * query + 1] += normal * (gap - distance)
    return distance > 0.0


def lay_out(ours, kind, rng):
    """Coherent frames of POSES pairs of bodies."""
    low, high = GAPS[kind]
    for pose in range(POSES):
        while True:
            turns = [turn(rng.normal(size=3), rng.uniform(0, np.pi)) for _ in range(2)]
            drift, axis = STEP * rng.normal(size=(FRAMES, 3)) / 2, rng.normal(size=3)
            toward = rng.normal(size=3)
            ours.x[2 * pose], ours.x[2 * pose + 1] = 0.0, 4.0 * toward / np.linalg.norm(toward)
            ours.R[2 * pose], ours.R[2 * pose + 1] = turns
            if kind == "intersecting":
                set_gap(ours, pose, 1e-6)
                ours.x[2 * pose + 1] -= 0.1 * ours.ask(pose)[1]
                good = ours.ask(pose)[0] == 0.0
            else:
                good = set_gap(ours, pose, low * (high / low) ** rng.random())
            for frame in range(1, FRAMES):
                k, last = frame * POSES + pose, (frame - 1) * POSES + pose
                ours.x[2 * k], ours.R[2 * k] = ours.x[2 * last], ours.R[2 * last]
                ours.x[2 * k + 1] = ours.x[2 * last + 1] + (0.1 if kind == "intersecting" else 1.0) * drift[frame]
                ours.R[2 * k + 1] = turn(axis, STEP) @ ours.R[2 * last + 1]
                if kind != "intersecting":
                    good &= set_gap(ours, k, low * (high / low) ** rng.random())
            if good:
                break


def clock(run, *arguments, **options):
    begin = time.perf_counter()
    run(*arguments, **options)
    return time.perf_counter() - begin


def cell(meshes, ours, kind, rounds, rng):
    """The least times [us] per query of everyone on one cell."""
    lay_out(ours, kind, rng)
    queries = [[(ours.R[2 * k + i], ours.x[2 * k + i]) for i in range(2)] for k in range(POSES * FRAMES)]
    peer, old_peer, theirs = Coal(meshes, queries), Fcl(meshes, queries), np.empty(POSES * FRAMES)
    ours.run(carry=False)
    bounds, distance = ours.seeds(), ours.distance.ravel().copy()
    for run in (lambda: peer.run(theirs), lambda: peer.run(theirs, bounds), lambda: old_peer.run(theirs)):
        run()
        assert np.abs(np.maximum(theirs, 0.0) - distance).max() <= AGREE, (kind, np.abs(theirs - distance).max())
    ours.run(carry=True)
    assert np.abs(ours.distance.ravel() - distance).max() <= AGREE
    least = {}
    for _ in range(rounds):
        times = {
            "cold": clock(ours.run, carry=False),
            "coal": clock(peer.run, theirs),
            "warm": clock(ours.run, carry=True),
            "seeded": clock(peer.run, theirs, bounds),
            "fcl": clock(old_peer.run, theirs),
        }
        least = {name: min(spent, least.get(name, np.inf)) for name, spent in times.items()}
    return {name: 1e6 * spent / (POSES * FRAMES) for name, spent in least.items()}


def trees(mesh):
    triangles = mesh.triangles.astype(np.int64)
    lane_tree(mesh.vertices, triangles, binary_tree(mesh.vertices, triangles))


def building(meshes, rounds):
    """Least times [ms] to build a tree: ours and coal's."""
    mesh = meshes[0]
    ours = min(clock(trees, mesh) for _ in range(rounds))
    return 1e3 * ours, 1e3 * min(clock(coal_model, mesh) for _ in range(rounds))


def mean(ratios):
    return float(np.exp(np.mean(np.log(ratios))))


def table(rounds):
    """Print a row per cell; the figures by name."""
    rng = np.random.default_rng(20)
    rows, builds = [], {}
    times = " ".join(f"{who:>8}" for who in WHO)
    print(f"{'pair':<13} {'gap':<12} {times} [us]  coal/cold   /warm seeded/warm  boxes triangles full")
    for name, meshes in pairs().items():
        ours = Ours(MeshStore.build(meshes))
        for kind in GAPS:
            t = cell(meshes, ours, kind, rounds, rng)
            ratios = t["coal"] / t["cold"], t["coal"] / t["warm"], t["seeded"] / t["warm"]
            rows.append((kind, *ratios, t["fcl"] / t["warm"]))
            figures = " ".join(f"{t[who]:8.2f}" for who in WHO)
            factors = "{:13.2f} {:7.2f} {:11.2f}".format(*ratios)
            counts = "{:6.0f} {:9.0f} {:4.0f}".format(*ours.counted())
            print(f"{name:<13} {kind:<12} {figures} {factors} {counts}", flush=True)
        builds[name] = building(meshes, 3 * rounds)
    print(f"\n{'tree of':<13} {'ours':>8} {'coal':>8} [ms]")
    for name, (own, theirs) in builds.items():
        print(f"{name:<13} {own:8.3f} {theirs:8.3f}")
    return rows, builds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few rounds: about a minute")
    rounds = 3 if parser.parse_args().quick else 12
    rows, builds = table(rounds)
    kinds = np.array([row[0] for row in rows])
    cold, warm, seeded, _ = np.array([row[1:] for row in rows]).T
    ratios = {
        "cold / coal": (mean(cold), 2.2),
        "warm / coal": (mean(warm), 5.0),
        "warm / coal, near": (mean(warm[kinds == "near"]), 5.0),
        "warm / coal, intersecting": (mean(warm[kinds == "intersecting"]), 12.0),
        "warm / coal seeded": (mean(seeded), 2.0),
        "least of all cells, cold": (min(cold), 0.8),
        "building / coal": (mean([theirs / own for own, theirs in builds.values()]), 1.0),
    }
    print()
    for kind in GAPS:
        part = kinds == kind
        print(f"{kind:<12} cold {mean(cold[part]):.2f} warm {mean(warm[part]):.2f} seeded {mean(seeded[part]):.2f}")
    results = [(name, ratio, f"at least {target}", ratio >= target) for name, (ratio, target) in ratios.items()]
    results += geometry_bodies.checks(rounds)
    for name, figure, target, holds in results:
        print(f"{name:<26} {figure:6.2f}  ({target}): {'holds' if holds else 'MISSED'}")
    return 0 if all(holds for *_, holds in results) else 1


if __name__ == "__main__":
    sys.exit(main())
