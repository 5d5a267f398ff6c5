"""Cubes in a row: cradle, Galperin's pi, collapse, and the staircase of floes (VALIDATION B and F)."""

from fractions import Fraction

import numpy as np
import pytest
from played import hits, momentum, play
from scenes_by_hand import free_box, moved_box, plane, scene_of

from comotion_server.scene import Free
from comotion_server.simulation import Simulation

CUBE = (1.0, 1.0, 1.0)
EXACT = 1e-9  # what meshes at the default tolerance have to reach
SLIDING = Free(locked=(False, True, True, True, True, True))  # along x alone


def row(velocities, gap, masses=None, motion=None, **collisions):
    """Cubes along x with equal gaps."""
    masses = masses or [1.0] * len(velocities)
    cubes = [
        free_box(f"c{k}", CUBE, mass, position=(k * (1.0 + gap), 0.0, 0.0), velocity=(v, 0.0, 0.0), motion=motion)
        for k, (v, mass) in enumerate(zip(velocities, masses, strict=True))
    ]
    return Simulation(scene_of(*cubes, **collisions))


def one_after_the_other(velocities, restitution, gap=Fraction(1)):
    """Equal points on a line with equal gaps, every hit by itself, in exact numbers: velocities in the end, hits."""
    v = [Fraction(x) for x in velocities]
    x = [k * gap for k in range(len(v))]
    e, count = Fraction(restitution), 0
    while True:
        left = [(Fraction(x[k + 1] - x[k], 1) / (v[k] - v[k + 1]), k) for k in range(len(v) - 1) if v[k] > v[k + 1]]
        if not left:
            return [float(u) for u in v], count
        seconds, k = min(left)
        x = [place + u * seconds for place, u in zip(x, v, strict=True)]
        middle, half = (v[k] + v[k + 1]) / 2, e * (v[k] - v[k + 1]) / 2
        v[k], v[k + 1] = middle - half, middle + half
        count += 1


@pytest.mark.parametrize("motion", [None, SLIDING], ids=["free", "sliding"])
@pytest.mark.parametrize("gap", [0.0, 0.125, 1e-12])
@pytest.mark.parametrize(
    ("before", "after"),
    [((1, 0, 0, 0, 0), (0, 0, 0, 0, 1)), ((1, 1, 0, 0, 0), (0, 0, 0, 1, 1)), ((1, 0, -1), (-1, 0, 1))],
)
def test_cradle(before, after, gap, motion):
    sim = row(before, gap, motion=motion, restitution=1.0)
    play(sim, 1.0, 0.05)
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], after, atol=EXACT)
    np.testing.assert_allclose(sim.bodies.velocity[:, 1:], 0.0, atol=EXACT)
    np.testing.assert_allclose(sim.bodies.angular_velocity, 0.0, atol=EXACT)


@pytest.mark.parametrize("gap", [0.0, 0.125])
def test_a_cradle_with_losses_is_the_limit_of_small_gaps(gap):
    exact, count = one_after_the_other((1, 0, 0, 0, 0), Fraction(1, 2))
    assert count == 10
    sim = row((1, 0, 0, 0, 0), gap, restitution=0.5)
    play(sim, 10.0, 0.05)
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], exact, atol=EXACT)


def test_sequential_gives_the_same_in_a_row():
    sim = row((1, 0, 0, 0, 0), 0.0, restitution=1.0, simultaneous="sequential")
    impacts = play(sim, 0.2, 0.05)
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], (0, 0, 0, 0, 1), atol=EXACT)
    assert {impact.law for impact in impacts} == {"sequential"}


@pytest.mark.parametrize(("digits", "count"), [(0, 3), (1, 31), (2, 314), (3, 3141)])
def test_hits_count_the_digits_of_pi(digits, count):
    """Galperin: a wall, mass 1 at rest, mass 100^k coming."""
    wall = plane("wall", (1.0, 0.0, 0.0), (-1.5, 0.0, 0.0))
    light = free_box("light", CUBE, 1.0, motion=SLIDING)
    heavy = free_box("heavy", CUBE, 100.0**digits, position=(2.0, 0.0, 0.0), velocity=(-1.0, 0, 0), motion=SLIDING)
    sim = Simulation(scene_of(wall, light, heavy, restitution=1.0))
    impacts = play(sim, 30.0, 0.1)
    assert len(hits(impacts)) == count
    assert max(step_books(sim)) <= 1e-12


def step_books(sim):
    books = sim.step(0.1).books
    return books.momentum, books.energy


@pytest.mark.parametrize("e", [0.02, 0.05, 0.0717])
def test_three_cubes_collapse_below_e_of_7_minus_4_sqrt_3(e):
    """Infinitely many hits in finite time: bounded work, momentum to rounding, and one velocity for all."""
    sim = row((1, 0, 0), 0.125, restitution=e, motion=SLIDING)
    out = [sim.step(0.05) for _ in range(60)]
    assert sum(step.budget.used for step in out) < 200
    assert not any(step.budget.exhausted for step in out)
    np.testing.assert_allclose(momentum(sim), [1.0, 0.0, 0.0], atol=1e-13)
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], 1 / 3, atol=1e-8)  # the gaps left, 1e-9, over the time played


def test_above_it_the_hits_are_counted():
    exact, count = one_after_the_other((1, 0, 0), Fraction(1, 5))
    assert count == 3
    sim = row((1, 0, 0), 0.125, restitution=0.2, motion=SLIDING)
    assert len(hits(play(sim, 20.0, 0.1))) == count
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], exact, atol=EXACT)


FLOES, SPEED, MASS, GAP = 6, 1.0, 10.0, 0.1875


def staircase(e, hull=None):
    """A hull before a row of equal floes of mass 1 with equal gaps."""
    hull = hull or free_box("hull", CUBE, MASS, position=(-1.0 - GAP, 0, 0), velocity=(SPEED, 0, 0))
    floes = [free_box(f"ice-{k}", CUBE, 1.0, position=(k * (1.0 + GAP), 0.0, 0.0)) for k in range(FLOES)]
    return Simulation(scene_of(hull, *floes, restitution=e))


def test_a_hull_gathers_floes():
    """e = 0: V_k = M U / (M + k m), and floe k is hit after the sum of d / V."""
    impacts = play(staircase(0.0), 2.0, 0.005)
    speeds = MASS * SPEED / (MASS + np.arange(FLOES + 1))
    exact = np.cumsum(GAP / speeds[:-1])
    first = hits([i for i in impacts if i.body_a == "hull"], "hull", "ice-0")[0]
    found = [first, *(hits(impacts, f"ice-{k}", f"ice-{k + 1}")[0] for k in range(FLOES - 1))]
    np.testing.assert_allclose(found, exact, atol=EXACT * FLOES)
    sim = staircase(0.0)
    for k, at in enumerate(exact):
        sim.step(at - sim.time + 1e-6)
        np.testing.assert_allclose(sim.bodies.velocity[: k + 2, 0], speeds[k + 1], atol=EXACT)


def test_a_hull_loses_the_same_share_to_every_floe():
    """e = 1: a floe hands its speed on and stands where the next one was, so V_k = U ((M - m) / (M + m))^k."""
    sim = staircase(1.0)
    share = (MASS - 1.0) / (MASS + 1.0)
    exact = np.cumsum(GAP / (SPEED * share ** np.arange(FLOES)))
    impacts = play(sim, exact[-1] + 0.01, 0.005)
    np.testing.assert_allclose(hits(impacts, "hull"), exact, atol=1e-8)
    assert sim.bodies.velocity[0, 0] == pytest.approx(SPEED * share**FLOES, abs=EXACT)


@pytest.mark.parametrize("e", [0.0, 1.0])
def test_mean_resistance_of_a_driven_hull(e):
    """(1 + e) m U^2 / d: every d / U the hull gives the next floe (1 + e) m U, alone or through those it pushes."""
    hull = moved_box("hull", CUBE, (-1.0 - GAP, 0.0, 0.0), (SPEED, 0.0, 0.0))
    sim = staircase(e, hull)
    total = np.zeros(3)
    for _ in range(round((FLOES + 0.5) * GAP / SPEED / 0.005)):
        for contact in sim.step(0.005).contacts:
            if contact.body_a == "hull":
                total -= contact.impulse
    np.testing.assert_allclose(total, [-(1.0 + e) * SPEED * FLOES, 0.0, 0.0], atol=1e-8)
