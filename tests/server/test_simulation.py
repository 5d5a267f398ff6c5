"""The simulation at its door: forces, refusals, checkpoints, samples."""

import math

import numpy as np
import pytest
from scenes_by_hand import fixed_box, free_box, scene_of, solid

from comotion_server.forces import StepInputError
from comotion_server.scene import Free, PoseTable, Prescribed
from comotion_server.simulation import Simulation


@pytest.fixture
def sim():
    ice = [free_box(f"floe-{i}", position=(4.0 * i, 0.0, 0.0), region="ice", mass=1.0 + i) for i in range(3)]
    return Simulation(scene_of(*ice, fixed_box("wall", (1.0, 1.0, 1.0), (-9.0, 0.0, 0.0))))


def state_of(sim):
    bodies = sim.bodies
    return np.concatenate([bodies.position, bodies.quaternion, bodies.velocity, bodies.angular_velocity], axis=1)


def test_nodal_forces_become_a_wrench_about_the_centre_of_mass(sim, rng):
    """P3, with sums in exact arithmetic (math.fsum) as the second method."""
    forces = rng.normal(size=(24, 3)) * 10.0 ** rng.integers(-8, 8, size=(24, 1))
    vertices = sim.vertices("ice")
    out = sim.step(1e-3, {"ice": forces})
    for i, body in enumerate(sim.regions[0].bodies):
        rows = slice(body.first_vertex, body.first_vertex + body.vertex_count)
        force = [math.fsum(forces[rows, k]) for k in range(3)]
        np.testing.assert_allclose(sim.bodies.velocity[i], np.array(force) * 1e-3 / (1.0 + i), rtol=1e-15)
    total = [math.fsum(forces[:, k]) for k in range(3)]
    np.testing.assert_allclose(out.sums.force, total, rtol=1e-14)
    moments = np.cross(vertices, forces)
    # the moment about the origin goes through the bodies' centres: digits of the largest arm are lost
    np.testing.assert_allclose(out.sums.moment, [math.fsum(moments[:, k]) for k in range(3)], rtol=1e-12)


def test_forces_act_where_the_vertices_were_last_sent(sim):
    """A sample half a step ahead was sent: the moment is about the centres that went with it."""
    sim._world.state.velocity[0] = (0.0, 8.0, 0.0)
    sample = sim.sample(0.5)
    sim.mark_sent(sample)
    forces = np.zeros((24, 3))
    forces[0] = (1.0, 0.0, 0.0)
    out = sim.step(1e-3, {"ice": forces})
    np.testing.assert_allclose(out.sums.moment, np.cross(sample.vertices["ice"][0], forces[0]), rtol=1e-14)
    np.testing.assert_allclose(sample.state.position[0], [0.0, 4.0, 0.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0,), "dt: expected a positive, finite number"),
        ((-1.0,), "dt: expected a positive, finite number"),
        ((math.nan,), "dt: expected a positive, finite number"),
        ((math.inf,), "dt: expected a positive, finite number"),
        ((True,), "dt: expected a positive, finite number"),
        (("0.1",), "dt: expected a positive, finite number"),
        ((0.1, {"snow": np.zeros((24, 3))}), "unknown region 'snow'; the regions are 'ice', 'wall'"),
        ((0.1, {"ice": np.zeros((23, 3))}), r'region "ice": expected shape \(24, 3\); got \(23, 3\)'),
        ((0.1, {"ice": "much"}), r'region "ice": expected an array of numbers of shape \(24, 3\)'),
        ((0.1, {"ice": np.full((24, 3), np.nan)}), "finite numbers; got nan in row 0, column 0"),
        ((0.1, {"ice": np.full((24, 3), 1e308)}), "too large"),
        ((0.1, None, np.zeros((3, 6))), r"wrenches: expected shape \(4, 6\)"),
        ((0.1, {}, np.zeros((4, 6))), "expected one of them; got both"),
        ((1e200, None, np.full((4, 6), 1e200)), "leaves the range of numbers"),
    ],
)
def test_bad_input_is_refused_and_the_state_untouched(sim, arguments, message):
    sim.step(0.1)
    before, time = state_of(sim), sim.time
    with np.errstate(all="ignore"), pytest.raises(StepInputError, match=message):
        sim.step(*arguments)
    np.testing.assert_array_equal(state_of(sim), before)
    assert sim.time == time
    assert sim.step(0.1).time == pytest.approx(0.2)


@pytest.mark.parametrize("dt", [1e-12, 1e6])
def test_tiny_and_huge_steps_are_exact(dt):
    sim = Simulation(scene_of(free_box(velocity=(1.0, 0.0, 0.0)), gravity=(0.0, 0.0, -9.81)))
    sim.step(dt)
    np.testing.assert_allclose(sim.bodies.position[0], [dt, 0.0, -0.5 * 9.81 * dt**2], rtol=1e-15)


def test_time_does_not_gather_rounding(sim):
    for _ in range(10_000):
        sim.step(0.005)
    assert sim.time == 50.0


def test_a_sample_ahead_drifts_and_leaves_no_trace(sim):
    sim.step(0.1, wrenches=np.ones((4, 6)))
    before, velocity = state_of(sim), sim.bodies.velocity
    sample = sim.sample(0.05, velocities=True)
    assert sample.time == pytest.approx(0.15)
    np.testing.assert_allclose(sample.state.position, sim.bodies.position + 0.05 * velocity, rtol=1e-15)
    np.testing.assert_array_equal(sample.twists[:, :3], velocity)
    np.testing.assert_array_equal(state_of(sim), before)


def test_a_sample_ahead_collides_on_the_way():
    """Bodies that would overlap half a step ahead are not sent so."""
    a, b = free_box("a", (1, 1, 1), velocity=(2.0, 0.0, 0.0)), free_box("b", (1, 1, 1), position=(1.01, 0.0, 0.0))
    sim = Simulation(scene_of(a, b, restitution=1.0))
    sample = sim.sample(0.02)
    np.testing.assert_allclose(sample.state.position[1] - sample.state.position[0], [1.01 + 0.02, 0, 0], atol=1e-5)
    np.testing.assert_array_equal(sim.bodies.velocity[0], [2.0, 0.0, 0.0])


def test_vertices_are_placed_from_the_reference_shape(sim, rng):
    sim.step(1.0, wrenches=np.concatenate([rng.normal(size=(4, 3)), 0.1 * rng.normal(size=(4, 3))], axis=1))
    w, x, y, z = sim.bodies.quaternion[1]
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R = np.eye(3) + 2 * w * hat + 2 * hat @ hat
    body = sim.scene.bodies[1]
    np.testing.assert_allclose(sim.vertices("ice")[8:16], body.mesh.vertices @ R.T + sim.bodies.position[1], atol=1e-14)
    spin = sim.bodies.angular_velocity[1]
    arms = sim.vertices("ice")[8:16] - sim.bodies.position[1]
    np.testing.assert_allclose(sim.velocities("ice")[8:16], sim.bodies.velocity[1] + np.cross(spin, arms), atol=1e-14)


def test_a_body_follows_a_table_of_poses_through_rows_inside_a_step():
    half = np.sqrt(0.5)
    table = PoseTable(
        np.array([0.0, 0.13, 0.5]),
        np.array([[0.0, 0.0, 0.0], [1.3, 0.0, 0.0], [1.3, 0.37, 0.0]]),
        np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [half, 0.0, 0.0, half]]),
    )
    gate = solid("gate", free_box().mesh, density=1.0, motion=Prescribed(table=table))
    sim = Simulation(scene_of(gate))
    for _ in range(3):
        sim.step(0.1)
    np.testing.assert_allclose(sim.bodies.position[0], [1.3, 0.17, 0.0], atol=1e-15)
    angle = np.pi / 2 * 0.17 / 0.37
    np.testing.assert_allclose(sim.bodies.quaternion[0], [np.cos(angle / 2), 0, 0, np.sin(angle / 2)], atol=1e-15)
    np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 1.0, 0.0], atol=1e-15)
    sim.step(10.0)
    np.testing.assert_array_equal(sim.bodies.velocity[0], 0.0)
    np.testing.assert_allclose(sim.bodies.position[0], [1.3, 0.37, 0.0], atol=1e-15)


def test_locked_directions_do_not_move(rng):
    disc = free_box(motion=Free(locked=(False, False, True, True, True, True)), velocity=(1.0, 2.0, 3.0))
    sim = Simulation(scene_of(disc, gravity=(0.0, 0.0, -9.81)))
    sim.step(0.5, wrenches=rng.normal(size=(1, 6)))
    assert sim.bodies.position[0, 2] == 0.0
    np.testing.assert_array_equal(sim.bodies.quaternion[0], [1.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(sim.bodies.angular_velocity[0], 0.0)


@pytest.mark.parametrize("offset", [1e6, 1e7])
def test_a_scene_far_from_the_origin_collides_the_same(offset):
    """Local origins: only the coordinates lose digits, the impact does not (VALIDATION E)."""

    def play(shift):
        a = free_box("a", (1, 1, 1), velocity=(2.0, 0.0, 0.0), position=(shift, 0.0, 0.0))
        b = free_box("b", (1, 1, 1), position=(1.5 + shift, 0.25, 0.125))
        sim = Simulation(scene_of(a, b, restitution=1.0))
        return [impact for _ in range(40) for impact in sim.step(0.01).impacts], sim.bodies.velocity

    (near, velocity), (far, velocity_far) = play(0.0), play(offset)
    assert [impact.law for impact in far] == [impact.law for impact in near]
    np.testing.assert_allclose([i.time for i in far], [i.time for i in near], atol=1e-5)  # the tolerance over the speed
    np.testing.assert_allclose(velocity_far, velocity, atol=1e-8 * offset / 1e6)
