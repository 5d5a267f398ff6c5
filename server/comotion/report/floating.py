"""Heave and roll of a floating box: forces sampled at the start of a step and held pump energy, the midpoint does not.

The box, 0.4 x 0.4 x 0.2 m, floats half under water. Heave: w^2 = g / T. Roll: w^2 = m g GM / I with
GM = KB + BM - KG = T / 2 + (b^4 / 12) / (b^2 T) - h / 2. No added mass, no drag: the motion is a cosine. Its amplitude
is small enough for the linear theory to hold to the rounding of the coordinates.
"""

from math import atan2, cos, pi, sqrt
from typing import Any

from comotion.report.findings import Chart, Curve, Findings, Point
from comotion.report.scenes import G, brick, simulation
from comotion.report.study import Progress

BREADTH, HEIGHT, DRAUGHT, WATER = 0.4, 0.2, 0.1, 1000.0
MASS = WATER * BREADTH**2 * DRAUGHT
METACENTRE = DRAUGHT / 2 + BREADTH**2 / 12 / DRAUGHT - HEIGHT / 2  # GM [m]
INERTIA = MASS * (BREADTH**2 + HEIGHT**2) / 12
START = {"heave": 1e-5, "roll": 1e-5}  # [m], [rad]
FREQUENCY = {"heave": sqrt(G / DRAUGHT), "roll": sqrt(MASS * G * METACENTRE / INERTIA)}  # [rad/s]
PERIODS = 3.0


def study(*, quick: bool, say: Progress) -> Findings:
    """Largest error over three periods, relative to the amplitude, against run time."""
    parts = (20,) if quick else (10, 20, 50, 100, 200, 500, 1000)
    charts = []
    _run("heave", "midpoint", 10)  # compiled
    for kind in START:
        curves = []
        for sample, name in (("end", "start of the step"), ("midpoint", "midpoint")):
            curve = Curve(name, "steps per period")
            for count in parts:
                say(f"{kind}, {name}, {count}")
                curve.points.append(_run(kind, sample, count))
            curves.append(curve)
        title = f"{kind.capitalize()} of a box over {PERIODS:g} periods"
        y_label = "largest error / amplitude"
        charts.append(Chart(f"floating-{kind}", title, "wall seconds per simulated second", y_label, curves, None))
    return Findings(charts, notes=["The whole exchange: mock client, protocol, server, in one process."])


def _run(kind: str, sample: Any, count: int) -> Point:
    from time import perf_counter

    from comotion.report.served import served
    from comotion_mock_cfd.cfd_client import CfdClient, wants
    from comotion_mock_cfd.fluid import Fluid, FluidScene

    dt = 2 * pi / FREQUENCY[kind] / count
    duration = round(PERIODS * count) * dt
    state: dict[str, Any] = (
        {"position": (0.0, 0.0, START["heave"])}
        if kind == "heave"
        else {"quaternion": (cos(START["roll"] / 2), START["roll"] / 2, 0.0, 0.0)}
    )
    sim = simulation(brick("box", (BREADTH, BREADTH, HEIGHT), MASS, **state), gravity=G)
    errors = []

    def look(_: Any) -> None:
        w, x, _, _ = sim.bodies.quaternion[0]
        now = sim.bodies.position[0, 2] if kind == "heave" else 2 * atan2(x, w)
        errors.append(abs(now / START[kind] - cos(FREQUENCY[kind] * sim.time)))

    with served(sim, wants=wants(sample), dt=dt) as motion:
        begin = perf_counter()
        CfdClient(motion, FluidScene(Fluid(density=WATER), G, dt, duration)).run(look)
        spent = perf_counter() - begin
    return Point(spent / duration, max(errors), str(count))
