"""Metamorphic cells: two bricks tumble, hit each other and a wall; the same scene seen otherwise must end the same.

Compared are positions after a second with a few impacts. Rounding grows with each of them: 1e-9 is far above what it
comes to, and far below any difference of substance.
"""

from collections.abc import Callable, Iterator

import numpy as np

from comotion.report.cells import Cell
from comotion.report.scenes import brick, plane, simulation

SIZES = {"a": (0.9, 0.6, 0.3), "b": (0.5, 0.8, 0.4)}
PLACES = {"a": (0.0, 0.0, 0.0), "b": (1.5, 0.1, 0.05)}
SPEEDS = {"a": (1.0, 0.2, 0.0), "b": (-1.0, 0.0, 0.1)}
SPINS = {"a": (0.4, 0.3, 0.2), "b": (-0.2, 0.5, 0.1)}
WALL = -1.0  # [m] the plane's x
SAME = 1e-9  # [m]


def cells() -> Iterator[Cell]:
    """All of them."""
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    mirror = np.diag([1.0, -1.0, 1.0])
    tests: dict[str, Callable[[], float]] = {
        "mirror": lambda: linear(mirror),
        "quarter turn": lambda: linear(quarter),
        "Galilean boost": boosted,
        "renumbering": renumbered,
        "step split in two": lambda: split(2),
        "step split in ten": lambda: split(10),
        "time reversal, e = 1": reversed_in_time,
    }
    for value, test in tests.items():
        yield Cell("the same otherwise", value, "the same end", "difference [m] <= 1e-9", test, SAME)


def ends(Q: np.ndarray, boost: tuple[float, ...] = (0, 0, 0), dt: float = 0.1, names: str = "ab") -> np.ndarray:
    """Positions of a and b after a second; Q maps the scene; a boost leaves the wall out."""
    flip = np.linalg.det(Q)  # of an axial vector
    bodies = []
    for own, name in zip("ab", names, strict=True):
        size = np.abs(Q) @ SIZES[own]
        state = {"position": Q @ PLACES[own], "velocity": Q @ SPEEDS[own] + boost}
        bodies.append(brick(name, size, 1.0, angular_velocity=flip * (Q @ SPINS[own]), **state))
    if not any(boost):
        bodies.append(plane("wall", tuple(Q @ (1.0, 0.0, 0.0)), tuple(Q @ (WALL, 0.0, 0.0))))
    sim = simulation(*bodies, restitution=0.75)
    for _ in range(round(1.0 / dt)):
        sim.step(dt)
    rows = [sim.bodies.names.index(name) for name in names]
    return sim.bodies.position[rows]


def linear(Q: np.ndarray) -> float:
    """Mapped by a mirror or a turn."""
    return float(np.abs(ends(Q) - ends(np.eye(3)) @ Q.T).max())


def boosted() -> float:
    """All of it at another velocity, without the wall."""
    still = np.finfo(float).tiny  # leaves the wall out
    fast = (3.0, -2.0, 1.0)
    return float(np.abs(ends(np.eye(3), fast) - fast - ends(np.eye(3), (still, 0.0, 0.0))).max())


def renumbered() -> float:
    """Names in the other order."""
    return float(np.abs(ends(np.eye(3), names="zy") - ends(np.eye(3))).max())


def split(parts: int) -> float:
    """Steps in parts."""
    return float(np.abs(ends(np.eye(3), dt=0.1 / parts) - ends(np.eye(3))).max())


def reversed_in_time() -> float:
    """Forth, all velocities turned round, and back to the start."""

    def bricks(state):
        return [brick(name, SIZES[name], 1.0, **state[name]) for name in "ab"]

    start = {n: {"position": PLACES[n], "velocity": SPEEDS[n], "angular_velocity": SPINS[n]} for n in "ab"}
    sim = simulation(*bricks(start), restitution=1.0)
    for _ in range(10):
        sim.step(0.1)
    now = sim.bodies
    back = {
        name: {
            "position": now.position[k],
            "velocity": -now.velocity[k],
            "angular_velocity": -now.angular_velocity[k],
            "quaternion": now.quaternion[k],
        }
        for k, name in enumerate("ab")
    }
    sim = simulation(*bricks(back), restitution=1.0)
    for _ in range(10):
        sim.step(0.1)
    return float(np.abs(sim.bodies.position - [PLACES["a"], PLACES["b"]]).max())
