"""Time per step against the number of bodies, of facets, and of vertices through the protocol; fitted exponents."""

from dataclasses import replace
from math import ceil

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point, Table
from comotion.report.scenes import brick, simulation, solid
from comotion.report.study import Progress
from comotion.report.timing import timed

STEP = 0.01  # [s]
SPACING, EDGE = 0.5, 0.25  # [m] of floes
REPEATS = 3


def study(*, quick: bool, say: Progress) -> Findings:
    """A figure per kind of size."""
    floes = (10, 30) if quick else (10, 30, 100, 300, 1000, 3000, 10_000)
    spheres = () if quick else (10, 100, 1000, 10_000, 100_000)
    halvings = (1, 2) if quick else (0, 1, 2, 3, 4, 5, 6, 7)
    vertices = (1, 2) if quick else (0, 2, 4, 6, 7, 8)
    notes: list[str] = []
    bodies = [_floes(floes, say)]
    if spheres:
        try:
            bodies.append(_spheres(spheres, say))
        except ImportError:
            notes.append("The shape `sphere` is unknown: left out.")
    facets = [_facets(halvings, say)]
    through = [_through(vertices, say)]
    y_label = "wall seconds per step"
    charts = [
        Chart("scaling-bodies", "Bodies that drift at random and collide", "bodies", y_label, bodies, None),
        Chart("scaling-facets", "Two balls that meet", "facets of each", y_label, facets, None),
        Chart("scaling-vertices", "A lone body through the protocol, in memory", "vertices", y_label, through, None),
    ]
    fitted = [[curve.name, chart.x_label, curve.slope()] for chart in charts for curve in chart.curves]
    table = Table("Exponents of the time per step", ["what", "against", "exponent"], fitted)
    return Findings(charts, [table], notes)


def _grid(count: int) -> np.ndarray:
    side = ceil(count**0.5)
    return np.array([(SPACING * (k % side), SPACING * (k // side), 0.0) for k in range(count)])


def _timed_steps(sim, steps=5):
    sim.step(STEP)
    spent, _ = timed(lambda: [sim.step(STEP) for _ in range(steps)], REPEATS)
    return spent / steps


def _floes(counts, say):
    curve = Curve("floes (boxes)", "bodies")
    rng = np.random.default_rng(1)
    for count in counts:
        say(f"{count} floes")
        speeds = rng.uniform(-1.0, 1.0, (count, 3)) * (1.0, 1.0, 0.0)
        size = (EDGE, EDGE, 0.0625)
        bodies = [
            brick(f"f{k:06d}", size, position=at, velocity=speed)
            for k, (at, speed) in enumerate(zip(_grid(count), speeds, strict=True))
        ]
        shared = bodies[0].shape
        sim = simulation(*(replace(body, shape=shared) for body in bodies), restitution=0.5, budget=1_000_000)
        curve.points.append(Point(count, _timed_steps(sim), str(count)))
    return curve


def _spheres(counts, say):
    from comotion_server.scene import Body, Free, Sphere

    curve = Curve("spheres", "bodies")
    rng, inertia, shape = np.random.default_rng(1), 0.4 * 0.125**2 * np.eye(3), Sphere(0.125)
    for count in counts:
        say(f"{count} spheres")
        speeds = rng.uniform(-1.0, 1.0, (count, 3)) * (1.0, 1.0, 0.0)
        rows = zip(_grid(count), speeds, strict=True)
        bodies = [
            Body(f"s{k:06d}", "spheres", Free(), 1.0, inertia, shape, position=at, velocity=speed)
            for k, (at, speed) in enumerate(rows)
        ]
        sim = simulation(*bodies, restitution=1.0, budget=10_000_000)
        curve.points.append(Point(count, _timed_steps(sim), str(count)))
    return curve


def _ball(halvings):
    from comotion_mock_cfd.body_forms import ball_mesh
    from comotion_server.meshes import TriangleMesh

    return TriangleMesh(*ball_mesh(0.5, halvings))


def _facets(halvings, say):
    curve = Curve("pair of balls", "facets")
    for level in halvings:
        mesh = _ball(level)
        count = len(mesh.triangles)
        say(f"{count} facets")
        a = solid("a", mesh, angular_velocity=(0.3, 0.2, 0.1))
        b = solid("b", mesh, position=(1.05, 0.0, 0.1), velocity=(-1.0, 0.0, 0.0))
        curve.points.append(Point(count, _timed_steps(simulation(a, b, restitution=1.0), 10), str(count)))
    return curve


def _through(halvings, say):
    from comotion.report.served import served

    curve = Curve("forces in, vertices out", "vertices")
    for level in halvings:
        mesh = _ball(level)
        count = len(mesh.vertices)
        say(f"{count} vertices")
        forces = {"ball": np.zeros((count, 3))}
        with served(simulation(solid("ball", mesh)), dt=STEP) as motion:
            motion.step(STEP, forces)
            spent, _ = timed(lambda: [motion.step(STEP, forces) for _ in range(5)], REPEATS)  # noqa: B023
        curve.points.append(Point(count, spent / 5, str(count)))
    return curve
