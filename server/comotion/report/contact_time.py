"""Time of a contact: a cube that spins in place beside a wall touches it with an edge, in closed form.

The edge is at distance sin 45 deg from the axis: the cube, width 1, touches a wall at distance d from its axis when
cos(pi / 4 - w t) / sqrt 2 = d, t = (pi / 4 - acos(sqrt 2 d)) / w.
"""

from math import acos, pi, sqrt

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.scenes import CUBE, brick, player, simulation, wall
from comotion.report.study import Progress
from comotion.report.timing import timed_from

DISTANCE = 0.6  # [m] of the wall from the axis
SPIN = 1.0  # [rad/s]
EXACT = (pi / 4 - acos(sqrt(2.0) * DISTANCE)) / SPIN  # [s]
STEP = 0.1  # [s]
STEPS = 4


def study(*, quick: bool, say: Progress) -> Findings:
    """Error of the contact time [s] against the wall time of the steps up to it."""
    tolerances = (1e-6, 1e-9) if quick else (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
    parts = (4,) if quick else (1, 2, 4, 8, 16)
    methods = {"exact": ("tolerance", [(f"{t:g}", {"tolerance": t}) for t in tolerances])}
    for rule in ("paper", "paper-advance"):
        methods[rule] = ("N", [(str(n), {"substeps": n}) for n in parts])
    curves, notes = [], []
    for rule, (parameter, values) in methods.items():
        curve = Curve(rule, parameter)
        for label, given in values:
            say(f"{rule}, {label}")
            make = player(lambda: _scene(rule=rule, **given), STEPS * STEP, STEP)  # noqa: B023
            spent, (_, impacts) = timed_from(make)
            if impacts:
                curve.points.append(Point(spent, abs(impacts[0].time - EXACT), label))
            else:
                notes.append(f"{rule}, {parameter} {label}: missed the contact.")
        curves.append(curve)
    title = "Time at which a spinning cube touches a wall"
    return Findings([Chart("contact_time", title, "wall seconds", "error of the time [s]", curves)], notes=notes)


def _scene(**collisions):
    cube = brick("cube", CUBE, 1.0, angular_velocity=(0.0, 0.0, SPIN))
    return simulation(cube, wall("wall", (1.0, 4.0, 4.0), (DISTANCE + 0.5, 0.0, 0.0)), **collisions)
