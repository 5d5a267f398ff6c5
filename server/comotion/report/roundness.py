"""A ball of facets beside the round one: an oblique hit of two balls, whose outcome is a closed form for spheres.

Ball b comes along x with its centre `OFFSET` above that of a at rest: then the line of centres is
n = (-sqrt(1 - s^2), 0, s), s = OFFSET / (2 r), and equal masses, e = 1, without friction,
exchange what they have along n.
"""

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.scenes import ball, play, simulation, solid
from comotion.report.study import Progress
from comotion.report.timing import timed_from

RADIUS, GAP, OFFSET, SPEED = 0.5, 0.5, 0.4, 1.0
SINE = OFFSET / (2 * RADIUS)
NORMAL = np.array([-np.sqrt(1.0 - SINE**2), 0.0, SINE])
BEFORE = np.array([SPEED, 0.0, 0.0])
AFTER = BEFORE - (BEFORE @ NORMAL) * NORMAL  # of b; a takes the rest
DURATION, STEP = 2.0, 0.1


def study(*, quick: bool, say: Progress) -> Findings:
    """Error of the velocities after the hit against run time, by the number of facets."""
    found = Findings()
    meshed = Curve("meshed ball", "facets")
    for halvings in (1, 2) if quick else (0, 1, 2, 3, 4, 5):
        mesh = ball(RADIUS, halvings)
        say(f"{len(mesh.triangles)} facets")
        meshed.points.append(_run(lambda name, mesh=mesh, **state: solid(name, mesh, **state), len(mesh.triangles)))
    curves = [meshed]
    try:
        from comotion_server.scene import Sphere
    except ImportError:
        found.notes.append("The shape `sphere` is unknown: the round ball is left out.")
    else:
        say("sphere")
        curves.append(Curve("sphere", "", [_run(lambda name, **state: _round(Sphere(RADIUS), name, **state), "")]))
    title = "Oblique hit of two balls: velocities afterwards"
    x_label = "wall seconds per simulated second"
    found.charts.append(Chart("roundness", title, x_label, "largest error [m/s] at 1 m/s", curves))
    return found


def _round(shape, name, **state):
    from comotion_server.scene import Body, Free

    vectors = {key: np.asarray(value, dtype=float) for key, value in state.items()}
    return Body(name, name, Free(), 1.0, 0.4 * RADIUS**2 * np.eye(3), shape, **vectors)


def _run(body, label):
    def make():
        a = body("a")
        b = body("b", position=(-2 * RADIUS - GAP, 0.0, OFFSET), velocity=BEFORE)
        sim = simulation(a, b, restitution=1.0)
        return lambda: (sim, play(sim, DURATION, STEP))

    make()()  # compiled
    spent, (sim, _) = timed_from(make)
    error = np.abs(sim.bodies.velocity - [BEFORE - AFTER, AFTER]).max()
    return Point(spent / DURATION, float(error), str(label))
