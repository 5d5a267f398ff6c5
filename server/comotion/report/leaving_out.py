"""What the shipped scenes leave out and why, what that saves, and what it changes: nothing.

Forced on: what a scene can be made to run though it does not need it. Healing where nothing is pinched; merging where
restitution is above 0; collisions of a lone body, by a fixed box far away. Both runs take the same steps in turns.
"""

import json
import subprocess
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from comotion.report.findings import Findings, Table
from comotion.report.scenes import CUBE, G, brick, simulation, wall
from comotion.report.study import Progress
from comotion.report.timing import timed

if TYPE_CHECKING:
    from comotion_server.scene import Scene

PATIENCE = 5.0  # [s] of wall time for the steps of one scene
STEPS = 200
FAR = 1e4  # [m]
TARGET = 50.0  # [us] a step of a lone floating body

START = """
import json, resource, sys, time
begin = time.perf_counter()
from comotion_server.simulation import Simulation
imported = time.perf_counter()
sim = Simulation.load(sys.argv[1])
built = time.perf_counter()
sim.step(1e-4)
stepped = time.perf_counter()
kernels = sum(name.startswith("comotion_server.kernels.") for name in sys.modules)
heavy = [name for name in ("trimesh", "scipy", "zenoh", "pydantic") if name in sys.modules]
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(json.dumps([imported - begin, built - imported, stepped - built, kernels, ", ".join(heavy), peak]))
"""


def study(*, quick: bool, say: Progress) -> Findings:
    """Plans, times, start-up, and where a lone body's step spends its time."""
    from comotion_mock_cfd import scenes
    from comotion_server.plan import Plan
    from comotion_server.scene import load_scene

    names = ("float_box", "bounce") if quick else tuple(scenes.names())
    plans, costs, starts = [], [], []
    for name in names:
        say(name)
        path = scenes.path_of(name)
        scene = load_scene(path)
        plans += [[name, line.stage, line.kept, line.reason] for line in Plan(scene).explain()]
        costs.append([name, *_both(scene, 20 if quick else STEPS)])
        starts.append([name, *_start(str(path))])
    tables = [
        Table("Stages in and out", ["scene", "stage", "runs", "reason"], plans),
        Table(
            "As planned and with more forced on (no fluid)",
            ["scene", "steps", "us a step", "forced on", "us a step, forced", "largest difference of positions [m]"],
            costs,
        ),
        Table(
            "Start-up in a fresh process, kernels in the cache",
            [
                "scene",
                "import [s]",
                "build [s]",
                "first step [s]",
                "kernel modules",
                "also imported",
                "peak memory [MB]",
            ],
            starts,
        ),
        *_lone_body(say),
    ]
    return Findings(tables=tables)


def _forced(scene: "Scene") -> tuple["Scene", list[str]]:
    """The scene with what it does not need."""
    given, words = scene.collisions, []
    bodies = scene.bodies
    if len(bodies) < 2:
        bodies = tuple(sorted((*bodies, wall("far-away", CUBE, (FAR, 0, 0))), key=lambda body: body.name))
        words.append("collisions")
    if given.rule == "exact" and given.heal == "off" and not scene.name.startswith(("jam", "blockage")):
        given = replace(given, heal="wear")
        words.append("healing")
    if given.rule == "exact" and not given.merge and given.restitution > 0.0 and not given.material_pairs:
        given = replace(given, merge=True)
        words.append("merging")
    return replace(scene, collisions=given, bodies=bodies), words


def _both(scene: "Scene", steps: int) -> list[Any]:
    from time import perf_counter

    from comotion_server.simulation import Simulation

    other, words = _forced(scene)
    planned = Simulation(scene)
    try:
        forced = Simulation(other)
        forced.step(scene.dt)
    except Exception as error:  # noqa: BLE001 - some scene may refuse it, and the table says so
        forced, words = None, [f"refused: {error}"]
    planned.step(scene.dt)
    spent: list[list[float]] = [[], []]
    done = 1
    while done < steps and sum(map(sum, spent)) < PATIENCE:
        for k, sim in enumerate(filter(None, (planned, forced))):
            begin = perf_counter()
            sim.step(scene.dt)
            spent[k].append(perf_counter() - begin)
        done += 1
    first = 1e6 * float(np.median(spent[0]))
    if forced is None:
        return [done, first, words[0], None, None]
    rows = [forced.bodies.names.index(name) for name in planned.bodies.names]
    difference = float(np.abs(forced.bodies.position[rows] - planned.bodies.position).max())
    return [done, first, ", ".join(words) or "nothing", 1e6 * float(np.median(spent[1])), difference]


def _start(path: str) -> list[Any]:
    run = subprocess.run([sys.executable, "-c", START, path], capture_output=True, text=True, check=True)
    found: list[Any] = json.loads(run.stdout.splitlines()[-1])
    return found


def _lone_body(say: Progress) -> list[Table]:
    """The cost of a step of one floating body, and where it goes."""
    import cProfile
    import pstats

    say("a lone body")
    sim = simulation(brick("box", (0.4, 0.4, 0.2), 16.0), gravity=G)
    force = {"box": np.zeros((8, 3))}
    force["box"][:, 2] = 16.0 * G / 8
    rows = []
    for name, given in (
        ("no forces", {}),
        ("wrench", {"wrenches": np.zeros((1, 6))}),
        ("nodal forces", {"forces": force}),
    ):
        sim.step(1e-3, **given)
        spent, _ = timed(lambda: [sim.step(1e-3, **given) for _ in range(200)])  # noqa: B023
        rows.append([name, 1e6 * spent / 200, 1e6 * spent / 200 <= TARGET])
    profile = cProfile.Profile()
    profile.enable()
    for _ in range(1000):
        sim.step(1e-3, force)
    profile.disable()
    stats = sorted(pstats.Stats(profile).stats.items(), key=lambda item: -item[1][2])[:12]  # type: ignore[attr-defined]
    total = sum(entry[2] for entry in pstats.Stats(profile).stats.values())  # type: ignore[attr-defined]
    where = [[f"{key[2]} ({key[0].rsplit('/', 1)[-1]})", entry[0] / 1000, entry[2] / total] for key, entry in stats]
    return [
        Table("A lone floating body", ["input", "us a step", f"at most {TARGET:g}"], rows),
        Table("Where its step goes (profiled)", ["function", "calls a step", "share of time"], where),
    ]
