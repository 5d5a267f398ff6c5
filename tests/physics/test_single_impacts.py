"""One impact of two bodies at a corner, an edge or a patch, against the formulas of VALIDATION B."""

import numpy as np
import pytest
from played import play, row_of
from scenes_by_hand import fixed_box, free_box, plane, scene_of

from comotion_server.quaternions import quaternion_of, rotation_from_quaternion
from comotion_server.simulation import Simulation

EXACT = 1e-9  # what meshes at the default tolerance have to reach
ELASTICITIES = [0.0, 0.4, 1.0]


def inertia_world(sim, name):
    body = sim.scene.bodies[row_of(sim, name)]
    R = rotation_from_quaternion(sim.bodies.quaternion[row_of(sim, name)])
    return R @ body.inertia @ R.T


def energy(sim):
    total = 0.0
    for row, body in enumerate(sim.scene.bodies):
        if np.isfinite(body.mass):
            v, w = sim.bodies.velocity[row], sim.bodies.angular_velocity[row]
            total += 0.5 * body.mass * v @ v + 0.5 * w @ inertia_world(sim, body.name) @ w
    return total


@pytest.mark.parametrize("e", ELASTICITIES)
def test_a_corner_hits_the_face_of_a_free_body(e):
    """j = -(1 + e) v_n / (1/m1 + 1/m2 + n.[(I1^-1 (r1 x n)) x r1 + (I2^-1 (r2 x n)) x r2])."""
    n = np.array([1.0, 0.0, 0.0])
    turn = quaternion_of(np.array([0.4, 0.5, 0.7]))
    edges, speed = np.array([0.4, 0.6, 0.8]), 1.5
    corners = np.array([[(i >> k) & 1 for k in range(3)] for i in range(8)]) - 0.5
    arms = (corners * edges) @ rotation_from_quaternion(turn).T
    r1 = arms[np.argmax(arms[:, 0])]  # the corner that is foremost along x
    target = np.array([0.5, 0.25, -0.3])  # where it lands on the face x = 0.5 of the other body, seen from its centre
    start = target - r1 - 0.3 * n
    a = free_box("a", edges, 2.0, position=start, quaternion=turn, velocity=(speed, 0.0, 0.0))
    b = free_box("b", (1.0, 1.2, 1.4), 3.0, position=(1.0, 0.0, 0.0))
    sim = Simulation(scene_of(a, b, restitution=e))
    r2 = target - np.array([1.0, 0.0, 0.0])
    I1, I2 = inertia_world(sim, "a"), inertia_world(sim, "b")
    softness = (
        1 / 2.0 + 1 / 3.0 + sum(np.cross(np.linalg.solve(I, np.cross(r, n)), r) @ n for I, r in ((I1, r1), (I2, r2)))
    )
    j = (1.0 + e) * speed / softness
    before = energy(sim)
    (impact,) = play(sim, 0.3, 0.01)
    np.testing.assert_allclose(impact.time, 0.2, atol=EXACT)
    np.testing.assert_allclose(impact.normal, n, atol=1e-14)
    np.testing.assert_allclose(impact.point, target + 1e-9, atol=2e-9)
    assert impact.impulse == pytest.approx(j, rel=1e-9)
    assert impact.approach_speed == pytest.approx(speed, rel=1e-12)
    np.testing.assert_allclose(sim.bodies.velocity, [(speed - j / 2.0) * n, j / 3.0 * n], atol=1e-9)
    assert energy(sim) - before == pytest.approx(-0.5 * (1 - e * e) * speed**2 / softness, abs=1e-12)


@pytest.mark.parametrize("e", ELASTICITIES)
@pytest.mark.parametrize("degrees", [10.0, 30.0, 44.0])
def test_a_cube_lands_on_an_edge(degrees, e):
    """j = (1 + e) 2 / (1 + 6 d^2), d = sin(45 deg - theta) / sqrt 2, both ends of the edge at once."""
    theta = np.radians(degrees)
    turn = quaternion_of(np.array([0.0, theta, 0.0]))
    cube = free_box("cube", (1, 1, 1), 1.0, position=(0.0, 0.0, 1.0), quaternion=turn, velocity=(0.0, 0.0, -2.0))
    sim = Simulation(scene_of(cube, plane(), restitution=e))
    impacts = play(sim, 0.3, 0.01)
    d = np.sin(np.pi / 4 - theta) / np.sqrt(2.0)
    j = (1.0 + e) * 2.0 / (1.0 + 6.0 * d * d)
    at = min(impact.time for impact in impacts)
    first = [impact for impact in impacts if impact.time == at]
    assert at == pytest.approx((1.0 - np.cos(np.pi / 4 - theta) / np.sqrt(2.0)) / 2.0, abs=EXACT)
    assert sum(impact.impulse for impact in first) == pytest.approx(j, rel=EXACT)
    if len(impacts) == len(first):  # no second landing within the time played
        np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 0.0, j - 2.0], atol=EXACT)
        # the edge lies on the side of negative x: the push from below turns about +y
        np.testing.assert_allclose(np.abs(sim.bodies.angular_velocity[0]), [0.0, 6.0 * d * j, 0.0], atol=EXACT)


@pytest.mark.parametrize("e", ELASTICITIES)
@pytest.mark.parametrize("degrees", [15.0, 60.0])
def test_a_rod_falls_on_a_floor(degrees, e):
    """j = (1 + e) m |v| / (1 + 3 cos^2 theta) for a rod without thickness; here 1 : 1e5, to its square."""
    theta, length, mass, speed = np.radians(degrees), 2.0, 1.5, 1.0
    thickness = 1e-5 * length
    turn = quaternion_of(np.array([0.0, theta, 0.0]))
    rod = free_box(
        "rod",
        (length, thickness, thickness),
        mass,
        position=(0.0, 0.0, 1.1),
        quaternion=turn,
        velocity=(0.0, 0.0, -speed),
    )
    sim = Simulation(scene_of(rod, plane(), restitution=e))
    impacts = play(sim, 0.4, 0.01)
    if not impacts:
        impacts = play(sim, 0.6, 0.01)
    at = impacts[0].time
    j = sum(impact.impulse for impact in impacts if impact.time == at)
    slope = thickness / length * np.tan(theta)  # the landing edge is this much nearer the middle, or farther
    assert j == pytest.approx((1.0 + e) * mass * speed / (1.0 + 3.0 * np.cos(theta) ** 2), rel=20.0 * slope)
    arm = 0.5 * (length * np.cos(theta) - thickness * np.sin(theta))
    inertia = mass * (length**2 + thickness**2) / 12.0
    assert j == pytest.approx((1.0 + e) * speed / (1.0 / mass + arm**2 / inertia), rel=EXACT)


AFTER = 1e-3  # [s] of flight after an impact


@pytest.mark.parametrize("end", [0.5, 0.75])
def test_a_bar_that_falls_flat_on_a_ledge_beside_its_middle_turns(end):
    """e = 0, ledge from L/4 outwards: for a thin bar v = -3 v / 7 and omega = 12 v / (7 L); here with its own inertia.

    The paper's criterion for parallel faces says that it does not turn.
    """
    length, height, mass, speed = 2.0, 0.02, 1.0, 1.0
    bar = free_box("bar", (length, 0.1, height), mass, position=(0.0, 0.0, 0.5), velocity=(0.0, 0.0, -speed))
    width = (end - 0.25) * length
    ledge = fixed_box("ledge", (width, 1.0, 1.0), (0.25 * length + width / 2, 0.0, -0.5))
    sim = Simulation(scene_of(bar, ledge, restitution=0.0))
    impacts = play(sim, 0.49 + AFTER, AFTER)
    arm, inertia = length / 4, mass * (length**2 + height**2) / 12.0
    j = speed / (1.0 / mass + arm**2 / inertia)
    assert sum(impact.impulse for impact in impacts) == pytest.approx(j, abs=EXACT)
    # afterwards the edge presses on the bar that slides over it, by some 0.004 N
    np.testing.assert_allclose(sim.bodies.velocity[0], [0.0, 0.0, -speed + j / mass], atol=0.005 * AFTER)
    np.testing.assert_allclose(sim.bodies.angular_velocity[0], [0.0, -arm * j / inertia, 0.0], atol=0.01 * AFTER)
    assert sim.bodies.velocity[0, 2] == pytest.approx(-3.0 / 7.0, abs=2e-4)  # thin: (h / L)^2 = 1e-4
    assert sim.bodies.angular_velocity[0, 1] == pytest.approx(-12.0 / (7.0 * length), abs=2e-4)


@pytest.mark.parametrize("e", ELASTICITIES)
def test_friction_slows_a_plate_that_lands_flat_by_mu_times_the_impulse(e):
    """Sliding: v_t falls by mu (1 + e) |v_n|; with enough of it the plate sticks. The patch keeps it from turning."""
    for mu, slip in ((0.0, 1.0), (0.1, 1.0 - 0.1 * (1.0 + e) * 2.0), (5.0, 0.0)):
        plate = free_box("plate", (1.0, 1.0, 0.05), 1.0, position=(0.0, 0.0, 0.125), velocity=(1.0, 0.0, -2.0))
        sim = Simulation(scene_of(plate, plane(), restitution=e, friction=mu))
        play(sim, 0.06, 0.01)
        row = row_of(sim, "plate")
        np.testing.assert_allclose(sim.bodies.velocity[row], [slip, 0.0, 2.0 * e], atol=EXACT)
        np.testing.assert_allclose(sim.bodies.angular_velocity[row], 0.0, atol=EXACT)
