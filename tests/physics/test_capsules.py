"""Capsules on planes, meshes, balls and each other, against formulas."""

import numpy as np
import pytest
from played import energy, momentum, play
from round_bodies import capsule, sphere
from scenes_by_hand import fixed_box, free_box, plane, scene_of

from comotion_server.quaternions import quaternion_of
from comotion_server.scene import SceneError
from comotion_server.simulation import Simulation

pytestmark = pytest.mark.timeout(900)  # a cold compile beside other work takes minutes
G = 9.81
CLOSE = 1e-8  # of lengths about 1: ten times the default tolerance, below which contacts are held
FLOORS = {"plane": plane(), "mesh": fixed_box("floor", (4.0, 4.0, 1.0), (0.0, 0.0, -0.5))}
RADIUS, LENGTH, MASS = 0.1, 1.0, 2.0


@pytest.mark.parametrize("floor", FLOORS)
def test_dropped_flat_it_stays_flat(floor):
    rod = capsule(position=(0.2, 0.1, 0.6), velocity=(0, 0, -1), quaternion=quaternion_of(np.array([0, 0, 0.3])))
    sim = Simulation(scene_of(rod, FLOORS[floor], restitution=0.5))
    impacts = play(sim, 1.0, 0.01)
    assert len(impacts) == 2
    np.testing.assert_allclose([impact.time for impact in impacts], 0.5, atol=CLOSE)
    np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(sim.bodies.angular_velocity[0], 0.0, atol=1e-12)


@pytest.mark.parametrize("floor", FLOORS)
def test_it_comes_to_rest_flat(floor):
    sim = Simulation(scene_of(capsule(position=(0, 0, 0.6)), FLOORS[floor], gravity=(0, 0, -G), restitution=0.5))
    play(sim, 3.0, 0.05)
    assert np.abs(sim.bodies.velocity[0]).max() == 0.0
    assert 0.0 < sim.bodies.position[0, 2] - RADIUS < 1e-8 * 1.2
    np.testing.assert_allclose(np.abs(sim.bodies.quaternion[0]), [1, 0, 0, 0], atol=1e-12)
    (contact,) = sim.step(0.1).contacts
    assert abs(contact.held[2]) == pytest.approx(MASS * G * 0.1, rel=1e-12)


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_tilted_one_falls_on_an_end(floor, e):
    """j = (1 + e) v / (1/m + (L cos(a) / 2)^2 / I): the ball at its end is right above the point of contact."""
    a = 0.4
    rod = capsule(
        position=(0, 0, 0.3 + 0.5 * LENGTH * np.sin(a) + RADIUS),
        quaternion=quaternion_of(np.array([0.0, a, 0.0])),
        velocity=(0.0, 0.0, -1.0),
    )
    sim = Simulation(scene_of(rod, FLOORS[floor], restitution=e))
    (impact, *_) = play(sim, 0.301, 0.001)
    arm, inertia = 0.5 * LENGTH * np.cos(a), rod.inertia[1, 1]
    j = (1.0 + e) / (1.0 / MASS + arm**2 / inertia)
    assert impact.time == pytest.approx(0.3, abs=CLOSE)
    assert impact.impulse == pytest.approx(j, rel=CLOSE)
    if e > 0.0:  # else the end rests, and is pulled round
        np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 0.0, j / MASS - 1.0], atol=CLOSE)
        np.testing.assert_allclose(sim.bodies.angular_velocity[0], [0.0, -arm * j / inertia, 0.0], atol=CLOSE)


def test_two_that_cross():
    """They meet at r_a = 0.2 x and r_b = -0.1 y: j = (1 + e) v / (1/m_a + 1/m_b + r_a^2 / I_a + r_b^2 / I_b)."""
    e, low = 0.5, capsule("low", axis=0)
    high = capsule("high", mass=1.0, axis=1, position=(0.2, 0.1, 0.5), velocity=(0, 0, -1))
    sim = Simulation(scene_of(low, high, restitution=e))
    (impact,) = play(sim, 0.4, 0.01)
    j = (1.0 + e) / (1.0 / 2.0 + 1.0 + 0.2**2 / low.inertia[1, 1] + 0.1**2 / high.inertia[0, 0])
    assert impact.time == pytest.approx(0.3, abs=CLOSE)
    assert impact.impulse == pytest.approx(j, rel=CLOSE)
    np.testing.assert_allclose(np.abs(impact.normal), [0, 0, 1], atol=1e-14)
    w = dict(zip(sim.bodies.names, sim.bodies.angular_velocity, strict=True))
    np.testing.assert_allclose(w["low"], [0.0, 0.2 * j / low.inertia[1, 1], 0.0], atol=CLOSE)
    np.testing.assert_allclose(w["high"], [-0.1 * j / high.inertia[0, 0], 0.0, 0.0], atol=CLOSE)


@pytest.mark.parametrize(("x", "beyond"), [(0.2, 0.0), (0.6, 0.1)], ids=["between the ends", "beyond an end"])
def test_a_ball_falls_on_one(x, beyond):
    """As on a ball about the foot on its middle line, but for the inertia: n = (beyond, 0.1, h) / (r + R)."""
    e, reach = 0.5, RADIUS + 0.2
    ball = sphere(radius=0.2, position=(x, 0.1, 0.5), velocity=(0, 0, -1))
    rod = capsule()
    sim = Simulation(scene_of(rod, ball, restitution=e))
    (impact,) = play(sim, 0.4, 0.01)
    h = np.sqrt(reach**2 - 0.01 - beyond**2)
    n, arm = np.array([beyond, 0.1, h]) / reach, np.array([x - beyond, 0, 0])
    lever = np.cross(arm, n)
    j = (1.0 + e) * n[2] / (1.0 + 1.0 / MASS + lever @ np.linalg.solve(rod.inertia, lever))
    assert impact.time == pytest.approx(0.5 - h, abs=CLOSE)
    assert impact.impulse == pytest.approx(j, rel=CLOSE)
    np.testing.assert_allclose(impact.normal, -n if impact.body_a == "ball" else n, atol=CLOSE)
    v = sim.bodies.velocity[sim.bodies.names.index("ball")]
    np.testing.assert_allclose(v, np.array([0, 0, -1]) + j * n, atol=CLOSE)


def test_where_the_foot_is_fixed_it_is_a_ball_on_a_ball():
    """Against the middle of a capsule, through whose centre the impulse goes, and against a sphere."""
    found = []
    for low in (capsule("low", mass=2.0), sphere("low", 0.1, 2.0)):
        ball = sphere("top", 0.2, position=(0.0, 0.1, 0.5), velocity=(0, 0, -1))
        sim = Simulation(scene_of(low, ball, fixed_box("away", (1, 1, 1), (9, 9, 9)), restitution=0.5))
        (impact,) = play(sim, 0.4, 0.01)
        found.append((impact.time, impact.impulse, *sim.bodies.velocity.ravel()))
    np.testing.assert_allclose(found[0], found[1], atol=CLOSE)


def test_parallel_ones_touch_along_a_stretch():
    """From x = -0.1 to 0.5: with e = 0 they go on as one: (v, w) of one rigid body."""
    low, high = capsule("low"), capsule("high", mass=1.0, position=(0.4, 0, 0.5), velocity=(0, 0, -1))
    sim = Simulation(scene_of(low, high, restitution=0.0))
    impacts = [*play(sim, 0.29, 0.01), *sim.step(0.01001).impacts]
    assert sorted(impact.point[0] for impact in impacts[:2]) == pytest.approx([-0.1, 0.5], abs=CLOSE)
    centre = 0.4 / 3.0  # of both masses, along x
    inertia = low.inertia[1, 1] + high.inertia[1, 1] + 2.0 * centre**2 + (0.4 - centre) ** 2
    spin = (0.4 - centre) / inertia
    np.testing.assert_allclose(sim.bodies.angular_velocity[:, 1], spin, rtol=1e-5)  # 10 microseconds later
    assert momentum(sim)[2] == pytest.approx(-1.0, abs=1e-12)


def test_over_the_edge_of_a_table():
    """Lying across the edge it stays while its centre is over the table, else it tips over."""
    for x, stays in ((0.3, True), (0.6, False)):
        table = fixed_box("table", (1, 1, 1), (0, 0, 0))
        sim = Simulation(scene_of(capsule(position=(x, 0, 0.5 + RADIUS)), table, gravity=(0, 0, -G)))
        start = energy(sim)
        play(sim, 0.2, 0.02)
        assert energy(sim) == pytest.approx(start, abs=1e-7)
        if stays:
            np.testing.assert_allclose(
                sim.bodies.position[1 - sim.bodies.names.index("table")], (x, 0, 0.6), atol=CLOSE
            )
        else:
            row = sim.bodies.names.index("capsule")
            assert sim.bodies.angular_velocity[row, 1] > 0.1
            assert sim.bodies.position[row, 2] < 0.6 - 1e-3


def test_a_heap_in_a_box_of_planes_keeps_its_energy():
    rng, bodies = np.random.default_rng(3), []
    for i, place in enumerate(np.ndindex(3, 3, 3)):
        state = {
            "position": np.array(place) - 1.0 + 0.05 * rng.uniform(-1, 1, 3),
            "velocity": rng.normal(size=3),
            "angular_velocity": rng.normal(size=3),
        }
        if i % 3 == 0:
            bodies.append(sphere(f"ball {i}", 0.3, **state))
        elif i % 3 == 1:
            bodies.append(free_box(f"cube {i}", (0.4, 0.4, 0.4), 1.0, **state))
        else:
            bodies.append(capsule(f"rod {i}", 0.15, 0.4, 1.0, i % 2, **state))
    walls = [
        plane(f"wall {k}{side}", side * np.eye(3)[k], -1.6 * side * np.eye(3)[k]) for k in range(3) for side in (1, -1)
    ]
    sim = Simulation(scene_of(*bodies, *walls, restitution=1.0))
    start = energy(sim)
    assert len(play(sim, 1.0, 0.05)) > 60
    assert energy(sim) == pytest.approx(start, rel=1e-12)


OTHERS = {
    "plane": FLOORS["plane"],
    "mesh": FLOORS["mesh"],
    "ball": sphere(position=(0.6, 0, 0.0)),
    "rod": capsule("other", axis=1, position=(0.3, 0, 0.1)),
}


@pytest.mark.parametrize("other", OTHERS)
def test_overlap_at_the_start(other):
    with pytest.raises(SceneError, match="overlap at the start"):
        Simulation(scene_of(capsule(position=(0, 0, 0.05)), OTHERS[other]))


def test_inside_a_mesh_at_the_start():
    with pytest.raises(SceneError, match="is inside the second at the start"):
        Simulation(scene_of(capsule(), fixed_box("hall", (3, 3, 3), (0, 0, 0))))
