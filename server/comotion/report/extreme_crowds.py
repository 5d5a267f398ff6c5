"""Many bodies, many contacts, long rest; grazing."""

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from comotion.report.cells import Cell
from comotion.report.scenes import CUBE, G, brick, driven, plane, play, simulation, sphere

if TYPE_CHECKING:
    from comotion_server.results import StepResult

GRAZING_OVERLAP = 1e-12  # of size


def cells() -> Iterator[Cell]:
    """All of them."""
    for count, long in ((10, False), (30, False), (100, True), (300, True)):
        required = "bounded work, no overlap, said to be blocked"
        jam = lambda n=count: jammed(n)  # noqa: E731
        yield Cell("jam", f"{count} bodies in a row", required, "overlap [m] <= 0", jam, 0.0, long)
    for side in (2, 5, 10):
        required = "all answered as if alone, whatever their numbers"
        land = lambda n=side: landing(n)  # noqa: E731
        criterion = "relative error of the speeds <= 1e-9"
        yield Cell("simultaneous contacts", f"{side * side} cubes", required, criterion, land, 1e-9, side == 10)
    for count in (10, 100):
        pit = lambda n=count: landed_balls(n)  # noqa: E731
        criterion = "relative error of the speeds <= 1e-9"
        yield Cell("simultaneous contacts", f"{count} spheres", "all answered as if alone", criterion, pit, 1e-9)
    for steps, long in ((1000, False), (1_000_000, True)):
        rest = lambda n=steps: resting(n)  # noqa: E731
        yield Cell("box at rest", f"{steps} steps", "no creep", "way moved [m] = 0", rest, 0.0, long)
    for ratio in (1.0, 1e3, 1e6):
        stack = lambda r=ratio: stacked(r)  # noqa: E731
        yield Cell("stack, heavy on top", f"{ratio:g}", "stands", "way moved [m] <= 1e-7", stack, 1e-7)
    for inside in (1e-9, 1e-12, 0.0, -1e-12, -1e-9):
        required = "hit or miss, but no overlap"
        graze = lambda x=inside: grazing(x)  # noqa: E731
        yield Cell("grazing", f"{inside:g} m inside", required, "overlap <= 1e-12 of size", graze, GRAZING_OVERLAP)
    for e in (0.02, 0.0717):
        collapse = lambda e=e: collapsed(e)  # noqa: E731
        required = "bounded work, momentum kept"
        yield Cell("inelastic collapse", f"e = {e:g}", required, "momentum <= 1e-13", collapse, 1e-13)


def jammed(count: int) -> float:
    """Two driven boxes press a row of cubes together: largest overlap; infinite where it is not told as blocked."""
    gap = 0.25 / (count + 1)
    row = [brick(f"c{k:04d}", CUBE, position=(k * (1.0 + gap), 0, 0)) for k in range(count)]
    west = driven("west", CUBE, (-1.0 - gap, 0, 0), (1.0, 0, 0))
    east = driven("x-east", CUBE, (count * (1.0 + gap), 0, 0), (-1.0, 0, 0))
    sim = simulation(*row, west, east, restitution=0.0)
    deepest = -np.inf
    for _ in range(20):
        out: StepResult = sim.step(0.01)
        along = np.sort(sim.bodies.position[:, 0])
        deepest = max(deepest, 1.0 - np.diff(along).min())
    return float(deepest) if out.status == "blocked" else np.inf


def landing(side: int) -> float:
    """Cubes in a grid fall flat on a plane at the same time, e = 0.5: the speed after, against e v."""
    grid = product(range(side), repeat=2)
    cubes = [brick(f"c{i}-{j}", CUBE, position=(1.5 * i, 1.5 * j, 0.75), velocity=(0, 0, -1.0)) for i, j in grid]
    sim = simulation(*cubes, plane(), restitution=0.5)
    play(sim, 0.5, 0.1)
    cubes_only = [k for k, name in enumerate(sim.bodies.names) if name != "floor"]
    return float(np.abs(sim.bodies.velocity[cubes_only] / 0.5 - (0.0, 0.0, 1.0)).max())


def landed_balls(count: int) -> float:
    """Spheres fall on a plane at the same time, e = 0.5: the speed after, against e v."""
    balls = [sphere(f"b{k:03d}", 0.5, position=(1.5 * k, 0.0, 0.75), velocity=(0, 0, -1.0)) for k in range(count)]
    sim = simulation(*balls, plane(), restitution=0.5)
    play(sim, 0.5, 0.1)
    return float(np.abs(sim.bodies.velocity[:count] / 0.5 - (0.0, 0.0, 1.0)).max())


def resting(steps: int) -> float:
    """A box that has come to rest: the way [m] it goes in so many steps."""
    sim = simulation(brick("box", CUBE, position=(0, 0, 0.5)), plane(), gravity=G, restitution=0.5)
    play(sim, 0.2, 0.01)
    at = sim.bodies.position[0]
    for _ in range(steps):
        sim.step(0.01)
    return float(np.abs(sim.bodies.position[0] - at).max())


def stacked(ratio: float) -> float:
    """Three cubes, masses 1, sqrt(r), r upwards: the way [m] that one of them goes in a second."""
    masses = (1.0, ratio**0.5, ratio)
    cubes = [brick(f"b{k}", CUBE, mass, position=(0, 0, 0.5 + k)) for k, mass in enumerate(masses)]
    sim = simulation(*cubes, plane(), gravity=G, restitution=0.5)
    play(sim, 1.0, 0.01)
    return float(np.abs(sim.bodies.position[:3, 2] - (0.5, 1.5, 2.5)).max())


def grazing(inside: float) -> float:
    """A cube flies past another, `inside` of its path: the largest overlap of the two, which do not turn."""
    a = brick("a", CUBE, position=(-2.0, 1.0 - inside, 0), velocity=(1.0, 0, 0))
    sim = simulation(a, brick("b", CUBE), restitution=1.0)
    deepest = -np.inf
    for _ in range(40):
        sim.step(0.1)
        if np.abs(sim.bodies.angular_velocity).max() == 0.0:
            apart = np.abs(sim.bodies.position[1] - sim.bodies.position[0])
            deepest = max(deepest, 1.0 - apart.max())
    return float(deepest)


def collapsed(e: float) -> float:
    """Three cubes in a line below e = 7 - 4 sqrt 3: error of the momentum; infinite where the work is not bounded."""
    cubes = [brick(f"c{k}", CUBE, position=(1.125 * k, 0, 0), velocity=(float(k == 0), 0, 0)) for k in range(3)]
    sim = simulation(*cubes, restitution=e)
    used = sum(sim.step(0.05).budget.used for _ in range(60))
    return np.inf if used > 300 else abs(float(sim.bodies.velocity[:, 0].sum()) - 1.0)
