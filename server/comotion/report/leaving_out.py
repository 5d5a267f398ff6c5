"""What the shipped scenes leave out and why, what that saves, and what it changes: nothing.

Forced on: what a scene can be made to run though it does not need it. Healing where nothing is pinched; merging where
restitution is above 0; collisions of a lone body, by a fixed box far away. Each alone, and all that a scene can have
together; both runs take the same steps in turns.
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
from comotion.report.timing import timed, timed_from

if TYPE_CHECKING:
    from comotion_server.scene import Scene

Row = list[Any]  # of a table

PATIENCE = 2.0  # [s] of wall time for the steps of one scene
STEPS = 200
FAR = 1e4  # [m]
TARGET = 50.0  # [us] a step of a lone floating body

PEAK_OF_SELF = """
def peak():
    # not ru_maxrss, which a process takes over from the one that started it
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024
"""

START = """
import json, sys, time
begin = time.perf_counter()
from comotion_server.simulation import Simulation
imported = time.perf_counter()
sim = Simulation.load(sys.argv[1])
built = time.perf_counter()
sim.step(1e-4)
stepped = time.perf_counter()
kernels = sum(name.startswith("comotion_server.kernels.") for name in sys.modules)
heavy = [name for name in ("trimesh", "scipy", "zenoh", "pydantic") if name in sys.modules]
print(json.dumps([imported - begin, built - imported, stepped - built, kernels, ", ".join(heavy), peak()]))
"""

PEAK = """
import sys
from comotion.report.leaving_out import forced
from comotion_server.scene import load_scene
from comotion_server.simulation import Simulation
scene = load_scene(sys.argv[1])
sim = Simulation(forced(scene)[sys.argv[2]] if sys.argv[2] else scene)
for _ in range(3):
    sim.step(scene.dt)
print(peak())
"""


def study(*, quick: bool, say: Progress) -> Findings:
    """Plans, times, start-up, and where a lone body's step spends its time."""
    from comotion_mock_cfd import scenes
    from comotion_server.plan import Plan
    from comotion_server.scene import load_scene

    names = ("float_box", "bounce") if quick else tuple(scenes.names())
    plans: dict[tuple[str, bool, str], list[str]] = {}
    costs, memory, starts = [], [], []
    for name in names:
        say(name)
        path = scenes.path_of(name)
        scene = load_scene(path)
        for line in Plan(scene).explain():
            plans.setdefault((line.stage, line.kept, line.reason), []).append(name)
        ways = forced(scene)
        costs += [[name, *_beside(scene, word, other, 20 if quick else STEPS)] for word, other in ways.items()]
        if ways and not quick:
            last = list(ways)[-1]
            memory.append([name, last, peak(str(path), ""), peak(str(path), last)])
        starts.append([name, *_start(str(path))])
    tables = [_stages(plans), *_tables(costs, memory, starts), _round_and_meshed(say), *_lone_body(say)]
    return Findings(tables=tables)


def _stages(plans: dict[tuple[str, bool, str], list[str]]) -> Table:
    """Which stages run in which scenes, from (stage, runs, reason), in the order of the plan."""
    order = list(dict.fromkeys(stage for stage, _, _ in plans))
    rows = sorted(plans.items(), key=lambda item: order.index(item[0][0]))
    return Table(
        "Stages in and out", ["stage", "runs", "reason", "scenes"], [[*key, ", ".join(which)] for key, which in rows]
    )


def _tables(costs: list[Row], memory: list[Row], starts: list[Row]) -> list[Table]:
    """What was measured of each scene."""
    return [
        Table(
            "As planned and with more forced on (no fluid)",
            [
                "scene",
                "forced on",
                "steps",
                "us a step",
                "us a step, forced",
                "ratio",
                "largest difference of positions [m]",
            ],
            costs,
        ),
        Table("Peak memory of a process", ["scene", "forced on", "as planned [MB]", "forced [MB]"], memory),
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
    ]


def forced(scene: "Scene") -> "dict[str, Scene]":
    """The scene with each stage that it does not need, and with all of them."""
    given, made = scene.collisions, {}
    ways: dict[str, dict[str, Any]] = {}
    if len(scene.bodies) < 2:
        far = wall("far-away", CUBE, (FAR, 0, 0))
        ways["collisions"] = {"bodies": tuple(sorted((*scene.bodies, far), key=lambda body: body.name))}
    if given.rule == "exact" and given.heal == "off" and not scene.name.startswith(("jam", "blockage")):
        ways["healing"] = {"heal": "wear"}
    if given.rule == "exact" and not given.merge and given.restitution > 0.0 and not given.material_pairs:
        ways["merging"] = {"merge": True}
    if len(ways) > 1:
        ways["everything"] = {key: value for way in ways.values() for key, value in way.items()}
    for word, way in ways.items():
        rules = {key: value for key, value in way.items() if key != "bodies"}
        made[word] = replace(scene, collisions=replace(given, **rules), bodies=way.get("bodies", scene.bodies))
    return made


def _beside(scene: "Scene", word: str, other: "Scene", steps: int) -> list[Any]:
    """Steps of a scene as planned and as forced, in turns."""
    from time import perf_counter

    from comotion_server.simulation import Simulation

    planned = Simulation(scene)
    try:
        changed = Simulation(other)
        changed.step(scene.dt)
    except Exception as error:  # noqa: BLE001 - some scene may refuse it, and the table says so
        return [word, None, None, None, None, f"refused: {error}"]
    planned.step(scene.dt)
    spent: list[list[float]] = [[], []]
    while len(spent[0]) < steps and sum(map(sum, spent)) < PATIENCE:
        for k, sim in enumerate((planned, changed)):
            begin = perf_counter()
            sim.step(scene.dt)
            spent[k].append(perf_counter() - begin)
    first, second = (1e6 * float(np.median(times)) for times in spent)
    rows = [changed.bodies.names.index(name) for name in planned.bodies.names if name in changed.bodies.names]
    if len(rows) < len(planned.bodies.names):
        return [word, len(spent[0]), first, second, second / first, "bodies have merged"]
    difference = float(np.abs(changed.bodies.position[rows] - planned.bodies.position).max())
    return [word, len(spent[0]), first, second, second / first, difference]


def peak(path: str, word: str) -> float:
    """Peak memory [MB] of a fresh process that takes some steps, as planned or with a stage forced on."""
    run = subprocess.run(
        [sys.executable, "-c", PEAK_OF_SELF + PEAK, path, word], capture_output=True, text=True, check=False
    )
    return float(run.stdout.splitlines()[-1]) if run.returncode == 0 else float("nan")


def _start(path: str) -> list[Any]:
    run = subprocess.run([sys.executable, "-c", PEAK_OF_SELF + START, path], capture_output=True, text=True, check=True)
    found: list[Any] = json.loads(run.stdout.splitlines()[-1])
    return found


def _round_and_meshed(say: Progress) -> Table:
    """The first step of the shipped pipe with 23 spheres, and of the same with the meshes that pictures show.

    Later the two are different scenes: facets throw balls out of the plane in which they fly, and hits become rare.
    """
    from comotion_mock_cfd import scenes
    from comotion_server.scene import load_scene
    from comotion_server.simulation import Simulation

    say("pipe with meshes")
    scene = load_scene(scenes.path_of("pipe"))
    meshed = replace(scene, bodies=tuple(replace(body, shape=body.surface) for body in scene.bodies))
    dt, rows = scene.dt, []
    for name, given in (("round", scene), ("meshes", meshed)):
        Simulation(given).step(dt)

        def prepared(given=given):
            sim = Simulation(given)
            return lambda: len(sim.step(dt).impacts)

        spent, impacts = timed_from(prepared)
        rows.append([name, 1e3 * spent / dt, impacts, 1e6 * spent / impacts])
    rows.append(["meshes / round", rows[1][1] / rows[0][1], None, rows[1][3] / rows[0][3]])
    columns = [f"23 spheres in a pipe for {dt} s", "wall ms per simulated second", "impacts", "us an impact"]
    return Table("Round bodies, and their meshes", columns, rows)


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
