"""A meshed ball bounces on a floor: every impact at its time, and rest after the last (VALIDATION B)."""

import numpy as np
import pytest
from played import hits, play
from scenes_by_hand import fixed_box, free_box, plane, scene_of, solid

from comotion_mock_cfd.body_forms import ball_mesh
from comotion_server.meshes import TriangleMesh
from comotion_server.scene import Free
from comotion_server.simulation import Simulation

G, HEIGHT, E = 9.81, 1.0, 0.9  # the published run: 44 impacts up to 8.5 s
FIRST = np.sqrt(2.0 * HEIGHT / G)
END_OF_BOUNCING = FIRST * (1.0 + E) / (1.0 - E)
RADIUS = 0.125
UPRIGHT = Free(locked=(False, False, False, True, True, True))  # a corner that lands tilted would tilt ever more
REST = 1e-8  # of the diameter: ten times the tolerance, the gap below which contacts are held


def exact_times(count):
    """t_n = t_1 (1 + 2 (e + ... + e^(n-1)))."""
    return FIRST * (1.0 + 2.0 * np.cumsum([0.0, *E ** np.arange(1, count)]))


def ball(motion=UPRIGHT, **state):
    return solid("ball", TriangleMesh(*ball_mesh(RADIUS)), mass=1.0, motion=motion, **state)


def bouncing(floor, **collisions):
    at = (0.0, 0.0, HEIGHT + RADIUS)
    return Simulation(scene_of(ball(position=at), floor, gravity=(0, 0, -G), restitution=E, **collisions))


FLOORS = {"plane": plane(), "mesh": fixed_box("floor", (2.0, 2.0, 1.0), (0.3, 0.2, -0.5))}


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize(("tolerance", "error"), [(1e-9, 1e-7), (1e-12, 1e-10)])
def test_44_impacts_at_their_times(floor, tolerance, error):
    found = hits(play(bouncing(FLOORS[floor], tolerance=tolerance), 8.5, 0.01))
    assert len(found) == 44
    np.testing.assert_allclose(found, exact_times(44), atol=error)


def test_the_step_does_not_matter_to_the_impacts():
    found = [hits(play(bouncing(plane()), 7.0, dt)) for dt in (0.5, 0.1, 0.01)]
    for others in found[1:]:
        np.testing.assert_allclose(others, found[0], atol=1e-12)  # the promise where no contact is held


def test_at_rest_after_the_last_hop():
    sim = bouncing(plane())
    play(sim, 8.59, 0.01)
    assert sim.time > END_OF_BOUNCING
    assert sim.bodies.velocity[0].tolist() == [0.0, 0.0, 0.0]
    at = sim.bodies.position[0]
    assert 0.0 < at[2] - RADIUS < REST * 2 * RADIUS
    out = [sim.step(0.01) for _ in range(1000)]
    np.testing.assert_array_equal(sim.bodies.position[0], at)
    assert not any(step.impacts for step in out)


def test_a_held_contact_carries_the_weight():
    sim = bouncing(plane())
    play(sim, 8.6, 0.01)
    (contact,) = sim.step(0.01).contacts
    assert contact.count == 0
    np.testing.assert_allclose(contact.held, contact.impulse)
    # `a` is the ball, `b` the floor: the weight presses on the floor
    np.testing.assert_allclose(contact.impulse, [0.0, 0.0, -G * 0.01], rtol=1e-12, atol=1e-15)


def test_an_elastic_ball_keeps_its_height():
    height, dt = 0.01, 0.1
    scene = scene_of(ball(position=(0, 0, height + RADIUS)), plane(), gravity=(0, 0, -G), restitution=1.0)
    sim = Simulation(scene)
    found = hits(play(sim, 200.0, dt))
    assert len(found) > 2000
    z, v = sim.bodies.position[0, 2] - RADIUS, sim.bodies.velocity[0, 2]
    assert z + v * v / (2 * G) == pytest.approx(height, rel=1e-12)
    hop = np.sqrt(8.0 * height / G)
    # every hop is longer or shorter by the gap that counts as contact, over the speed: a constant share of 1e-9
    np.testing.assert_allclose(np.diff(found), hop, rtol=1e-8)
    np.testing.assert_allclose(np.diff(found), np.diff(found)[0], rtol=1e-10)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("floor", FLOORS)
def test_a_flat_cube_bounces_without_turning(floor, e):
    """v+ = 2 e from v = -2: the patch carries the torque, no criterion does."""
    cube = free_box("cube", (1, 1, 1), 1.0, position=(0.1, 0.05, 0.7), velocity=(0.0, 0.0, -2.0))
    sim = Simulation(scene_of(cube, FLOORS[floor], restitution=e))
    impacts = play(sim, 0.2, 0.01)
    assert {round(impact.time, 9) for impact in impacts} == {0.1}
    np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 0.0, 2.0 * e], atol=1e-14)
    np.testing.assert_allclose(sim.bodies.angular_velocity[0], 0.0, atol=1e-14)


def test_a_flat_cube_comes_to_rest_flat():
    cube = free_box("cube", (1, 1, 1), 1.0, position=(0.0, 0.0, 0.6))
    sim = Simulation(scene_of(cube, plane(), gravity=(0, 0, -G), restitution=0.5))
    play(sim, 2.0, 0.01)
    assert np.abs(sim.bodies.velocity[0]).max() == 0.0
    assert 0.0 < sim.bodies.position[0, 2] - 0.5 < REST * np.sqrt(3.0)
    np.testing.assert_allclose(np.abs(sim.bodies.quaternion[0]), [1, 0, 0, 0], atol=1e-12)
