"""A hull of 50 000 triangles driven into a field of 100, 1000 and 10 000 floes: wall time, memory, and how they grow.

    python benchmarks/field.py [--seconds 2] [--most 10000] [--json FILE]

Each field in a process of its own, warm, rule `exact`: hexagonal floes (20 triangles) of 1 kg at random places and
headings on a lattice, slowed by a linear drag, e = 0.3, plane motion; the hull goes at 1 m/s; steps of 0.01 s. Of each:
wall time per simulated second, of it while the hull has not met the field yet, the longest step, impacts, bodies that
move at the end, time to make the simulation, and the most memory above that of the imported program.

Target: ten times as many floes cost at most ten times the wall time and ten times the memory. Exit code 1 if missed.
"""

import argparse
import json
import resource
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from scenes_by_hand import scene_of, solid

from comotion_mock_cfd.body_forms import floe_mesh
from comotion_mock_cfd.hull_form import LENGTH, hull_mesh
from comotion_server import Simulation
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import quaternion_of
from comotion_server.scene import Free, Prescribed
from comotion_server.warm_up import warm_up

COUNTS = (100, 1000, 10_000)
HULL = (144, (72, 14))  # stations and waterlines
SPACING, JITTER = 0.31, 0.05  # [m] of the lattice; floes are 0.25 m across
DRAG = 0.5  # [N s/m]
SPEED = 1.0  # [m/s] of the hull
APPROACH = 0.1  # [s] until the hull's bow is where the field begins
STEP = 0.01  # [s]
GROWTH = 10.0  # of time and memory with ten times the floes
PLANE = Free(locked=(False, False, True, True, True, False))


def field(count):
    """The hull before a square of floes."""
    rng, side = np.random.default_rng(0), int(np.ceil(np.sqrt(count)))
    floe, hull = TriangleMesh(*floe_mesh()), TriangleMesh(*hull_mesh(*HULL))
    bodies = [solid("hull", hull, mass=125.0, motion=Prescribed(velocity=np.array([SPEED, 0.0, 0.0])))]
    start = 0.625 * LENGTH + SPEED * APPROACH
    for i in range(count):
        place = SPACING * np.array([i % side, i // side - (side - 1) / 2]) + rng.uniform(0.0, JITTER, 2)
        heading = quaternion_of(np.array([0.0, 0.0, rng.uniform(0.0, np.pi / 3)]))
        bodies.append(
            solid(
                f"floe-{i}",
                floe,
                mass=1.0,
                motion=PLANE,
                position=(start + place[0], place[1], 0.0),
                quaternion=heading,
            )
        )
    return scene_of(*bodies, restitution=0.3), len(hull.triangles)


def memory():
    """The most this process has had [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def run(count, seconds):
    """Figures of one field."""
    scene, triangles = field(count)
    warm_up(scene)
    before, begin = memory(), perf_counter()
    simulation = Simulation(scene)
    made, times, impacts, quiet = perf_counter() - begin, [], 0, 0
    wrenches = np.zeros((count + 1, 6))
    for _ in range(round(seconds / STEP)):
        wrenches[:, :3] = -DRAG * simulation.bodies.velocity
        begin = perf_counter()
        result = simulation.step(STEP, wrenches=wrenches)
        times.append(perf_counter() - begin)
        impacts += result.books.impacts
        quiet += impacts == 0
    moving = int(np.count_nonzero(np.abs(simulation.bodies.velocity).max(axis=1) > 1e-3 * SPEED)) - 1
    return {
        "floes": count,
        "hull_triangles": triangles,
        "wall_per_simulated_second": sum(times) / simulation.time,
        "of_it_before_the_first_impact": float(np.mean(times[1:quiet])) / STEP,
        "longest_step": max(times),
        "impacts": impacts,
        "moving": moving,
        "making": made,
        "memory": memory() - before,
    }


def line(found):
    """A row of the table."""
    wall, before, longest = (
        found[key] for key in ("wall_per_simulated_second", "of_it_before_the_first_impact", "longest_step")
    )
    head = f"{found['floes']:6d} floes  {wall:7.2f} s/s  before {before:6.2f} s/s  longest step {longest:6.3f} s"
    tail = f"{found['impacts']:5d} impacts  {found['moving']:4d} moving"
    return f"{head}  {tail}  made in {found['making']:5.2f} s  {found['memory']:5.0f} MB"


def too_much(tenth, now):
    """What grew faster than the field."""
    growth = {key: now[key] / tenth[key] for key in ("wall_per_simulated_second", "memory")}
    return [
        f"{now['floes']} floes: {times:.1f} times the {key} of a tenth"
        for key, times in growth.items()
        if times > GROWTH
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time of each field (default: 2)")
    parser.add_argument("--most", type=int, default=COUNTS[-1], help="most floes (default: 10000)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here, too")
    asked = parser.parse_args()
    found, missed = [], []
    with ProcessPoolExecutor(1, get_context("spawn"), max_tasks_per_child=1) as processes:
        for count in (count for count in COUNTS if count <= asked.most):
            found.append(processes.submit(run, count, asked.seconds).result())
            print(line(found[-1]), flush=True)
            if len(found) > 1:
                missed += too_much(*found[-2:])
    if asked.json is not None:
        asked.json.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    print("\n".join(missed) or "all targets met")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
