"""Bouncing and elastic balls: comotion beside MuJoCo, Bullet and DART, each at its own steps.

Wall time is that of advancing alone. A run that takes longer than the patience is ended and judged by how far it came.
Steps [s] are the engines' own; those of comotion are coupling steps, within which it finds the times of contact.
"""

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.simbenchmark import NOTE, published
from comotion.report.study import Progress

STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
COUPLING_STEPS = (1e-1, 1e-2, 1e-3)
PATIENCE = 10.0  # [s] of wall time for one run


def study(*, quick: bool, say: Progress) -> Findings:
    """A figure per case."""
    from time import perf_counter

    from comotion.report.engine_cases import CASES
    from comotion.report.engine_parties import LIBRARIES, PARTIES

    def run(case, party, dt, patience):
        """Wall time per simulated second, the error, and how many seconds were simulated."""
        every = 1 if case.samples is None else max(1, round(case.duration / dt / case.samples))
        now, spent, done = 0.0, 0.0, 0
        times, states = [now], [party.state()]
        while done < round(case.duration / dt) and spent < patience:
            begin = perf_counter()
            party.advance(every)
            spent += perf_counter() - begin
            done += every
            times.append(done * dt)
            states.append(party.state())
            if not np.isfinite(states[-1].position).all():
                return spent / times[-1], np.inf, times[-1]
        return spent / times[-1], case.error(case, times, states), times[-1]

    found = Findings()
    for name in ("bounce",) if quick else CASES:
        case = CASES[name]()
        curves = []
        for party in PARTIES:
            curve = Curve(party, "dt [s]")
            steps = COUPLING_STEPS if party == "comotion" else STEPS
            for dt in steps[1:2] if quick else steps:
                say(f"{name}, {party}, {dt:g} s")
                wall, error, simulated = run(case, PARTIES[party](case, dt), dt, 2.0 if quick else PATIENCE)
                curve.points.append(Point(wall, error, f"{dt:g}"))
                if simulated < case.duration - 1.5 * dt:
                    found.notes.append(f"{name}, {party}, {dt:g} s: ended by patience at {simulated:.3g} s.")
            curves.append(curve)
        curves += published(name)
        title = (CASES[name].__doc__ or "").rstrip(".")
        y_label = f"error: {case.error_name}"
        found.charts.append(Chart(f"engines-{name}", title, "wall seconds per simulated second", y_label, curves))
    missing = [library for party, library in LIBRARIES.items() if party not in PARTIES]
    if missing:
        found.notes.append(f"Left out, as not installed: {', '.join(missing)}.")
    found.notes.append(NOTE)
    return found
