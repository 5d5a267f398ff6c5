"""Bodies with frames collide at their frames, and everything else about them is their own (P17)."""

from dataclasses import replace

import numpy as np
import pytest
from played import hits, momentum, play
from scenes_by_hand import fixed_box, free_box, moved_box, scene_of

from comotion_server.geometry import distance
from comotion_server.meshes import box, prism
from comotion_server.meshes.offset import moved_out
from comotion_server.quaternions import rotation_from_quaternion
from comotion_server.scene import Fixed
from comotion_server.simulation import Simulation

OFFSET = 0.01  # [m]
GAP = 1e-9  # tolerance of contact, relative to the frames' sizes of 0.4 m: where bodies are at a hit


def framed(body, offset=OFFSET):
    return replace(body, frame=moved_out(body.mesh, offset))


def real_distance(sim, i, j):
    a, b = sim.scene.bodies[i], sim.scene.bodies[j]
    pose_a, pose_b = ((rotation_from_quaternion(sim.bodies.quaternion[k]), sim.bodies.position[k]) for k in (i, j))
    return distance(a.mesh, pose_a, b.mesh, pose_b).distance


@pytest.mark.parametrize("rule", ["exact", "paper-advance"])
def test_two_floes_rebound_at_twice_the_clearance(rule):
    """Head on at 2 m/s each, faces 0.5 m apart, e = 1: they part again when the gap is two offsets."""
    size = (0.2, 0.2, 0.1)
    left = framed(free_box("left", size, 2.0, position=(-0.35, 0, 0), velocity=(2.0, 0, 0)))
    right = framed(free_box("right", size, 2.0, position=(0.35, 0, 0), velocity=(-2.0, 0, 0)))
    sim = Simulation(scene_of(left, right, restitution=1.0, rule=rule))
    found = hits(play(sim, 0.2, 0.01))
    near = GAP if rule == "exact" else 1e-6
    assert found == pytest.approx([(0.5 - 2 * OFFSET) / 4.0], abs=near)
    np.testing.assert_allclose(sim.bodies.velocity, [[-2.0, 0, 0], [2.0, 0, 0]], atol=1e-12)
    least = 2 * OFFSET
    back = least + 4.0 * (0.2 - (0.5 - least) / 4.0)  # as if the real bodies had turned round at the least gap
    assert real_distance(sim, 0, 1) == pytest.approx(back, abs=4.0 * near)


def test_tumbling_floes_never_come_nearer_than_twice_the_clearance():
    rng = np.random.default_rng(5)
    mesh = prism(0.3, 0.2, 0.05)
    frame = moved_out(mesh, OFFSET)
    bodies = []
    for k, x in enumerate((-0.4, 0.0, 0.4)):
        floe = free_box(f"floe-{k}", (0.2, 0.2, 0.1), 0.5, position=(x, 0, 0), velocity=(-2 * x, 0, 0))
        bodies.append(replace(floe, shape=mesh, frame=frame, angular_velocity=rng.normal(size=3) * 3.0))
    sim = Simulation(scene_of(*bodies, restitution=1.0))
    before, least = momentum(sim), np.inf
    count = 0
    for _ in range(100):
        count += len(sim.step(0.01).impacts)
        least = min(least, *(real_distance(sim, i, j) for i, j in ((0, 1), (0, 2), (1, 2))))
    assert count > 3
    assert least >= 2 * OFFSET  # frames have a gap
    np.testing.assert_allclose(momentum(sim), before, atol=1e-14)


def test_a_framed_box_rests_its_clearance_above_a_fixed_one():
    floor = replace(fixed_box("floor", (2, 2, 1), (0, 0, -0.5)), frame=moved_out(box([2, 2, 1]), 0.02))
    crate = framed(free_box("crate", (0.2, 0.2, 0.1), 2.0, position=(0, 0, 0.1)))
    sim = Simulation(scene_of(crate, floor, gravity=(0, 0, -9.81), restitution=0.0))
    play(sim, 0.3, 0.01)
    assert isinstance(floor.motion, Fixed)
    assert sim.bodies.position[0] == pytest.approx([0, 0, 0.05 + OFFSET + 0.02], abs=1e-7)
    assert not sim.bodies.velocity[0].any()


def test_the_vertices_sent_are_those_of_the_body():
    floe = framed(free_box("floe", (0.2, 0.2, 0.1), 2.0, position=(1, 2, 3), velocity=(1, 0, 0)))
    other = framed(free_box("other", (0.2, 0.2, 0.1), 2.0, position=(9, 2, 3)))
    sim = Simulation(scene_of(floe, other))
    sim.step(0.5)
    np.testing.assert_allclose(sim.vertices("floe"), np.add(floe.mesh.vertices, [1.5, 2, 3]), atol=1e-15)


def test_bodies_that_merge_keep_their_frames():
    """Two floes meet plastically at their frames; a third one meets the frame of the second."""
    floes = [
        framed(free_box(name, (0.2, 0.2, 0.1), 1.0, position=(x, 0, 0), velocity=(v, 0, 0)))
        for name, x, v in (("a", -0.5, 1.0), ("b", 0.0, 0.0), ("c", 0.5, 0.0))
    ]
    sim = Simulation(scene_of(*floes, restitution=0.0, merge=True))
    play(sim, 2.0, 0.01)
    gaps = np.diff(sim.bodies.position[:, 0]) - 0.2
    np.testing.assert_allclose(gaps, 2 * OFFSET, atol=10 * GAP)
    np.testing.assert_allclose(sim.bodies.velocity, np.tile([1 / 3, 0, 0], (3, 1)), atol=1e-12)


def test_a_body_that_heals_takes_its_frame_along():
    """A ram presses a framed cube of 0.2 m against a wall from 0.1 s on: the frame is what is too large."""
    cube = framed(free_box("cube", (0.2, 0.2, 0.2), 1.0))
    ram = moved_box("ram", (0.1, 1.0, 1.0), (-0.15 - 0.05 - OFFSET, 0.0, 0.0), (0.5, 0.0, 0.0))
    wall = fixed_box("wall", (0.1, 1.0, 1.0), (0.15 + OFFSET + 1e-7, 0.0, 0.0))
    sim = Simulation(scene_of(cube, ram, wall, restitution=0.0, heal="wear"))
    first = sim.step(0.12).wear[0]
    assert first.scale == pytest.approx(1.0 - 2.0 * first.depth / (0.1 + OFFSET), abs=1e-7)  # the gaps of contacts
    scale = sim.bodies.scale[0]
    np.testing.assert_allclose(np.ptp(sim.vertices("cube"), axis=0), 0.2 * scale, rtol=1e-14)
    gaps = (
        sim.vertices("cube")[:, 0].min() - sim.vertices("ram")[:, 0].max(),
        0.1 + OFFSET - sim.vertices("cube")[:, 0].max(),
    )
    assert min(gaps) >= OFFSET * scale
