"""Extreme masses, sizes, places, speeds and spins."""

from collections.abc import Iterator
from functools import cache, partial

import numpy as np

from comotion.report.cells import Cell
from comotion.report.scenes import CUBE, brick, driven, plane, play, simulation, wall
from comotion.report.tops import taylor

PINCH = 0.5  # [m] that the driven box goes before the pinch is closed


def cells() -> Iterator[Cell]:
    """All of them."""
    for ratio in (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12):
        required = "the impulse of the pair, exactly"
        yield Cell("mass ratio", f"{ratio:g}", required, "relative error <= 1e-12", partial(head_on, ratio), 1e-12)
    for mass in (1e-6, 1.0, 1e6):
        required = "blocked, nothing overlaps, nothing grows"
        yield Cell("pinched floe", f"{mass:g} kg", required, "overlap [m] <= 0", partial(pinched, mass), 0.0)
    for size in (1e-6, 1e-3, 1.0, 1e2, 1e4):
        required = "tolerances relative to size"
        yield Cell("size", f"{size:g} m", required, "relative error of the time <= 1e-8", partial(fall, size), 1e-8)
    for power in (-20, -10, 10):
        required = "bit-identical times"
        yield Cell("scaled by 2^n", str(power), required, "difference = 0", partial(scaled, power), 0.0)
    for shift in (1e3, 1e6, 1e7):
        limit = 128 * float(np.spacing(shift)) + 1e-8
        criterion = "error [m] <= 128 roundings of the place"
        yield Cell("moved far", f"{shift:g} m", "local origins", criterion, partial(moved, shift), limit)
    for spin in (1.0, 1e3, 1e5):
        criterion = "attitude error <= 1e-6 rad over 50 rad"
        yield Cell("spin", f"{spin:g} rad/s", "attitude 1e-6 rad", criterion, partial(spun, spin), 1e-6)
    for speed in (100.0, 1000.0, 3000.0):
        for thickness in (1e-2, 1e-4):
            value = f"{speed:g} m/s, wall {thickness:g} m, dt 0.01 s"
            bullet = partial(shot, speed, thickness)
            yield Cell("bullet", value, "never through", "way into the wall [m] <= 0", bullet, 0.0)


def head_on(ratio: float) -> float:
    """Elastic hit of a cube of mass 1 at rest by one of mass `ratio`: relative error of both velocities."""
    a = brick("a", CUBE, ratio, position=(-1.5, 0, 0), velocity=(1.0, 0, 0))
    sim = simulation(a, brick("b", CUBE, 1.0), restitution=1.0)
    play(sim, 1.0, 0.1)
    exact = np.array([(ratio - 1.0) / (ratio + 1.0), 2.0 * ratio / (ratio + 1.0)])
    return float((np.abs(sim.bodies.velocity[:, 0] - exact) / max(abs(exact))).max())


def pinched(mass: float) -> float:
    """A cube between a driven box and a wall: largest overlap, or infinity where the run is not blocked."""
    cube = brick("cube", CUBE, mass, position=(1.0, 0, 0))
    hull = driven("hull", CUBE, (1.0 - 1.0 - PINCH / 2, 0, 0), (1.0, 0, 0))
    bank = wall("bank", (1.0, 3.0, 1.0), (2.0 + PINCH / 2, 0, 0))
    sim = simulation(cube, hull, bank, restitution=0.0)
    deepest = -np.inf
    for _ in range(80):
        out = sim.step(0.01)
        bank_x, cube_x, hull_x = sim.bodies.position[:, 0]
        deepest = max(deepest, cube_x + 1.0 - bank_x, hull_x + 1.0 - cube_x)
    grown = np.abs(sim.bodies.velocity).max() > 1.0 + 1e-9
    return np.inf if out.status != "blocked" or grown else float(deepest)


def fall(size: float) -> float:
    """A cube of edge `size` at 1 edge a second, an edge above the floor: error of the time, relative."""
    cube = brick("cube", (size,) * 3, 1.0, position=(0, 0, 1.5 * size), velocity=(0, 0, -size))
    impacts = play(simulation(cube, plane(), restitution=0.5), 1.5, 0.1)
    return abs(impacts[0].time - 1.0) if impacts else np.inf


def scaled(power: int) -> float:
    """Lengths and speeds times 2^power: difference of the times of all impacts."""

    def times(factor):
        edges = np.array([1.0, 0.5, 0.25]) * factor
        state = {"position": np.array([0.0, 0, 2.0]) * factor, "velocity": np.array([0.25, 0.0, -3.0]) * factor}
        sim = simulation(brick("a", edges, 1.0, angular_velocity=(1.0, 2.0, 0.5), **state), plane(), restitution=0.5)
        return np.array([impact.time for impact in play(sim, 1.0, 0.125)])

    one, other = times(1.0), times(2.0**power)
    return float(np.abs(one - other).max()) if one.shape == other.shape and len(one) else np.inf


def moved(shift: float) -> float:
    """Two cubes meet far from the origin: error of the time at 1 m/s."""
    at = np.full(3, shift)
    a = brick("a", CUBE, 1.0, position=at, velocity=(1.0, 0, 0))
    sim = simulation(a, brick("b", CUBE, 1.0, position=at + np.array([1.5, 0.25, 0.125])), restitution=0.5)
    impacts = play(sim, 1.0, 0.1)
    return abs(impacts[0].time - 0.5) if impacts else np.inf


def spun(spin: float) -> float:
    """A triaxial box after 50 radians: error of its attitude against a Taylor series at unit spin."""
    size = np.array([0.9, 0.6, 0.3])
    moments = np.array([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2]) / 12
    omega = np.array([0.1, 0.99, 0.1])
    exact = turned(tuple(moments), tuple(omega))
    sim = simulation(brick("top", size, 1.0, angular_velocity=spin * omega))
    for _ in range(10):
        sim.step(5.0 / spin)
    w, x, y, z = sim.bodies.quaternion[0]
    found = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return float(np.abs(np.array(found) - exact).max())


@cache
def turned(moments: tuple[float, ...], omega: tuple[float, ...]) -> np.ndarray:
    """The attitude (3,3) after 50 s by a Taylor series."""
    inertia = np.array(moments)
    return taylor(np.eye(3), inertia * np.array(omega), inertia, 50.0, 200).astype(float)


def shot(speed: float, thickness: float) -> float:
    """A cube of 5 cm against a thin fixed wall: the largest x of its corners beyond the wall's face."""
    half = 0.025
    bullet = brick("bullet", (2 * half,) * 3, 0.1, position=(-5.0, 0, 0), velocity=(speed, 0, 0))
    sim = simulation(bullet, wall("wall", (thickness, 100.0, 100.0), (thickness / 2, 0, 0)), restitution=0.5)
    play(sim, 0.1, 0.01)
    deepest = sim.bodies.position[0, 0] + half
    return float(deepest)
