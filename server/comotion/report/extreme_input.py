"""Steps that cannot be: refused, with the state as it was, and the next good one works; or answered exactly."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from comotion.report.cells import Cell, refused
from comotion.report.scenes import CUBE, brick, plane, simulation, wall
from comotion_server.forces import StepInputError

REFUSED = "a clear refusal, the state untouched, the next step works"


def cells() -> Iterator[Cell]:
    """All of them."""
    nan, inf = float("nan"), float("inf")
    good = np.zeros((8, 3))
    criterion = "0: StepInputError, same bits, works on"
    for dt in (0.0, -0.01, nan, inf):
        yield Cell("bad dt", f"{dt:g} s", REFUSED, criterion, partial(turned_away, dt), 0.0)
    bad = {
        "nan": {"box": np.full((8, 3), nan)},
        "inf": {"box": np.full((8, 3), inf)},
        "1e308": {"box": np.full((8, 3), 1e308)},
        "7 rows of 8": {"box": good[:7]},
        "unknown region": {"sea": good},
        "text": {"box": "much"},
    }
    for value, forces in bad.items():
        yield Cell("bad forces", value, REFUSED, criterion, partial(turned_away, 0.01, forces), 0.0)
    for dt in (1e-12, 1.0, 1e6):
        exact = partial(flown, dt)
        yield Cell("extreme dt", f"{dt:g} s", "the exact answer", "relative error <= 1e-14", exact, 1e-14)
    for dt in (1.0, 10.0, 1e4):
        back = partial(sent_back, dt)
        yield Cell("extreme dt, a wall ahead", f"{dt:g} s", "the exact answer", "relative error <= 1e-8", back, 1e-8)


def sent_back(dt: float) -> float:
    """A cube at 1 m/s, e = 0.5, a wall 2 m ahead: where it is after one step, relative."""
    sim = simulation(brick("a", CUBE, velocity=(1, 0, 0)), wall("b", CUBE, (3, 0, 0)), restitution=0.5)
    sim.step(dt)
    exact = dt if dt < 2.0 else 2.0 - 0.5 * (dt - 2.0)
    return abs(float(sim.bodies.position[0, 0]) / exact - 1.0)


def turned_away(dt: float, forces: Any = None) -> float:
    """0 where the step is refused, nothing has changed, and a good one goes as it would have."""
    sim, other = _falling(), _falling()
    sim.step(0.01)
    other.step(0.01)
    before = [array.tobytes() for array in _state(sim)]
    wrong = refused(lambda: sim.step(dt, forces), StepInputError)
    wrong += [array.tobytes() for array in _state(sim)] != before
    sim.step(0.01)
    other.step(0.01)
    return wrong + ([a.tobytes() for a in _state(sim)] != [b.tobytes() for b in _state(other)])


def flown(dt: float) -> float:
    """A body under a constant force: error of one step against the parabola, relative."""
    sim = simulation(brick("box", CUBE, 2.0, velocity=(1.0, 0, 0)))
    sim.step(dt, wrenches=np.array([[0.0, 4.0, 0, 0, 0, 0]]))
    exact = np.array([dt, dt * dt, 0.0])
    return float((np.abs(sim.bodies.position[0] - exact) / np.maximum(exact, 1e-300)).max())


def _falling():
    return simulation(brick("box", CUBE, position=(0, 0, 2.0)), plane(), gravity=9.81, restitution=0.5)


def _state(sim):
    return sim.bodies.position, sim.bodies.quaternion, sim.bodies.velocity, sim.bodies.angular_velocity
