"""Exactly round balls beside meshes: impacts, rolling and rest against formulas, and what must be conserved."""

import numpy as np
import pytest
from played import energy, hits, momentum, play
from round_bodies import sphere
from scenes_by_hand import fixed_box, free_box, plane, scene_of, solid

from comotion_server.meshes import box
from comotion_server.quaternions import quaternion_of, rotation_from_quaternion
from comotion_server.scene import Fixed, SceneError
from comotion_server.simulation import Simulation

pytestmark = pytest.mark.timeout(900)  # a cold compile beside other work takes minutes
G = 9.81
CLOSE = 1e-8  # of lengths about 1: ten times the default tolerance, below which contacts are held


@pytest.mark.parametrize(("tolerance", "error"), [(1e-9, 1e-7), (1e-12, 1e-10)])
def test_44_bounces_on_a_mesh(tolerance, error):
    """t_n = t_1 (1 + 2 (e + ... + e^(n-1))), and rest after the last."""
    e, r = 0.9, 0.125
    floor = fixed_box("floor", (2.0, 2.0, 1.0), (0.3, 0.2, -0.5))
    sim = Simulation(
        scene_of(
            sphere(radius=r, position=(0, 0, 1 + r)), floor, gravity=(0, 0, -G), restitution=e, tolerance=tolerance
        )
    )
    found = hits(play(sim, 8.5, 0.01))
    expected = np.sqrt(2.0 / G) * (1.0 + 2.0 * np.cumsum([0.0, *e ** np.arange(1, 44)]))
    assert len(found) == 44
    np.testing.assert_allclose(found, expected, atol=error)
    play(sim, 0.2, 0.01)
    assert sim.bodies.velocity[0].tolist() == [0.0, 0.0, 0.0]
    assert 0.0 < sim.bodies.position[0, 2] - r < 10.0 * tolerance * 2.0 * r


@pytest.mark.parametrize("aside", [(1.0, 0.0), (1.0, 0.7)], ids=["edge", "corner"])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_ball_hits_an_edge_or_a_corner(aside, e):
    """The normal runs from the edge or corner to the centre: n = (d, h) / r with h^2 = r^2 - d^2."""
    r, off = 0.2, 0.1 * np.array([*aside, 0.0])
    h = np.sqrt(r * r - off @ off)
    up = np.array([0.0, 0.0, 1.0])
    n = (off + h * up) / r
    at = np.array([0.5, 0.5 if aside[1] else 0.1, 0.5]) + off
    ball = sphere(radius=r, mass=2.0, position=at + (h + 0.3) * up, velocity=(0.0, 0.0, -1.0))
    sim = Simulation(scene_of(ball, fixed_box("cube", (1, 1, 1), (0, 0, 0)), restitution=e))
    (impact,) = play(sim, 0.4, 0.01)
    assert impact.time == pytest.approx(0.3, abs=CLOSE)
    np.testing.assert_allclose(impact.normal, -n, atol=CLOSE)
    np.testing.assert_allclose(sim.bodies.velocity[0], [0, 0, -1] + (1.0 + e) * n[2] * n, atol=10 * CLOSE)
    np.testing.assert_array_equal(sim.bodies.angular_velocity[0], 0.0)


def test_a_ball_pushes_a_cube_that_is_free():
    """j = (1 + e) v / (1/m + 1/M + (r x n).I^-1 (r x n)) of a ball on the face of a cube, off its middle."""
    e, m, M, arm = 0.5, 1.0, 3.0, np.array([-0.5, 0.2, 0.3])
    cube = free_box("cube", (1, 1, 1), M, position=(0, 0, 0))
    ball = sphere(radius=0.1, mass=m, position=(-1.0, 0.2, 0.3), velocity=(1.0, 0, 0))
    sim = Simulation(scene_of(ball, cube, restitution=e))
    (impact,) = play(sim, 0.5, 0.01)
    lever = np.cross(arm, [1.0, 0.0, 0.0])
    j = (1.0 + e) / (1.0 / m + 1.0 / M + lever @ lever / (M / 6.0))
    assert impact.impulse == pytest.approx(j, rel=CLOSE)
    assert impact.time == pytest.approx(0.4, abs=CLOSE)
    np.testing.assert_allclose(sim.bodies.angular_velocity[1], j * lever / (M / 6.0), atol=CLOSE)


def test_sliding_down_an_incline():
    """x = g sin(a) t^2 / 2, without turning."""
    a, r = 0.3, 0.1
    turn = quaternion_of(np.array([0.0, a, 0.0]))
    R = rotation_from_quaternion(turn)
    slab = solid("slab", box([20.0, 2.0, 1.0]), density=1.0, motion=Fixed(), position=-R @ [0, 0, 0.5], quaternion=turn)
    ball = sphere(radius=r, position=R @ [-5.0, 0.3, r])
    sim = Simulation(scene_of(ball, slab, gravity=(0, 0, -G), restitution=0.0))
    play(sim, 1.0, 0.05)
    np.testing.assert_allclose(R.T @ sim.bodies.position[0], [-5.0 + 0.5 * G * np.sin(a), 0.3, r], atol=CLOSE)
    np.testing.assert_allclose(R.T @ sim.bodies.velocity[0], [G * np.sin(a), 0.0, 0.0], atol=CLOSE)
    np.testing.assert_array_equal(sim.bodies.angular_velocity[0], 0.0)


def test_friction_makes_it_roll():
    """From sliding at v to rolling at 5 v / 7."""
    ball = sphere(radius=0.2, position=(-2.0, 0.0, 0.7), velocity=(1.0, 0.0, 0.0))
    sim = Simulation(scene_of(ball, fixed_box("box", (8, 1, 1), (0, 0, 0)), gravity=(0, 0, -G), friction=0.3))
    play(sim, 1.0, 0.1)
    np.testing.assert_allclose(sim.bodies.velocity[0], [5.0 / 7.0, 0.0, 0.0], atol=CLOSE)
    np.testing.assert_allclose(sim.bodies.angular_velocity[0], [0.0, 5.0 / 1.4, 0.0], atol=CLOSE)


def test_over_the_edge_of_a_table_at_speed():
    """With v^2 > g r it leaves the edge at once, and falls on a parabola."""
    r, v = 0.1, 1.0
    ball = sphere(radius=r, position=(0.3, 0.0, 0.5 + r), velocity=(v, 0.0, 0.0))
    sim = Simulation(scene_of(ball, fixed_box("table", (1, 1, 1), (0, 0, 0)), gravity=(0, 0, -G)))
    play(sim, 0.5, 0.01)
    fallen = 0.5 - 0.2 / v
    np.testing.assert_allclose(sim.bodies.position[0], [0.8, 0.0, 0.5 + r - 0.5 * G * fallen**2], atol=CLOSE)


def test_over_the_edge_of_a_table_slowly():
    """It turns about the edge on a circle, and leaves where cos(angle) = 2/3 + v^2 / (3 g r); energy is kept."""
    r, v = 0.1, 0.3
    ball = sphere(radius=r, position=(0.45, 0.0, 0.5 + r), velocity=(v, 0.0, 0.0))
    sim = Simulation(scene_of(ball, fixed_box("table", (1, 1, 1), (0, 0, 0)), gravity=(0, 0, -G)))
    start, last = energy(sim), None
    for _ in range(4000):
        out = sim.step(0.0002)
        arm = sim.bodies.position[0, [0, 2]] - 0.5
        if sim.bodies.position[0, 0] > 0.5 and out.contacts:
            assert np.hypot(*arm) == pytest.approx(r, abs=CLOSE)
            last = arm[1] / np.hypot(*arm)
    assert last == pytest.approx(2.0 / 3.0 + v * v / (3.0 * G * r), abs=2e-3)  # a step of 0.2 ms earlier or later
    assert energy(sim) == pytest.approx(start, abs=1e-9)


def test_balls_and_cubes_in_a_box_of_planes():
    rng, bodies = np.random.default_rng(2), []
    for i, place in enumerate(np.ndindex(3, 3, 3)):
        state = {"position": np.array(place) - 1.0 + 0.05 * rng.uniform(-1, 1, 3), "velocity": rng.normal(size=3)}
        if i % 2:
            bodies.append(sphere(f"ball {i}", 0.3, **state))
        else:
            bodies.append(free_box(f"cube {i}", (0.4, 0.4, 0.4), 1.0, angular_velocity=rng.normal(size=3), **state))
    walls = [
        plane(f"wall {k}{side}", side * np.eye(3)[k], -1.6 * side * np.eye(3)[k]) for k in range(3) for side in (1, -1)
    ]
    sim = Simulation(scene_of(*bodies, *walls, restitution=1.0))
    start, before, pushed, count = energy(sim), momentum(sim), np.zeros(3), 0
    for _ in range(20):
        for impact in sim.step(0.05).impacts:
            count += 1
            push = impact.impulse * impact.normal  # on b
            pushed += push if impact.body_a.startswith("wall") else 0.0
            pushed -= push if impact.body_b.startswith("wall") else 0.0
    assert count > 60
    assert energy(sim) == pytest.approx(start, rel=1e-13)
    np.testing.assert_allclose(momentum(sim), before + pushed, atol=1e-12)


def test_at_rest_between_walls():
    """Two balls on each other and two walls: what is held carries the weight of both."""
    walls = [fixed_box(f"wall {side}", (0.1, 1, 1), (0.3 * side, 0, 1)) for side in (-1, 1)]
    balls = sphere("a", 0.2, position=(0, 0, 0.9)), sphere("b", 0.2, position=(0.01, 0, 1.5))
    scene = scene_of(*balls, *walls, fixed_box("floor", (1, 1, 1), (0, 0, 0)), gravity=(0, 0, -G), restitution=0.3)
    sim = Simulation(scene)
    play(sim, 4.0, 0.1)
    assert np.abs(sim.bodies.velocity).max() == 0.0
    held = {(c.body_a, c.body_b): c.held for c in sim.step(0.1).contacts}
    assert len(held) == 4
    assert abs(held["a", "floor"][2]) == pytest.approx(2.0 * G * 0.1, rel=1e-9)


@pytest.mark.parametrize("at", [(0, 0, 0.65), (0, 0, 0), (0.6, 0.6, 0.6)], ids=["in a face", "inside", "on a corner"])
def test_overlap_at_the_start(at):
    with pytest.raises(SceneError, match='bodies "ball" and "cube": '):
        Simulation(scene_of(sphere(radius=0.2, position=at), fixed_box("cube", (1, 1, 1), (0, 0, 0))))


def test_a_ball_may_begin_on_a_mesh():
    sim = Simulation(
        scene_of(sphere(radius=0.2, position=(0, 0, 0.7)), fixed_box("cube", (1, 1, 1), (0, 0, 0)), gravity=(0, 0, -G))
    )
    assert len(play(sim, 0.5, 0.1)) <= 1
    np.testing.assert_allclose(sim.bodies.position[0], (0, 0, 0.7), atol=CLOSE)
