"""Impacts per second of the event queue: non-convex bodies, and prisms in a box from 100 to 10 000 of them.

    python benchmarks/events.py [--impacts 2000] [--most 10000] [--only NAME]

Single thread, warm. Of each scene: impacts per second, what one impact costs in distance queries, windows, triangle
pairs in reach and their steps, the error of the energy at e = 1, and the largest error of the books of the impacts. Of
prisms also the part of the time that heap and rooms take, from the number of their operations and their cost.

Targets: 1000 impacts per second among 1000 prisms; ten times as many prisms cost at most 1.5 times as much per impact;
heap and rooms at most 5 % of the time. Exit code 1 if one is missed.
"""

import argparse
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from event_scenes import PLENTY, Part, Play
from tumbling_scenes import SCENES

from comotion_server.kernels.event_heap import put
from comotion_server.kernels.event_queue import SPENT, look_around
from comotion_server.kernels.event_scene import ASKED, HITS, ITEMS, LEFT, LONGEST_RUN, ROOMS
from comotion_server.kernels.jit import jit
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mass import mass_properties

WARM = 0.3  # of the impacts, before the clock starts
FOREVER = 1e9  # [s]
LEAST_RATE = 1000.0  # impacts per second among 1000 prisms
GROWTH = 1.5  # of the cost of an impact among ten times as many prisms
SHARE = 0.05  # of the time, that heap and rooms may take


def prism(corners, radius=0.5, height=0.6):
    """An upright prism over a regular polygon, 4 triangles to a corner."""
    angle = 2 * np.pi * np.arange(corners) / corners
    ring = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    vertices = [np.column_stack([ring, np.full(corners, z)]) for z in (-height / 2, height / 2)]
    vertices.append([[0, 0, -height / 2], [0, 0, height / 2]])
    triangles = []
    for i in range(corners):
        j = (i + 1) % corners
        triangles += [[i, j, corners + j], [i, corners + j, corners + i]]
        triangles += [[2 * corners, j, i], [2 * corners + 1, corners + i, corners + j]]
    return TriangleMesh(np.vstack(vertices), np.array(triangles))


def prisms(count, concentration, corners=12):
    """Upright prisms on a lattice at a concentration by volume, with random velocities and spins, in six planes."""
    rng, shape = np.random.default_rng(1), prism(corners)
    side = int(np.ceil(count ** (1 / 3)))
    cell = (mass_properties(shape.vertices, shape.triangles).volume / concentration) ** (1 / 3)
    places = np.stack(np.meshgrid(*3 * [np.arange(float(side))]), axis=-1).reshape(-1, 3)[:count] - (side - 1) / 2
    parts = [Part(shape, cell * x, rng.normal(size=3), rng.normal(size=3)) for x in places]
    wall = 0.5 * side * cell + 0.1
    return parts + [Part(tuple(-n), n * wall) for axis in np.eye(3) for n in (axis, -axis)]


@jit
def repeat_put(heap, time, times):
    """As many moves of the items of a heap."""
    for k in range(times):
        item = heap.item[(k * 7919) % heap.size[0]]
        put(heap, item, time + (k % 101), k)


@jit
def repeat_look(queue, scene, count):
    """As many searches for neighbours."""
    for i in range(count):
        look_around(queue, scene, i, queue.now[0])


def seconds(call, *arguments):
    call(*arguments)
    begin = perf_counter()
    call(*arguments)
    return perf_counter() - begin


def run(name, parts, impacts, **given):
    """Prints a line; impacts per second, and the part of the time that heap and rooms take."""
    play = Play(parts, **given)
    play.begin()
    energy, queue = play.energy(), play.queue
    queue.tally[LEFT] = max(int(WARM * impacts), 1)
    play.play(FOREVER)
    tally, counts = queue.tally.copy(), queue.counts.copy()
    queue.tally[LEFT] = impacts
    begin = perf_counter()
    code = play.play(FOREVER)
    spent = perf_counter() - begin
    done = queue.tally[HITS] - tally[HITS]
    asked, rooms, items = (queue.tally[k] - tally[k] for k in (ASKED, ROOMS, ITEMS))
    cost = (queue.counts - counts)[:4] / done
    error = abs(play.energy() / energy - 1.0)
    queue.tally[LEFT] = PLENTY
    line = f"{name:28s} {done / spent:8.0f} /s  {cost[0]:5.1f} {cost[1]:5.1f} {cost[2]:6.1f} {cost[3]:6.1f}"
    line += f"  dE {error:.0e} books {queue.log.books.max():.0e} run {queue.tally[LONGEST_RUN]}"
    moving = looking = 0.0
    if len(parts) > 99:
        moves = (
            items + asked + 2 * done * 12
        )  # every item once more when it comes up, and those of both bodies at a hit
        moving = seconds(repeat_put, queue.heap, queue.now[0], 100_000) / 100_000 * moves
        looking = seconds(repeat_look, queue, play.scene, len(parts)) / len(parts) * rooms
        line += f"  heap {moving / spent:.1%} rooms {looking / spent:.1%}"
    print(line if code == SPENT else f"{line}  ended with code {code}", flush=True)
    return done / spent, (moving + looking) / spent


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--impacts", type=int, default=2000)
    parser.add_argument("--most", type=int, default=10_000)
    parser.add_argument("--only", default="")
    asked = parser.parse_args()
    print(f"{'':28s} {'impacts':>11s}  per impact: queries, windows, pairs, steps")
    for name, make in SCENES.items():
        if asked.only in name:
            parts, given = make()
            run(name, parts, asked.impacts, **given)
    for corners, facets in ((5, 20), (25, 100)):
        name = f"1000 prisms, {facets} facets, .35"
        if asked.only in name:
            run(name, prisms(1000, 0.35, corners), 5000)
    missed = []
    for concentration in (0.35, 0.2):
        before = 0.0
        for count in (100, 1000, 10_000):
            name = f"{count} prisms, 48 facets, {concentration}"
            if asked.only not in name or count > asked.most:
                continue
            rate, share = run(name, prisms(count, concentration), max(2000, 3 * count))
            if rate < LEAST_RATE and count == 1000:
                missed.append(f"{name}: {rate:.0f} impacts per second of {LEAST_RATE}")
            if before > GROWTH * rate:
                missed.append(f"{name}: {before / rate:.2f} times the cost of a tenth of the prisms")
            if share > SHARE:
                missed.append(f"{name}: heap and rooms take {share:.1%}")
            before = rate
    print("\n".join(missed) or "all targets met")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
