"""When 23 spheres in a pipe meet for the 100th time: chaos multiplies every earlier error."""

from dataclasses import replace

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.spheres_in_decimals import Spheres
from comotion.report.study import Progress
from comotion.report.timing import timed_from

COUNT = 100  # impacts
NOTE = (
    "The pipe of the shipped scene `pipe`. Truth: the same spheres from impact to impact in decimal arithmetic of 60"
    " digits. `paper-analytic` answers impacts where the bodies are at the beginning of a step, and soon plays another"
    " billiard."
)


def study(*, quick: bool, say: Progress) -> Findings:
    """Error of the time of the 100th impact [s] against the wall time of all steps up to it."""
    from comotion_mock_cfd.scenes import path_of
    from comotion_server.scene import Pipe, Sphere, load_scene
    from comotion_server.simulation import Simulation

    scene = load_scene(path_of("pipe"))
    balls = [body for body in scene.bodies if isinstance(body.shape, Sphere)]
    pipe = next(body.shape for body in scene.bodies if isinstance(body.shape, Pipe))
    across = [0, 2, 1]  # the scene's pipe lies along y
    x, v = (np.array([getattr(ball, name) for ball in balls])[:, across] for name in ("position", "velocity"))
    radius = next(body.shape.radius for body in scene.bodies if isinstance(body.shape, Sphere))
    say("decimals")
    truth = Spheres(x, v, radius, pipe.inner_radius)
    times = [float(truth.event()[0]) for _ in range(COUNT)]
    steps = (0.25, 0.01) if quick else (0.25, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3)
    curves = []
    for rule in ("exact", "paper-analytic"):
        curve = Curve(rule, "dt [s]")
        ruled = replace(scene, collisions=replace(scene.collisions, rule=rule))
        for dt in steps:
            say(f"{rule}, {dt:g} s")

            def prepared(ruled=ruled, dt=dt):
                sim = Simulation(ruled)
                return lambda: _times(sim, dt)

            spent, found = timed_from(prepared, 1 if quick else 5)
            curve.points.append(Point(spent, abs(found[COUNT - 1] - times[-1]), f"{dt:g}"))
        curves.append(curve)
    title = f"23 spheres in a pipe: time of impact {COUNT}"
    return Findings([Chart("many_impacts", title, "wall seconds", "error of the time [s]", curves)], notes=[NOTE])


def _times(sim, dt):
    """Times of impacts in order, until there are enough."""
    found: list[float] = []
    while len(found) < COUNT:
        found += sorted(impact.time for impact in sim.step(dt).impacts)
    return found
