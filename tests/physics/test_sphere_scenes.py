"""The shipped scenes of spheres hold what they promise, through the whole simulation."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

from comotion_mock_cfd.scenes import path_of
from comotion_server.scene import Body, Collisions, Fixed, Free, Pipe, Plane, Scene, SceneError, Sphere, load_scene
from comotion_server.simulation import Simulation


def energy(simulation):
    free = np.isin(simulation.bodies.mass, simulation.bodies.mass[~np.isnan(simulation.bodies.mass)])
    return 0.5 * (simulation.bodies.mass[free] * (simulation.bodies.velocity[free] ** 2).sum(axis=1)).sum()


def played(name, duration=None, dt=None):
    scene = load_scene(path_of(name))
    simulation, dt = Simulation(scene), dt or scene.dt
    steps = [simulation.step(dt) for _ in range(round((duration or scene.duration) / dt))]
    assert {out.status for out in steps} == {"ok"}
    return simulation, [impact for out in steps for impact in out.impacts]


@pytest.mark.parametrize(("dt", "duration"), [(1e-4, 0.2), (1e-3, 1.0), (1e-2, 10.0), (1e-1, 10.0)])
def test_216_balls_keep_their_energy_at_any_step(dt, duration):
    """The published measure is the root of the mean square of the error; 1e-10 is asked for."""
    scene = load_scene(path_of("elastic"))
    simulation = Simulation(scene)
    first, errors = energy(simulation), []
    for _ in range(round(duration / dt)):
        assert simulation.step(dt).status == "ok"
        errors.append(energy(simulation) / first - 1.0)
    assert np.sqrt(np.mean(np.square(errors))) <= 1e-14


def test_49_balls_land_44_times_at_the_times_of_the_formula():
    _, impacts = played("bounce", 8.5)
    first, e = sqrt(2.0 / 9.81), 0.9
    expected = [first * (1.0 + 2.0 * e * (1.0 - e**n) / (1.0 - e)) for n in range(44)]
    for name in ("ball-001", "ball-049"):
        times = [impact.time for impact in impacts if impact.body_a == name]
        np.testing.assert_allclose(times, expected, rtol=0.0, atol=1e-11)


def test_a_cradle_hands_the_speed_on():
    simulation, impacts = played("cradle")
    speeds = dict(zip(simulation.bodies.names, simulation.bodies.velocity[:, 0], strict=True))
    np.testing.assert_allclose([speeds[f"ball-{k:03d}"] for k in (1, 2, 3, 4)], [0, 0, 0, 1], atol=1e-15)
    assert speeds["striker"] == pytest.approx(0.0, abs=1e-15)
    times = {impact.time for impact in impacts}  # the balls are put delta / 2 apart, or were by rounding
    assert len(times) == 1
    assert times.pop() == pytest.approx(0.375, abs=1e-8)


def test_the_billiard_knows_pi():
    _, impacts = played("billiard")
    assert len(impacts) == 314


@pytest.mark.parametrize("name", ["pipe", "pipe_capped", "ring"])
def test_nothing_is_lost_in_a_pipe(name):
    simulation, impacts = played(name)
    scene = load_scene(path_of(name))
    assert len(impacts) > 100
    assert energy(simulation) == pytest.approx(energy(Simulation(scene)), rel=1e-14)
    if name == "ring":
        radii = np.linalg.norm(simulation.bodies.position[:6], axis=1)
        np.testing.assert_allclose(radii, 0.2578125, rtol=0.0, atol=1e-12)


# rest

FALL = np.array([0.0, 0.0, -9.81])


def ball(name, x, v=(0.0, 0.0, 0.0), r=0.1):
    at, velocity = np.array(x, dtype=float), np.array(v, dtype=float)
    return Body(name, name, Free(), 1.0, 0.4 * r * r * np.eye(3), Sphere(r), at, velocity=velocity)


def fixed(name, shape):
    return Body(name, name, Fixed(), np.nan, np.full((3, 3), np.nan), shape)


def simulated(*bodies, restitution=0.5, gravity=FALL, **settings):
    return Simulation(Scene("spheres", gravity, 1.0, 0.01, Collisions(restitution=restitution, **settings), bodies))


FLOOR = fixed("floor", Plane(np.array([0.0, 0.0, 1.0])))


def test_a_column_of_balls_comes_to_rest_and_its_weight_is_held():
    simulation = simulated(ball("a", (0, 0, 0.2)), ball("b", (0, 0, 0.5)), FLOOR)
    out = [simulation.step(0.01) for _ in range(300)][-1]
    np.testing.assert_allclose(simulation.bodies.position[:2, 2], [0.1, 0.3], atol=1e-8)
    assert not simulation.bodies.velocity.any()
    held = {(contact.body_a, contact.body_b): abs(contact.held[2]) for contact in out.contacts}
    assert held == {("a", "b"): pytest.approx(0.0981, rel=1e-9), ("a", "floor"): pytest.approx(0.1962, rel=1e-9)}


def test_a_ball_in_a_closed_pipe_rests_on_its_end():
    simulation = simulated(ball("ball", (0.1, 0.2, 0.0)), fixed("pipe", Pipe(0.5, 0.6, 2.0, caps=True)))
    for _ in range(400):
        out = simulation.step(0.01)
    assert simulation.bodies.position[0, 2] == pytest.approx(-0.9, abs=1e-8)
    assert abs(out.contacts[0].held[2]) == pytest.approx(0.0981, rel=1e-9)


def test_a_ball_slides_in_a_lying_pipe_like_a_pendulum():
    """Its centre is a pendulum of length R - r: at the lowest point v^2 / 2 = g h, held at the wall all the time."""
    room = 0.4
    at = room * (1.0 - 1e-9) * np.array([np.sin(0.5), 0.0, -np.cos(0.5)])
    simulation = simulated(ball("ball", at), fixed("pipe", Pipe(0.5, 0.6, 4.0, axis=1)), restitution=0.0)
    fastest = 0.0
    for _ in range(200):
        simulation.step(0.01)
        x, v = simulation.bodies.position[0], simulation.bodies.velocity[0]
        assert 0.5 * v @ v + 9.81 * x[2] == pytest.approx(9.81 * at[2], rel=1e-7)
        assert np.hypot(x[0], x[2]) == pytest.approx(room, abs=1e-8)
        fastest = max(fastest, float(np.linalg.norm(v)))
    assert fastest == pytest.approx(sqrt(2.0 * 9.81 * room * (1.0 - np.cos(0.5))), rel=1e-2)


# the paper's queue, and refusals


def test_the_papers_queue_answers_before_it_moves():
    """Two balls that would meet after 0.4 s of a step of 1 s swap their speeds at its beginning (P19)."""
    balls = ball("a", (0, 0, 0), (1, 0, 0)), ball("b", (1, 0, 0), (-1, 0, 0))
    simulation = simulated(*balls, restitution=1.0, gravity=np.zeros(3), rule="paper-analytic")
    out = simulation.step(1.0)
    assert [impact.time for impact in out.impacts] == [0.0]
    np.testing.assert_allclose(simulation.bodies.position[:, 0], [-1.0, 2.0], atol=1e-15)
    np.testing.assert_allclose(simulation.bodies.velocity[:, 0], [-1.0, 1.0], atol=1e-15)


def test_the_papers_queue_misses_nothing_that_exact_finds_in_short_steps():
    scene = load_scene(path_of("billiard"))
    scene = replace(scene, collisions=replace(scene.collisions, rule="paper-analytic", parallel="off"))
    simulation = Simulation(scene)
    impacts = sum(len(simulation.step(0.01).impacts) for _ in range(300))
    assert abs(impacts - 314) <= 1


@pytest.mark.parametrize(
    "bodies",
    [
        (ball("a", (0, 0, 0)), ball("b", (0.15, 0, 0))),
        (ball("a", (0, 0, 0), r=0.6), fixed("pipe", Pipe(0.5, 0.7, 2.0))),
        (ball("a", (0, 0, 0.05)), FLOOR),
    ],
)
def test_overlaps_at_the_start_are_refused(bodies):
    with pytest.raises(SceneError, match="overlap at the start"):
        simulated(*bodies)


@pytest.mark.parametrize(
    ("shape", "complaint"),
    [
        ("{ sphere = { radius = 0.0 } }", "radius"),
        ("{ sphere = { radius = -1.0 } }", "radius"),
        ("{ pipe = { inner_radius = 2.0, outer_radius = 1.0, length = 1.0 } }", "must be larger than the inner radius"),
        ("{ pipe = { inner_radius = 1.0, outer_radius = 2.0, length = 1.0 } }", "a free one is not in this version"),
        ("{ prism = { base = 1.0, height = 0.0, thickness = 1.0 } }", "height"),
    ],
)
def test_impossible_shapes_are_refused_by_name(shape, complaint, tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(f'[scene]\nduration = 1.0\ndt = 0.1\n[[body]]\nname = "it"\nmass = 1.0\nshape = {shape}\n')
    with pytest.raises(SceneError, match=complaint):
        load_scene(file)
