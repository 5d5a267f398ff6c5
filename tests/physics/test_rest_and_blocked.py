"""Bodies held at rest, and motions that cannot be."""

import numpy as np
import pytest
import trimesh
from mesh_forms import cube
from played import energy, play, row_of, smallest_gap
from scenes_by_hand import fixed_box, free_box, moved_box, plane, scene_of, solid

from comotion_mock_cfd.body_forms import floe_mesh
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import quaternion_of
from comotion_server.scene import Fixed, Free
from comotion_server.simulation import Simulation

G = 9.81
CUBE = (1.0, 1.0, 1.0)
FALLING = (0.0, 0.0, -G)


def test_a_box_that_starts_at_rest_stays_where_it_is():
    """Asleep: no motion at all, whatever the step."""
    sim = Simulation(scene_of(free_box("box", CUBE, 2.0, position=(0, 0, 0.5)), plane(), gravity=FALLING))
    play(sim, 1.0, 0.01)
    at = sim.bodies.position[0]
    play(sim, 100.0, 0.01)
    np.testing.assert_array_equal(sim.bodies.position[0], at)
    np.testing.assert_allclose(at, [0.0, 0.0, 0.5], atol=2e-8)


def test_faces_that_are_cut_finely_rest_on_each_other():
    """More pairs of triangles, and more points, than there is room for at first."""
    vertices, triangles = cube(offset=(-0.5, -0.5, -0.5))
    for _ in range(6):
        vertices, triangles = trimesh.remesh.subdivide(vertices, triangles)
    fine = TriangleMesh(vertices, triangles)
    below = solid("below", fine, mass=1.0, motion=Fixed(), position=(0.0, 0.0, -0.5))
    above = solid("above", fine, mass=1.0, position=(0.3, 0.1, 0.501))
    sim = Simulation(scene_of(above, below, gravity=FALLING, restitution=0.0))
    play(sim, 0.2, 0.05)
    np.testing.assert_allclose(sim.bodies.position[0], [0.3, 0.1, 0.5], atol=2e-8)
    np.testing.assert_array_equal(sim.bodies.velocity[0], 0.0)


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_a_stack_with_the_heavy_one_on_top_stands(ratio):
    masses = [1.0, np.sqrt(ratio), ratio]
    boxes = [free_box(f"b{k}", CUBE, m, position=(0.0, 0.0, 0.5 + k)) for k, m in enumerate(masses)]
    sim = Simulation(scene_of(*boxes, plane(), gravity=FALLING, restitution=0.5))
    out = [sim.step(0.01) for _ in range(100)]
    np.testing.assert_allclose(sim.bodies.position[:3, 2], [0.5, 1.5, 2.5], atol=1e-7)
    assert np.abs(sim.bodies.velocity).max() <= 1e-9
    lowest = next(c for c in out[-1].contacts if {c.body_a, c.body_b} == {"b0", "floor"})
    assert abs(lowest.impulse[2]) == pytest.approx(sum(masses) * G * 0.01, rel=1e-9)


def test_a_held_box_leaves_when_it_is_lifted():
    sim = Simulation(scene_of(free_box("box", CUBE, 2.0, position=(0, 0, 0.5)), plane(), gravity=FALLING))
    play(sim, 0.5, 0.01)
    lift = np.zeros((2, 6))
    lift[0, 2] = 2.0 * (G + 3.0)
    start = sim.bodies.position[0, 2]
    play(sim, 0.5, 0.01, wrenches=lift)
    assert sim.bodies.position[0, 2] - start == pytest.approx(0.5 * 3.0 * 0.25, abs=1e-9)


def test_a_cube_between_a_driven_wall_and_a_fixed_one_blocks_the_wall():
    cube = free_box("cube", CUBE, 1.0, position=(1.0, 0.0, 0.0))
    hull = moved_box("hull", CUBE, (-0.25, 0.0, 0.0), (1.0, 0.0, 0.0))
    bank = fixed_box("bank", (1.0, 3.0, 1.0), (2.25, 0.0, 0.0))
    sim = Simulation(scene_of(cube, hull, bank, restitution=0.0))
    statuses = []
    for _ in range(100):
        out = sim.step(0.01)
        statuses.append(out.status)
        x = sim.bodies.position[:, 0]
        gaps = x[1] - x[2] - 1.0, x[0] - x[1] - 1.0  # rows: bank, cube, hull
        assert min(gaps) > 0.0
        if out.status == "blocked":
            (blocked,) = out.blocked
            assert blocked.bodies == ("hull",)
            assert set(blocked.contacts) == {("bank", "cube"), ("cube", "hull")}
    # the cube fills the gap of 0.5 m when the hull has gone as far
    assert statuses.index("blocked") in (49, 50)
    assert set(statuses[51:]) == {"blocked"}
    assert sim.bodies.position[row_of(sim, "hull"), 0] == pytest.approx(0.25, abs=1e-7)
    assert out.blocked[0].time == pytest.approx(sim.time - 0.01, abs=1e-9)


def test_a_hull_that_backs_off_is_free_again():
    cube = free_box("cube", CUBE, 1.0, position=(1.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    bank = fixed_box("bank", (1.0, 3.0, 1.0), (2.25, 0.0, 0.0))
    hull = free_box("hull", CUBE, 1e6, position=(-0.25, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    sim = Simulation(scene_of(cube, hull, bank, restitution=0.0))
    out = [sim.step(0.01) for _ in range(100)]
    assert {step.status for step in out} == {"ok"}  # a free hull gives way, however heavy
    assert np.abs(sim.bodies.velocity).max() <= 1e-9


def test_a_jam_ends_blocked_without_an_intersection():
    """Twelve hexagons between fixed walls and two that close in: energy comes from the walls alone."""
    across = 0.25 * np.sqrt(3.0)
    mesh = TriangleMesh(*floe_mesh(0.25, 0.1))
    flat = Free(locked=(False, False, True, True, True, False))
    random = np.random.default_rng(3)
    floes = [
        solid(
            f"floe-{i}{j}",
            mesh,
            mass=1.0,
            motion=flat,
            position=(0.55 * i, 0.55 * j, 0.0),
            quaternion=quaternion_of(np.array([0.0, 0.0, random.uniform(0.0, 1.0)])),
        )
        for i in range(4)
        for j in range(3)
    ]
    walls = [
        plane("north", (0.0, -1.0, 0.0), (0.0, 1.4, 0.0)),
        plane("south", (0.0, 1.0, 0.0), (0.0, -0.3, 0.0)),
        plane("east", (-1.0, 0.0, 0.0), (1.95, 0.0, 0.0), (-0.25, 0.0, 0.0)),
        plane("west", (1.0, 0.0, 0.0), (-0.3, 0.0, 0.0), (0.25, 0.0, 0.0)),
    ]
    sim = Simulation(scene_of(*floes, *walls, restitution=0.0))
    statuses = []
    for _ in range(60):
        statuses.append(sim.step(0.05).status)
        assert smallest_gap(sim) > 0.0
    assert statuses[-1] == "blocked"
    room = sim.bodies.position[row_of(sim, "east"), 0] - sim.bodies.position[row_of(sim, "west"), 0]
    assert room * 1.7 > 12 * 1.5 * across * 0.25  # the floes still have their area
    assert energy(sim) <= 12 * 0.5 * 0.25**2  # no floe is faster than the walls were
