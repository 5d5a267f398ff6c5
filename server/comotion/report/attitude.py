"""Attitude of a free triaxial top: six integrators beside the flight of comotion, against a Taylor series."""

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.study import Progress
from comotion.report.timing import timed

MOMENTS = np.array([0.4, 0.7, 1.0])
MOMENTUM = np.array([0.3, 0.5, -0.4])
DURATION = 10.0  # [s]: about ten radians
EXACT_STEPS = 200  # of the Taylor series


def study(*, quick: bool, say: Progress) -> Findings:
    """Error of R [rad] against wall time per simulated second."""
    from comotion.report.tops import OTHERS, taylor
    from comotion_server.kernels.flight import split

    steps = (32, 128) if quick else (16, 32, 64, 128, 256, 512, 1024, 4096, 16384)
    exact = taylor(np.eye(3), MOMENTUM, MOMENTS, DURATION, EXACT_STEPS)

    def error(R):
        return float(np.abs(R - exact).max())

    curves = []
    for name, integrate in OTHERS.items():
        say(name)
        curve = Curve(name, "steps")
        integrate(np.eye(3), MOMENTUM, MOMENTS, DURATION, 1)
        for n in steps:
            spent, R = timed(lambda: integrate(np.eye(3), MOMENTUM, MOMENTS, DURATION / n, n))  # noqa: B023
            curve.points.append(Point(spent / DURATION, error(R), str(n)))
        curves.append(curve)

    def ours(n):
        R, L, none, own = np.eye(3), MOMENTUM.copy(), np.zeros(3), np.eye(3)
        for _ in range(n):
            split(R, L, MOMENTS, own, none, DURATION / n)
        return R

    say("comotion")
    ours(1)
    curve = Curve("comotion", "CFD steps")
    for n in (1, 10, 100):
        spent, R = timed(lambda: ours(n))  # noqa: B023
        curve.points.append(Point(spent / DURATION, error(R), str(n)))
    chart = Chart(
        "attitude",
        "Attitude of a free triaxial top after 10 s",
        "wall seconds per simulated second",
        "error of the rotation matrix",
        [*curves, curve],
    )
    note = (
        "comotion chooses its own sub-steps for 1e-13 rad per radian turned, or per CFD step where that is shorter: its"
        " error hardly depends on the CFD step. Truth: Taylor series of order 24 in extended precision."
    )
    return Findings([chart], notes=[note])
