"""Bodies that merge move as one: combined mass, centre, velocity and inertia (P11, VALIDATION B)."""

import numpy as np
import pytest
from played import play
from scenes_by_hand import fixed_box, free_box, scene_of

from comotion_server.quaternions import rotation_from_quaternion
from comotion_server.simulation import Simulation

EXACT = 1e-9  # what meshes at the default tolerance have to reach


def three(a_first):
    """A and B meet off centre, later C joins; or B and C meet first, and A joins."""
    near, far = (0.1, 0.4) if a_first else (0.4, 0.1)
    a = free_box("a", (1.0, 1.0, 1.0), 1.0, position=(-1.0 - near, 0.2, 0.1), velocity=(1.0, 0.0, 0.0))
    b = free_box("b", (1.0, 2.0, 1.0), 2.0)
    c = free_box("c", (1.0, 1.0, 2.0), 1.5, position=(1.0 + far, -0.3, 0.2), velocity=(-1.0, 0.0, 0.0))
    return Simulation(scene_of(a, b, c, restitution=0.0, merge=True))


def totals(sim):
    """Mass, centre, momentum, angular momentum about the centre, inertia about the centre."""
    m, x, v, w = sim.bodies.mass, sim.bodies.position, sim.bodies.velocity, sim.bodies.angular_velocity
    centre = m @ x / m.sum()
    L, J = np.zeros(3), np.zeros((3, 3))
    for k, body in enumerate(sim.scene.bodies):
        R = rotation_from_quaternion(sim.bodies.quaternion[k])
        own, arm = R @ body.inertia @ R.T, x[k] - centre
        L += own @ w[k] + m[k] * np.cross(arm, v[k])
        J += own + m[k] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return m.sum(), centre, m @ v, L, J


@pytest.mark.parametrize("a_first", [True, False])
def test_what_has_merged_moves_as_one_body(a_first):
    sim = three(a_first)
    mass, centre, p, L, _ = totals(sim)
    play(sim, 0.6, 0.01)
    _, centre_now, p_now, L_now, J = totals(sim)
    np.testing.assert_allclose(p_now, p, atol=1e-13)
    np.testing.assert_allclose(L_now, L, atol=1e-9)
    np.testing.assert_allclose(centre_now, centre + p / mass * sim.time, atol=EXACT)
    spin = np.linalg.solve(J, L_now)
    for k in range(3):
        np.testing.assert_allclose(sim.bodies.angular_velocity[k], spin, atol=EXACT)
        carried = p / mass + np.cross(spin, sim.bodies.position[k] - centre_now)
        np.testing.assert_allclose(sim.bodies.velocity[k], carried, atol=EXACT)


def test_members_keep_their_places_in_the_whole():
    sim = three(a_first=True)
    play(sim, 0.6, 0.01)
    x, R = sim.bodies.position, rotation_from_quaternion(sim.bodies.quaternion[1])
    before = (x - x[1]) @ R
    play(sim, 2.0, 0.01)
    x, R = sim.bodies.position, rotation_from_quaternion(sim.bodies.quaternion[1])
    np.testing.assert_allclose((x - x[1]) @ R, before, atol=1e-12)


def test_what_merges_with_a_fixed_body_is_fixed():
    cube = free_box("cube", (1.0, 1.0, 1.0), 1.0, position=(0.3, 0.0, 0.7), velocity=(0.5, 0.0, -1.0))
    floor = fixed_box("floor", (9.0, 9.0, 1.0), (0.0, 0.0, -0.5))
    sim = Simulation(scene_of(cube, floor, restitution=0.0, merge=True))
    play(sim, 1.0, 0.01)
    np.testing.assert_allclose(sim.bodies.position[0], [0.4, 0.0, 0.5], atol=EXACT)
    assert not sim.bodies.velocity.any()


def test_other_pairs_do_not_merge():
    a = free_box("a", (1.0, 1.0, 1.0), 1.0, velocity=(1.0, 0.0, 0.0))
    b = free_box("b", (1.0, 1.0, 1.0), 1.0, position=(1.1, 0.0, 0.0))
    sim = Simulation(scene_of(a, b, restitution=1.0, merge=True))
    play(sim, 0.3, 0.01)
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], [0.0, 1.0], atol=1e-14)


def test_a_merge_is_reported_with_the_impulse_that_passed_and_the_energy_that_went():
    a = free_box("a", (1.0, 1.0, 1.0), 1.0, position=(-1.1, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    b = free_box("b", (1.0, 1.0, 1.0), 3.0)
    sim = Simulation(scene_of(a, b, restitution=0.0, merge=True))
    (impact,) = (out := sim.step(0.2)).impacts
    assert (impact.body_a, impact.body_b, impact.law) == ("a", "b", "merge")
    assert impact.time == pytest.approx(0.1, abs=EXACT)
    assert impact.impulse == pytest.approx(3.0 * 0.25, abs=1e-14)
    assert impact.approach_speed == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(out.contacts[0].impulse, [0.75, 0.0, 0.0], atol=1e-14)
    assert out.books.rest_energy == pytest.approx(0.5 - 0.5 * 4.0 * 0.25**2, abs=1e-14)


def test_a_step_that_merged_can_be_taken_again():
    sim = three(a_first=True)
    play(sim, 0.05, 0.01)
    kept = sim.checkpoint()
    first = [sim.step(0.1).impacts for _ in range(5)]
    position = sim.bodies.position
    sim.restore(kept)
    again = [sim.step(0.1).impacts for _ in range(5)]
    np.testing.assert_array_equal(sim.bodies.position, position)
    assert [len(impacts) for impacts in again] == [len(impacts) for impacts in first] == [1, 0, 1, 0, 0]
