"""Cylinders on planes, meshes, balls, capsules and each other, against formulas."""

from dataclasses import replace

import numpy as np
import pytest
from played import angular_momentum, energy, momentum, play, row_of
from round_bodies import capsule, cylinder, sphere
from scenes_by_hand import fixed_box, free_box, plane, scene_of, solid

from comotion_server.meshes import box
from comotion_server.quaternions import quaternion_of, rotation_from_quaternion
from comotion_server.scene import Fixed, Free, SceneError
from comotion_server.simulation import Simulation

pytestmark = pytest.mark.timeout(900)  # a cold compile beside other work takes minutes
G = 9.81
CLOSE = 1e-8  # of lengths about 1: ten times the default tolerance, below which contacts are held
FLOORS = {"plane": plane(), "mesh": fixed_box("floor", (4.0, 4.0, 1.0), (0.0, 0.0, -0.5))}
RADIUS, LENGTH, MASS = 0.1, 1.0, 2.0
DOWN = {"velocity": (0.0, 0.0, -1.0)}


def turned(*way):
    return {"quaternion": quaternion_of(np.array(way, dtype=float))}


def height(sim, row=0):
    """Gap [m] of a cylinder about z, radius 0.1, over the plane z = 0: c_z - h |u_z| - r |u x z|."""
    u = rotation_from_quaternion(sim.bodies.quaternion[row])[:, 2]
    return sim.bodies.position[row, 2] - 0.5 * LENGTH * abs(u[2]) - RADIUS * np.hypot(u[0], u[1])


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("axis", [0, 2], ids=["lying", "standing"])
def test_44_bounces(floor, axis):
    """t_n = t_1 (1 + 2 (e + ... + e^(n-1))), and it stays level."""
    e, low = 0.9, RADIUS if axis == 0 else 0.5 * LENGTH
    sim = Simulation(
        scene_of(cylinder(axis=axis, position=(0.1, 0.2, 1 + low)), FLOORS[floor], gravity=(0, 0, -G), restitution=e)
    )
    times = np.array(sorted(impact.time for impact in play(sim, 8.5, 0.05)))
    found = times[np.diff(times, prepend=0.0) > 1e-6]  # all rows of a face, which have rounding between them
    expected = np.sqrt(2.0 / G) * (1.0 + 2.0 * np.cumsum([0.0, *e ** np.arange(1, 44)]))
    np.testing.assert_allclose(found[:40], expected[:40], atol=1e-7)
    play(sim, 0.2, 0.05)
    assert np.abs(sim.bodies.velocity[0]).max() == 0.0
    assert 0.0 < sim.bodies.position[0, 2] - low < 1.2e-8
    np.testing.assert_allclose(np.abs(sim.bodies.quaternion[0]), [1, 0, 0, 0], atol=1e-12)
    (contact,) = sim.step(0.1).contacts
    assert abs(contact.held[2]) == pytest.approx(MASS * G * 0.1, rel=1e-12)


@pytest.mark.parametrize("floor", FLOORS)
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_tilted_one_falls_on_its_rim(floor, e):
    """j = (1 + e) v / (1/m + d^2 / I), d = r cos(a) - h sin(a) from the centre to the lowest point, level."""
    a = 0.4
    place = 0.3 + 0.5 * LENGTH * np.cos(a) + RADIUS * np.sin(a)
    tin = cylinder(position=(0, 0, place), **turned(0, a, 0), **DOWN)
    sim = Simulation(scene_of(tin, FLOORS[floor], restitution=e))
    (impact, *_) = play(sim, 0.301, 0.001)
    arm, inertia = RADIUS * np.cos(a) - 0.5 * LENGTH * np.sin(a), tin.inertia[1, 1]
    j = (1.0 + e) / (1.0 / MASS + arm**2 / inertia)
    assert impact.time == pytest.approx(0.3, abs=CLOSE)
    assert impact.impulse == pytest.approx(j, rel=CLOSE)
    if e > 0.0:  # else the rim rests, and the body turns about it
        np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 0.0, j / MASS - 1.0], atol=CLOSE)
        np.testing.assert_allclose(np.abs(sim.bodies.angular_velocity[0]), [0, abs(arm) * j / inertia, 0], atol=CLOSE)


def impulse_between(bodies, impact, e):
    """(1 + e) v / (1/m + 1/M + (r x n).I^-1 (r x n) + ...) of frictionless bodies that flew without turning."""
    ease, closing = 0.0, 0.0
    for body in bodies:
        sign = -1.0 if body.name == impact.body_a else 1.0
        closing -= sign * impact.normal @ body.velocity
        if isinstance(body.motion, Free):
            R = rotation_from_quaternion(body.quaternion)
            lever = R.T @ np.cross(impact.point - body.position - impact.time * body.velocity, impact.normal)
            ease += 1.0 / body.mass + lever @ np.linalg.solve(body.inertia, lever)
    return (1.0 + e) * closing / ease


DISC = {"radius": 0.4, "length": 0.2}
ON_EDGE = {"size": (0.6, 0.6, 0.6), "mass": 1.0, **turned(0, np.pi / 4, 0)}
ON_CORNER = {"size": (0.6, 0.6, 0.6), "mass": 1.0, **turned(0.7, 0.6, 0.1)}
TILT = turned(0.4, 0.3, 0.0)
CASES = {  # lower body, upper one, time and normal where they are plain
    "ball on face": (cylinder("low"), sphere("high", 0.2, position=(0.05, 0.02, 1.0)), 0.3, (0, 0, 1)),
    "ball on rim": (cylinder("low"), sphere("high", 0.2, position=(0.15, 0.0, 1.0)), 0.5 - np.sqrt(0.0375), None),
    "ball on side": (
        cylinder("low", axis=0),
        sphere("high", 0.2, position=(0.2, 0.05, 0.6)),
        0.6 - np.sqrt(0.0875),
        None,
    ),
    "capsule on face": (
        cylinder("low", **DISC),
        capsule("high", position=(0.1, 0, 1.0), **turned(0, 1.2, 0)),
        None,
        (0, 0, 1),
    ),
    "capsule on rim": (cylinder("low", **DISC), capsule("high", position=(0.1, 0, 1.0), **TILT), None, None),
    "capsule across": (cylinder("low", axis=0), capsule("high", axis=1, position=(0.2, 0.1, 0.5)), 0.3, (0, 0, 1)),
    "sides across": (cylinder("low", axis=0), cylinder("high", axis=1, position=(0.2, 0.1, 0.5)), 0.3, (0, 0, 1)),
    "rim on face": (cylinder("low", **DISC), cylinder("high", position=(0.1, 0.05, 0.9), **TILT), None, (0, 0, 1)),
    "rim on side": (cylinder("low", axis=0), cylinder("high", position=(0.1, 0.05, 0.9), **TILT), None, None),
    "rim on rim": (cylinder("low"), cylinder("high", position=(0.4, 0.05, 1.2), **turned(0.2, 0.9, 0)), None, None),
    "edge on side": (
        free_box("low", **ON_EDGE),
        cylinder("high", axis=0, position=(0.1, 0.1, 0.9)),
        0.8 - np.sqrt(0.18),
        (0, 0, 1),
    ),
    "edge on rim": (
        free_box("low", **ON_EDGE),
        cylinder("high", **DISC, position=(0.35, 0.1, 0.9), **turned(0.5, 0.4, 0)),
        None,
        None,
    ),
    "rim on a mesh": (free_box("low"), cylinder("high", position=(0.1, 0.1, 2.2), **TILT), None, (0, 0, 1)),
    "corner on side": (free_box("low", **ON_CORNER), cylinder("high", axis=0, position=(0, 0.05, 0.9)), None, None),
    "corner on face": (
        free_box("low", **ON_CORNER),
        cylinder("high", **DISC, position=(0, 0.05, 0.9)),
        None,
        (0, 0, 1),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_one_point(case):
    """The impulse is that of a point, nothing is lost but energy, and names change nothing."""
    low, high, time, normal = CASES[case]
    high = replace(high, velocity=np.array(DOWN["velocity"]))
    found = []
    for names in (("low", "high"), ("y", "x")):
        bodies = [replace(body, name=name, region=name) for body, name in zip((low, high), names, strict=True)]
        sim = Simulation(scene_of(*bodies, restitution=0.5))
        before, turning = momentum(sim), angular_momentum(sim)
        (impact,) = first_impacts(sim)
        assert impact.impulse == pytest.approx(impulse_between(bodies, impact, 0.5), rel=CLOSE)
        np.testing.assert_allclose(momentum(sim), before, atol=1e-12)
        np.testing.assert_allclose(angular_momentum(sim), turning, atol=1e-12)
        sign = 1.0 if impact.body_a == names[0] else -1.0
        if time is not None:
            assert impact.time == pytest.approx(time, abs=CLOSE)
        if normal is not None:
            np.testing.assert_allclose(sign * impact.normal, normal, atol=CLOSE)
        found.append(np.array([impact.time, impact.impulse, *impact.point, *(sign * impact.normal)]))
    np.testing.assert_allclose(found[0], found[1], atol=CLOSE)


def first_impacts(sim):
    """The impacts of the first step in which there are some."""
    for _ in range(100):
        if impacts := sim.step(0.01).impacts:
            return impacts
    return []


@pytest.mark.parametrize(
    ("low", "high", "points"),
    [
        (cylinder("low", axis=0), cylinder("high", axis=0, position=(0.4, 0, 0.5), **DOWN), [(-0.1, 0), (0.5, 0)]),
        (cylinder("low", axis=0), capsule("high", axis=0, position=(0.4, 0, 0.5), **DOWN), [(-0.1, 0), (0.5, 0)]),
        (
            cylinder("low", radius=0.3),
            cylinder("high", axis=0, position=(0.4, 0.18, 0.9), **DOWN),
            [(-0.1, 0.18), (0.24, 0.18)],
        ),
        (
            cylinder("low", radius=0.3),
            capsule("high", axis=0, position=(0.0, 0.18, 0.9), **DOWN),
            [(-0.24, 0.18), (0.24, 0.18)],
        ),
        (
            free_box("low", (0.4, 0.6, 0.8)),
            cylinder("high", axis=0, position=(0.1, 0.1, 0.8), **DOWN),
            [(-0.2, 0.1), (0.2, 0.1)],
        ),
        (
            free_box("low", **ON_EDGE),
            cylinder("high", axis=1, position=(0.0, 0.1, 0.8), **DOWN),
            [(0, -0.3), (0, 0.3)],
        ),
    ],
    ids=["sides", "a capsule beside", "side on face", "capsule on face", "side on a box", "side along an edge"],
)
def test_along_a_stretch(low, high, points):
    """Rows at its ends."""
    sim = Simulation(scene_of(low, high, restitution=1.0))
    start, before = energy(sim), angular_momentum(sim)
    impacts = first_impacts(sim)
    found = sorted(tuple(impact.point[:2]) for impact in impacts)
    np.testing.assert_allclose(found, points, atol=1e-7)
    assert energy(sim) == pytest.approx(start, rel=1e-12)
    np.testing.assert_allclose(angular_momentum(sim), before, atol=1e-12)


@pytest.mark.parametrize("floor", ["plane", "mesh"])
def test_rolling_down_an_incline(floor):
    """a = 2/3 g sin(a) with friction, g sin(a) without; with friction places are of first order in the step."""
    a, r = 0.3, 0.1
    turn = quaternion_of(np.array([0.0, a, 0.0]))
    R = rotation_from_quaternion(turn)
    slab = solid("slab", box([20.0, 2.0, 1.0]), density=1.0, motion=Fixed(), position=-R @ [0, 0, 0.5], quaternion=turn)
    ground = plane(normal=R @ [0, 0, 1.0]) if floor == "plane" else slab
    for friction, share, error in ((0.0, 1.0, CLOSE), (0.5, 2.0 / 3.0, 0.01)):
        tin = cylinder(radius=r, length=0.6, axis=1, position=R @ [-5.0, 0.3, r])
        sim = Simulation(scene_of(tin, ground, gravity=(0, 0, -G), restitution=0.0, friction=friction))
        play(sim, 1.0, 0.05)
        speed, row = share * G * np.sin(a), row_of(sim, "cylinder")
        np.testing.assert_allclose(R.T @ sim.bodies.velocity[row], [speed, 0, 0], atol=1e-7)
        np.testing.assert_allclose(R.T @ sim.bodies.position[row], [0.5 * speed - 5.0, 0.3, r], atol=error)
        turning = speed / r if friction > 0.0 else 0.0
        np.testing.assert_allclose(sim.bodies.angular_velocity[row], [0.0, turning, 0.0], atol=1e-6)


def test_a_stack_at_rest():
    """Whatever the names: unmoved, and what is held carries what is above."""
    for low, high in (("a", "b"), ("b", "a")):
        bodies = (
            cylinder(low, 0.3, 0.4, 2.0, position=(0, 0, 0.2)),
            cylinder(high, 0.2, 0.4, 1.0, position=(0.05, 0.02, 0.6)),
        )
        sim = Simulation(scene_of(*bodies, plane(), gravity=(0, 0, -G), restitution=0.3))
        play(sim, 1.0, 0.05)
        places = np.array([sim.bodies.position[row_of(sim, name)] for name in (low, high)])
        held = [abs(contact.held[2]) for contact in sim.step(0.1).contacts]
        assert np.abs(sim.bodies.velocity).max() == 0.0
        np.testing.assert_allclose(places, [(0, 0, 0.2), (0.05, 0.02, 0.6)], atol=2e-8)
        assert sorted(held) == pytest.approx([0.1 * G, 0.3 * G], rel=1e-9)


@pytest.mark.parametrize(("x", "stays"), [(0.3, True), (0.6, False)])
@pytest.mark.parametrize("axis", [0, 2], ids=["lying", "standing"])
def test_over_the_edge_of_a_table(axis, x, stays):
    """It stays while its centre is over the table, else it tips over."""
    shape = {"axis": 0} if axis == 0 else {"radius": 0.2, "length": 0.6}
    low = 0.1 if axis == 0 else 0.3
    tin = cylinder(position=(x, 0, 0.5 + low), **shape)
    sim = Simulation(scene_of(tin, fixed_box("table", (1, 1, 1), (0, 0, 0)), gravity=(0, 0, -G)))
    start, row = energy(sim), 0
    play(sim, 0.2, 0.02)
    assert energy(sim) == pytest.approx(start, abs=1e-7)
    if stays:
        np.testing.assert_allclose(sim.bodies.position[row], (x, 0, 0.5 + low), atol=CLOSE)
    else:
        assert sim.bodies.angular_velocity[row, 1] > 0.1
        assert sim.bodies.position[row, 2] < 0.5 + low - 1e-3


def test_it_wobbles_to_rest():
    """Dropped askew it comes to stand, and is never below the plane."""
    tin = cylinder(radius=RADIUS, length=LENGTH, position=(0, 0, 0.55), **turned(0.02, 0.01, 0.0))
    sim = Simulation(scene_of(tin, plane(), gravity=(0, 0, -G), restitution=0.3, friction=0.3))
    for _ in range(60):
        sim.step(0.05)
        assert height(sim) > 0.0
    assert np.abs(sim.bodies.velocity[0]).max() == 0.0
    assert height(sim) < 1.2e-8


def test_a_heap_in_a_box_of_planes_keeps_its_energy():
    rng, bodies = np.random.default_rng(3), []
    for i, place in enumerate(np.ndindex(3, 3, 3)):
        state = {
            "position": np.array(place) - 1.0 + 0.05 * rng.uniform(-1, 1, 3),
            "velocity": rng.normal(size=3),
            "angular_velocity": rng.normal(size=3),
        }
        if i % 4 == 0:
            bodies.append(sphere(f"ball {i}", 0.3, **state))
        elif i % 4 == 1:
            bodies.append(free_box(f"cube {i}", (0.4, 0.4, 0.4), 1.0, **state))
        elif i % 4 == 2:
            bodies.append(capsule(f"rod {i}", 0.15, 0.4, 1.0, i % 2, **state))
        else:
            bodies.append(cylinder(f"tin {i}", 0.2, 0.4, 1.0, i % 3, **state))
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
    "ball": sphere(position=(0.05, 0, 0.6)),
    "rod": capsule("other", axis=1, position=(0.1, 0, 0.1)),
    "tin": cylinder("other", axis=1, position=(0.1, 0, 0.1)),
}


@pytest.mark.parametrize("other", OTHERS)
def test_overlap_at_the_start(other):
    with pytest.raises(SceneError, match="overlap at the start"):
        Simulation(scene_of(cylinder(position=(0, 0, 0.45)), OTHERS[other]))
