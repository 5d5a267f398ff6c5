"""Scenes with a known answer, in the words of no engine: rigid bodies, walls, and how wrong a run was.

`bounce`: one ball, e = 0.9, from 1 m; the answer is when it lands. `balls49` and `balls216`: the bouncing and the
elastic 666 test of SimBenchmark (leggedrobotics.github.io/SimBenchmark), e = 1; the answer is the energy. `tumble`:
eight jacks in a closed box, e = 1, the same. `pile`: ten boxes stand on each other, e = 0; the answer is that they do
not move.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from comotion_mock_cfd.body_forms import ball_mesh, jack_mesh
from comotion_mock_cfd.box_form import box_mesh

G = 9.81
HEIGHT, REBOUND, LANDINGS = 1.0, 0.9, 10  # of `bounce`: from where, e, and how many landings are judged
CELL = 1 / 16  # [m] of the jack


@dataclass(frozen=True)
class Part:
    """A sphere of a radius, or a box with edges [m], about a place in the body: what other engines take for a mesh."""

    size: float | tuple[float, float, float]
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Thing:
    """A rigid body: parts and mesh about its centre of mass, mass [kg], principal moments [kg m2] along its axes."""

    parts: tuple[Part, ...]
    mesh: tuple[np.ndarray, np.ndarray]
    mass: float
    moments: tuple[float, float, float]
    position: np.ndarray
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class State:
    """Of all things: centres (n,3), rotations (n,3,3) body to world, velocities and angular velocities (n,3), world."""

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


@dataclass
class Case:
    """A scene, its duration [s], what of a run is looked at, and the error made of it."""

    things: list[Thing]
    restitution: float
    duration: float
    error_name: str
    error: Callable[["Case", list[float], list[State]], float]
    walls: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = field(
        default_factory=lambda: [((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))]
    )  # normal out of the solid, and a point
    samples: int | None = 200  # over the duration; None: every step
    friction: float = 0.0

    def energy(self, state: State) -> float:
        """Kinetic and potential [J]."""
        masses = np.array([thing.mass for thing in self.things])
        moments = np.array([thing.moments for thing in self.things])
        spin_body = np.einsum("nji,nj->ni", state.rotation, state.spin)
        kinetic = 0.5 * masses @ (state.velocity**2).sum(axis=1) + 0.5 * (moments * spin_body**2).sum()
        return float(kinetic + G * masses @ state.position[:, 2])


def energy_error(case, times, states):
    """RMS over the samples, relative to the energy at the start."""
    energies = np.array([case.energy(state) for state in states])
    return float(np.sqrt(np.mean((energies / energies[0] - 1.0) ** 2)))


def landing_error(case, times, states):
    """Largest error of the landings' times [s]: on along the parabola that the ball is on at the top of each hop."""
    radius = case.things[0].parts[0].size
    z = np.array([state.position[0, 2] for state in states]) - radius
    v = np.array([state.velocity[0, 2] for state in states])
    top = np.flatnonzero((v[1:] <= 0.0) & (v[:-1] > 0.0) & (z[1:] > 0.0))[: LANDINGS - 1] + 1
    if len(top) < LANDINGS - 1:
        return np.inf
    top = np.array([0, *top])
    found = np.array(times)[top] + (v[top] + np.sqrt(v[top] ** 2 + 2 * G * z[top])) / G
    first = np.sqrt(2.0 * HEIGHT / G)
    exact = first * (1.0 + 2.0 * np.cumsum([0.0, *REBOUND ** np.arange(1, LANDINGS)]))
    return float(np.abs(found - exact).max())


def drift(case, times, states):
    """Largest distance [m] that a body has moved."""
    moved = states[-1].position - states[0].position
    return float(np.linalg.norm(moved, axis=1).max())


def ball(radius, mass, position):
    moment = 0.4 * mass * radius**2
    return Thing((Part(radius),), ball_mesh(radius), mass, (moment, moment, moment), np.array(position))


def bounce():
    """A ball of 0.125 m bounces ten times from 1 m."""
    radius = 0.125
    return Case([ball(radius, 1.0, (0, 0, HEIGHT + radius))], REBOUND, 7.0, "landing [s]", landing_error, samples=None)


def balls49():
    """7 x 7 balls 2 m apart fall from 5 m, for 20 s."""
    things = [ball(0.1, 10.0, (2.0 * i, 2.0 * j, 5.0)) for i, j in product(range(7), repeat=2)]
    return Case(things, 1.0, 20.0, "energy", energy_error)


def balls216():
    """6 x 6 x 6 balls, 10 mm apart but for 1 mm at random, fall from 1 m and scatter, for 10 s."""
    random = np.random.default_rng(42)
    places = [np.array((i, j, k)) * 0.21 + (0.0, 0.0, 1.101) for i, j, k in product(range(6), repeat=3)]
    things = [ball(0.1, 10.0, place + random.uniform(0.0, 1e-3, 3)) for place in places]
    return Case(things, 1.0, 10.0, "energy", energy_error)


def tumble():
    """Eight jacks of seven cubes fly about in a closed box of 1 m, for 3 s."""
    arms = [tuple(sign * CELL * (axis == k) for k in range(3)) for axis in range(3) for sign in (-1, 1)]
    parts = tuple(Part((CELL, CELL, CELL), at) for at in ((0.0, 0.0, 0.0), *arms))
    mass = 7 * 900.0 * CELL**3
    moment = mass / 7 * CELL**2 * (7 / 6 + 4)  # of seven cubes, four of them a cell away from any axis
    things = [
        Thing(parts, jack_mesh(CELL), mass, (moment,) * 3, np.array(at), (1.0, 0.5, 0.0), (4.0, 1.0, 2.0))
        for at in product((-0.25, 0.25), repeat=3)
    ]
    walls = [
        (tuple(-sign * (axis == k) + 0.0 for k in range(3)), tuple(0.5 * sign * (axis == k) for k in range(3)))
        for axis in range(3)
        for sign in (-1, 1)
    ]
    return Case(things, 1.0, 3.0, "energy", energy_error, walls)


def pile():
    """Ten boxes stand on each other and on the floor, for 5 s."""
    edges = (0.4, 0.4, 0.1)
    a, b, c = (edge**2 / 12 for edge in edges)
    things = [
        Thing((Part(edges),), box_mesh(edges), 16.0, (16 * (b + c), 16 * (a + c), 16 * (a + b)), np.array((0, 0, z)))
        for z in 0.05 + 0.1 * np.arange(10)
    ]
    return Case(things, 0.0, 5.0, "drift [m]", drift, friction=0.5)


CASES = {case.__name__: case for case in (bounce, balls49, balls216, tumble, pile)}
