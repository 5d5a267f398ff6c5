"""Cutting the step changes nothing: flights are exact, contacts are found in time, and pairs are remembered."""

import numpy as np
import pytest
from played import hits, play
from scenes_by_hand import free_box, moved_box, plane, scene_of, solid

from comotion_mock_cfd.body_forms import floe_mesh
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import quaternion_of
from comotion_server.scene import Free
from comotion_server.simulation import Simulation

WITHOUT_REST = 1e-12  # the promise where no contact is held, up to the horizon of chaos
WITH_REST = 1e-7  # the promise for two bodies in and out of contact over 2 s


def tumbling(count, e, gravity=(0.0, 0.0, 0.0)):
    """Boxes of three different inertias, spinning towards each other in a row."""
    random = np.random.default_rng(7)
    boxes = [
        free_box(
            f"b{k}",
            (1.0, 0.8, 0.6),
            1.0 + k,
            position=(1.6 * k, 0.1 * k, 0.0),
            velocity=(1.0 - k, 0.0, 0.0),
            angular_velocity=random.normal(size=3),
            quaternion=quaternion_of(random.normal(size=3)),
        )
        for k in range(count)
    ]
    return scene_of(*boxes, gravity=gravity, restitution=e)


def end(scene, duration, dt):
    sim = Simulation(scene)
    impacts = play(sim, duration, dt)
    return hits(impacts), np.hstack([sim.bodies.position, sim.bodies.velocity, sim.bodies.angular_velocity])


@pytest.mark.parametrize("e", [1.0, 0.8])
@pytest.mark.parametrize("parts", [2, 5, 10])
def test_free_flights_and_impacts(e, parts):
    scene = tumbling(3, e)
    times, state = end(scene, 2.0, 0.1)
    times_cut, state_cut = end(scene, 2.0, 0.1 / parts)
    assert len(times) > 1
    np.testing.assert_allclose(times_cut, times, atol=WITHOUT_REST)
    np.testing.assert_allclose(state_cut, state, atol=20 * WITHOUT_REST)  # grown by the impacts after


@pytest.mark.parametrize("parts", [2, 5, 10])
def test_a_box_that_tumbles_to_rest(parts):
    box = free_box(
        "box", (1.0, 0.8, 0.6), 1.0, position=(0, 0, 1.0), quaternion=quaternion_of(np.array([0.2, 0.1, 0.0]))
    )
    scene = scene_of(box, plane(), gravity=(0, 0, -9.81), restitution=0.3)
    _, state = end(scene, 2.0, 0.1)
    _, state_cut = end(scene, 2.0, 0.1 / parts)
    np.testing.assert_allclose(state_cut, state, atol=WITH_REST)


def test_a_step_taken_again_gives_the_same_bits():
    sim = Simulation(tumbling(3, 0.8))
    play(sim, 0.5, 0.1)
    kept = sim.checkpoint()
    ends = []
    for _ in range(2):
        sim.restore(kept)
        impacts = play(sim, 1.0, 0.1)
        ends.append((sim.bodies.position.tobytes(), sim.bodies.quaternion.tobytes(), [i.time for i in impacts]))
    assert ends[0] == ends[1]


def test_a_prediction_leaves_no_trace():
    once, twice = Simulation(tumbling(3, 0.8)), Simulation(tumbling(3, 0.8))
    for _ in range(10):
        once.step(0.1)
        twice.sample(0.05)
        twice.step(0.1)
    assert once.bodies.position.tobytes() == twice.bodies.position.tobytes()


# a hull that pushes floes, under forces that change every tenth of a second

HULL_SPEED = 0.5  # [m/s]
HOLD = 0.02  # [s]: the step that is cut
PUSH_END = 2.0  # [s]


def pushed(count, restitution):
    """A prescribed hull runs into hexagons that lie flat and turn as they like."""
    random = np.random.default_rng(5)
    mesh = TriangleMesh(*floe_mesh(0.25, 0.1))
    flat = Free(locked=(False, False, True, True, True, False))
    floes = [
        solid(
            f"floe-{i}",
            mesh,
            mass=1.0,
            motion=flat,
            position=(0.6 + 0.5 * (i // 2) + 0.02 * i, (0.28 if i % 2 else -0.28) + 0.01 * i, 0.0),
            quaternion=quaternion_of(np.array([0.0, 0.0, random.uniform(0.0, 1.0)])),
        )
        for i in range(count)
    ]
    hull = moved_box("hull", (0.4, 0.5, 0.2), (0.0, 0.0, 0.0), (HULL_SPEED, 0.0, 0.0))
    return Simulation(scene_of(hull, *floes, restitution=restitution))


def pushed_to_the_end(count, restitution, parts):
    """Positions, attitudes and velocities at the end, each step cut in parts."""
    sim = pushed(count, restitution)
    for k in range(round(PUSH_END / HOLD)):
        wrenches = np.random.default_rng(k // 5).normal(size=(count + 1, 6)) * [0.3, 0.3, 0.0, 0.0, 0.0, 0.02]
        wrenches[:, 0] -= 0.4
        for _ in range(parts):
            sim.step(HOLD / parts, wrenches=wrenches)
    return np.hstack([sim.bodies.position, sim.bodies.quaternion, sim.bodies.velocity])


@pytest.mark.parametrize(("count", "restitution", "most"), [(1, 0.5, 1e-12), (3, 0.0, 1e-6), (6, 0.0, 1e-6)])
def test_a_hull_that_pushes_floes(count, restitution, most):
    """Measured: 5e-15 without held contacts, 6e-9 with three floes, 6e-8 with six."""
    whole = pushed_to_the_end(count, restitution, 1)
    for parts in (2, 5, 10):
        np.testing.assert_allclose(pushed_to_the_end(count, restitution, parts), whole, rtol=0.0, atol=most)


@pytest.mark.parametrize(("count", "restitution"), [(3, 0.0), (6, 0.0), (6, 0.4)])
def test_every_floe_takes_what_its_contacts_and_forces_give(count, restitution):
    sim = pushed(count, restitution)
    names = list(sim.bodies.names)
    for k in range(round(PUSH_END / HOLD)):
        wrenches = np.random.default_rng(k // 5).normal(size=(count + 1, 6)) * [0.3, 0.3, 0.0, 0.0, 0.0, 0.02]
        wrenches[:, 0] -= 0.4
        before, given = sim.bodies.velocity, HOLD * wrenches[:, :3]
        for contact in sim.step(HOLD, wrenches=wrenches).contacts:
            given[names.index(contact.body_b)] += contact.impulse
            given[names.index(contact.body_a)] -= contact.impulse
        floes = [i for i, name in enumerate(names) if name != "hull"]
        change = sim.bodies.mass[floes, None] * (sim.bodies.velocity - before)[floes]
        np.testing.assert_allclose(change[:, :2], given[floes, :2], rtol=0.0, atol=1e-14)  # [N s]; impulses of 1
