"""Bodies that are pinched and scaled down until they are free (P15, P16, P20)."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from played import smallest_gap
from scenes_by_hand import fixed_box, free_box, moved_box, scene_of, solid

from comotion_mock_cfd.scenes import path_of
from comotion_server.geometry import distance
from comotion_server.healing import shrunk
from comotion_server.inner_world import Inner, alone
from comotion_server.kernels.penetration import overlap_depth
from comotion_server.meetings import Meeting
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.scene import Collisions, load_scene
from comotion_server.simulation import Simulation
from comotion_server.world import World

SPEED = 0.5  # [m/s]
WIDTH = 0.2  # [m]
STEP = 0.12  # [s]: the pinch comes at 0.1


def pinch(heal="wear", **collisions):
    """A wall that moves pushes a cube against a fixed one, and touches it at 0.1 s."""
    cube = free_box("cube", (WIDTH, WIDTH, WIDTH), 1.0)
    ram = moved_box("ram", (0.1, 1.0, 1.0), (-0.15 - 0.05, 0.0, 0.0), (SPEED, 0.0, 0.0))
    wall = fixed_box("wall", (0.1, 1.0, 1.0), (0.15 + 1e-7, 0.0, 0.0))
    return Simulation(scene_of(cube, ram, wall, restitution=0.0, heal=heal, **collisions))


def blockage(**changes):
    scene = load_scene(path_of("blockage"))
    return Simulation(replace(scene, collisions=replace(scene.collisions, **changes)))


def test_a_pinched_body_shrinks_by_twice_what_the_step_would_overlap():
    sim = pinch()
    out = sim.step(STEP)
    first = out.wear[0]
    expected = 1.0 - 2.0 * SPEED * (STEP - first.time) / (0.5 * WIDTH)
    assert first.time == pytest.approx(0.1, abs=1e-6)
    assert (first.body, out.status) == ("cube", "ok")
    assert first.scale == pytest.approx(expected, abs=1e-9)
    scale = sim.bodies.scale[0]
    assert sim.bodies.mass[0] == pytest.approx(scale**3, rel=1e-15)
    np.testing.assert_allclose(np.ptp(sim.vertices("cube"), axis=0), WIDTH * scale, rtol=1e-14)


def test_geometry_alone_keeps_the_mass():
    sim = pinch("geometry-only")
    out = sim.step(STEP)
    assert sim.bodies.scale[0] < 1.0
    assert sim.bodies.mass[0] == 1.0
    assert sum(wear.mass for wear in out.wear) == 0.0


def test_without_healing_it_is_blocked_by_name():
    sim = pinch("off")
    out = sim.step(STEP)
    assert out.status == "blocked"
    assert out.blocked[0].bodies == ("ram",)
    assert set(out.blocked[0].contacts) == {("cube", "ram"), ("cube", "wall")}


def test_below_the_least_scale_it_is_blocked():
    sim = pinch(scale_min=0.95)
    out = sim.step(STEP)
    assert (out.status, out.wear) == ("blocked", ())
    assert sim.bodies.scale[0] == 1.0
    assert smallest_gap(sim) > 0.0


def test_a_body_that_may_not_be_scaled_is_left_alone():
    scene = pinch().scene
    cube = replace(scene.bodies[0], scalable=False)
    sim = Simulation(replace(scene, bodies=(cube, *scene.bodies[1:])))
    assert sim.step(STEP).status == "blocked"


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_the_blockage_scene_heals_to_its_end_and_its_ledger_closes(dt):
    sim = blockage()
    mass, energy, worn, lost = sim.bodies.mass[0], 0.0, 0.0, 0.0
    for _ in range(round(0.95 / dt)):
        out = sim.step(dt)
        assert out.status == "ok"
        assert smallest_gap(sim) > 0.0
        worn += sum(wear.mass for wear in out.wear)
        lost += sum(wear.energy for wear in out.wear)
        for wear in out.wear:
            np.testing.assert_allclose(wear.momentum[1:], 0.0, atol=1e-9)
        assert np.abs(sim.bodies.velocity).max() <= SPEED * (1.0 + 1e-9)
        energy = 0.5 * sim.bodies.mass[0] * (sim.bodies.velocity[0] ** 2).sum()
    assert sim.bodies.scale[0] < 0.6
    assert worn == pytest.approx(mass - sim.bodies.mass[0], rel=1e-12)
    assert sim.bodies.mass[0] == pytest.approx(mass * sim.bodies.scale[0] ** 3, rel=1e-12)
    assert lost >= 0.0
    assert energy <= 0.5 * mass * SPEED**2


def test_a_step_that_healed_can_be_taken_again():
    sim = pinch()
    kept = sim.checkpoint()
    first = sim.step(STEP)
    scale = sim.bodies.scale
    sim.restore(kept)
    assert (sim.bodies.scale == 1.0).all()
    again = sim.step(STEP)
    np.testing.assert_array_equal(sim.bodies.scale, scale)
    assert [wear.time for wear in again.wear] == [wear.time for wear in first.wear]


@pytest.mark.parametrize("rule", ["paper", "paper-advance"])
def test_the_papers_rules_heal_what_they_find_intersecting(rule):
    sim = blockage(rule=rule, parallel="paper", tolerance=1e-6)
    healings, overlaps = 0, 0
    for _ in range(95):
        out = sim.step(0.01)
        healings += len(out.wear)
        overlaps += out.books.overlaps
    assert healings > 0
    assert overlaps > 0
    assert 0.2 < sim.bodies.scale[0] < 1.0
    mine = blockage()
    exact = sum(len(mine.step(0.01).wear) for _ in range(95))
    if rule == "paper":
        assert exact < healings


RADIUS = 0.5  # [m]
WAY = np.array([0.6, 0.48, 0.64])  # from one sphere to the other: along no axis of their meshes


@pytest.mark.parametrize("apart", [1.95, 1.8, 1.6])
@pytest.mark.parametrize("subdivisions", [3, 4])
def test_overlapping_spheres_shrink_as_the_rule_says(apart, subdivisions):
    """Spheres of radius R at a distance d < 2 R overlap by 2 R - d: s = 1 - 2 (2 R - d) / R clears twice that (P16)."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions, radius=RADIUS)
    mesh = TriangleMesh(np.array(ball.vertices), np.array(ball.faces))
    edge = np.linalg.norm(mesh.vertices[mesh.triangles[:, 0]] - mesh.vertices[mesh.triangles[:, 1]], axis=1).max()
    coarse = edge**2 / RADIUS  # [m]: facets lie inside the sphere by a sixth of it, and vertices as far off the line
    d = apart * RADIUS
    near, far = (solid(name, mesh, mass=1.0, position=at * WAY) for name, at in (("near", 0.0), ("far", d)))
    world = World(scene_of(near, far))  # in the order of the names: far, near
    before = distance(mesh, (np.eye(3), 2.01 * RADIUS * WAY), mesh, (np.eye(3), np.zeros(3)))  # last apart
    normal = (before.point_b - before.point_a) / before.distance
    store, (x, _, R, _, _) = MeshStore.build([mesh]), world.state.arrays
    depth = float(overlap_depth(store.arrays, 0, 0, x[0], R[0], x[1], R[1], normal))
    assert depth == pytest.approx(2 * RADIUS - d, abs=coarse)
    meeting = Meeting(0, 1, before.point_b, normal, 0.0, depth)
    part = shrunk(Inner(world, None, alone(world)), 1, [meeting], depth, Collisions(heal="wear", scale_min=0.01))
    s = part.members[0].scale
    assert s == pytest.approx(1.0 - 2.0 * (2.0 * RADIUS - d) / RADIUS, abs=2.5 * coarse / RADIUS)
    assert part.members[0].mass == pytest.approx(s**3, rel=1e-15)
    after = distance(mesh, (np.eye(3), x[0]), part.body.mesh, (np.eye(3), x[1])).distance
    assert after == pytest.approx(2 * RADIUS - d, abs=2 * coarse)  # a gap as wide as the overlap was deep
