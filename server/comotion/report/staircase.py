"""A free hull runs into a row of equal floes with equal gaps, e = 1: V_k = U ((M - m) / (M + m))^k (momentum alone)."""

from typing import Any

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.scenes import CUBE, brick, player, simulation
from comotion.report.study import Progress
from comotion.report.timing import timed_from

FLOES, SPEED, MASS, GAP = 6, 1.0, 10.0, 0.1875
SHARE = (MASS - 1.0) / (MASS + 1.0)
TIMES = np.cumsum(GAP / (SPEED * SHARE ** np.arange(FLOES)))  # of the hull's impacts [s]
DURATION = 2.0 * (TIMES[-1] // 2.0 + 1.0)  # [s]: after the last one
SAME_TIME = 1e-9  # [s]: points of one patch


def study(*, quick: bool, say: Progress) -> Findings:
    """Error of the times of the hull's impacts against run time."""
    steps = (0.05,) if quick else (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005)
    methods: dict[str, dict[str, Any]] = {
        "exact": {},
        "exact, tolerance 1e-12": {"tolerance": 1e-12},
        "paper, N = 1": {"rule": "paper", "substeps": 1},
        "paper, N = 4": {"rule": "paper", "substeps": 4},
        "paper-advance, N = 4": {"rule": "paper-advance", "substeps": 4},
    }
    curves, notes = [], []
    for name, given in methods.items():
        curve = Curve(name, "dt [s]")
        for dt in steps:
            say(f"{name}, {dt:g} s")
            spent, (_, impacts) = timed_from(player(lambda: _scene(**given), DURATION, dt), 1 if quick else 5)  # noqa: B023
            error = _error(impacts)
            if error is None:
                notes.append(f"{name}, dt = {dt:g} s: the hull did not hit {FLOES} times.")
            else:
                curve.points.append(Point(spent / DURATION, error, f"{dt:g}"))
        curves.append(curve)
    title = f"Hull against {FLOES} floes, e = 1: times of its impacts"
    x_label = "wall seconds per simulated second"
    return Findings([Chart("staircase", title, x_label, "largest error [s]", curves)], notes=notes)


def _error(impacts):
    found = sorted(impact.time for impact in impacts if "hull" in {impact.body_a, impact.body_b})
    apart = [time for k, time in enumerate(found) if k == 0 or time - found[k - 1] > SAME_TIME]
    return float(np.abs(np.array(apart) - TIMES).max()) if len(apart) == FLOES else None


def _scene(**given):
    hull = brick("hull", CUBE, MASS, position=(-1.0 - GAP, 0, 0), velocity=(SPEED, 0, 0))
    floes = [brick(f"ice-{k}", CUBE, 1.0, position=(k * (1.0 + GAP), 0.0, 0.0)) for k in range(FLOES)]
    return simulation(hull, *floes, restitution=1.0, **given)
