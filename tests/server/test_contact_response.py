"""One impact against the formula of rigid-body collisions, and its books (VALIDATION B)."""

import numpy as np
import pytest
from scenes_by_hand import free_box, moved_box, scene_of

from comotion_server.contact_response import Ledger, Touch, respond
from comotion_server.scene import Free
from comotion_server.world import World

ROUNDING = 1e-13  # of the scale of each book


def random_rotation(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def random_box(name, rng, **state):
    return free_box(
        name,
        size=rng.uniform(0.1, 2.0, 3),
        mass=10.0 ** rng.uniform(-3, 3),
        position=rng.normal(size=3),
        quaternion=random_rotation(rng),
        velocity=rng.normal(size=3),
        angular_velocity=rng.normal(size=3),
        **state,
    )


def collide(a, b, rng, *, restitution=1.0, parallel=False):
    """The world after one impact of two bodies, a to the left of the contact normal; its ledger; the touch."""
    world, ledger = World(scene_of(a, b, restitution=restitution)), Ledger()
    world.take_off(np.zeros((2, 3)), np.zeros((2, 3)))
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    point = rng.normal(size=3)
    touch = Touch(0, 1, point, point + 0.01 * n, n)
    answered = respond(world, ledger, touch, 0.0, 0.0, parallel=parallel)
    return world, ledger, touch, answered


def contact_velocity(body, point):
    return body.velocity + np.cross(body.angular_velocity, point - body.position)


def kinetic_energy(state, bodies):
    moving = sum(0.5 * body.mass * velocity @ velocity for body, velocity in zip(bodies, state.velocity, strict=True))
    return moving + 0.5 * np.sum(state.momentum * state.spin)


@pytest.mark.parametrize("restitution", [1.0, 0.3, 0.0])
def test_impulse_energy_and_momentum_of_random_pairs(rng, restitution):
    """j = -(1 + e) v_n / (1/m1 + 1/m2 + n.[(I1^-1 (r1 x n)) x r1 + (I2^-1 (r2 x n)) x r2]) for any two bodies."""
    hits = 0
    for _ in range(100):
        a, b = random_box("a", rng), random_box("b", rng)
        before = World(scene_of(a, b)).state
        world, ledger, touch, answered = collide(a, b, rng, restitution=restitution)
        n = touch.normal
        ease = closing = 0.0
        for body, R, point, sign in (
            (a, before.rotation[0], touch.point_a, 1),
            (b, before.rotation[1], touch.point_b, -1),
        ):
            r = point - body.position
            inverse = np.linalg.inv(R @ body.inertia @ R.T)
            ease += 1.0 / body.mass + n @ np.cross(inverse @ np.cross(r, n), r)
            closing += sign * n @ contact_velocity(body, point)
        assert answered == (closing > 0.0)
        if not answered:
            continue
        hits += 1
        (impact,) = ledger.impacts
        assert impact.impulse == pytest.approx((1.0 + restitution) * closing / ease, rel=1e-11)
        assert impact.approach_speed == pytest.approx(closing, rel=1e-12, abs=1e-14)
        books = ledger.books
        assert max(books.momentum, books.angular_momentum, books.energy) < ROUNDING
        lost = (1.0 - restitution**2) * closing**2 / ease / 2.0
        assert kinetic_energy(world.state, (a, b)) == pytest.approx(kinetic_energy(before, (a, b)) - lost, rel=1e-12)
    assert hits > 30


@pytest.mark.parametrize(
    "motion",
    [
        Free(locked=(False, False, True, True, True, True)),
        Free(locked=(True, False, False, True, True, False)),
        Free(reacts=False),
    ],
)
def test_books_close_where_directions_are_locked_or_a_body_does_not_react(rng, motion):
    hits = 0
    for _ in range(60):
        a, b = random_box("a", rng, motion=motion), random_box("b", rng)
        world, ledger, _, answered = collide(a, b, rng, restitution=0.5)
        hits += answered
        books = ledger.books
        assert max(books.momentum, books.angular_momentum, books.energy) < ROUNDING
        locked = np.array(motion.locked[:3])
        np.testing.assert_array_equal(world.state.velocity[0, locked], 0.0)
    assert hits > 10


def test_a_body_that_does_not_react_keeps_its_motion():
    a = free_box("a", position=(-1.0, 0.0, 0.0), velocity=(2.0, 0.0, 0.0), motion=Free(reacts=False))
    b = free_box("b", position=(1.0, 0.0, 0.0))
    world, ledger = World(scene_of(a, b, restitution=1.0)), Ledger()
    world.take_off(np.zeros((2, 3)), np.zeros((2, 3)))
    point = np.zeros(3)
    respond(world, ledger, Touch(0, 1, point, point, np.array([1.0, 0.0, 0.0])), 0.0, 0.0, parallel=False)
    np.testing.assert_array_equal(world.state.velocity, [[2.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    assert ledger.books.energy < ROUNDING  # the work of the pushing body is booked


def test_a_prescribed_body_hits_like_a_moving_wall():
    wall = moved_box("a", (1.0, 1.0, 1.0), (-1.0, 0.0, 0.0), (3.0, 0.0, 0.0))
    ball = free_box("b", position=(1.0, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0))
    world, ledger = World(scene_of(wall, ball, restitution=0.5)), Ledger()
    world.take_off(np.zeros((2, 3)), np.zeros((2, 3)))
    point = np.zeros(3)
    respond(world, ledger, Touch(0, 1, point, point, np.array([1.0, 0.0, 0.0])), 0.0, 0.0, parallel=False)
    np.testing.assert_allclose(world.state.velocity[1], [3.0 + 0.5 * 4.0, 0.0, 0.0], rtol=1e-15)
    assert ledger.books.energy < ROUNDING


def test_a_parallel_contact_pushes_without_turning():
    """P12: restitution acts on the closing speed of the centres, with the masses alone."""
    a = free_box("a", mass=1.0, position=(-1.0, 0.0, 0.0), velocity=(2.0, 0.0, 0.0), angular_velocity=(0.1, 0.2, 0.3))
    b = free_box("b", mass=3.0, position=(1.0, 0.0, 0.0))
    world, ledger = World(scene_of(a, b, restitution=0.5)), Ledger()
    world.take_off(np.zeros((2, 3)), np.zeros((2, 3)))
    corner = np.array([0.0, 1.0, 1.5])
    respond(world, ledger, Touch(0, 1, corner, corner, np.array([1.0, 0.0, 0.0])), 0.0, 0.0, parallel=True)
    impulse = 1.5 * 2.0 / (1.0 + 1.0 / 3.0)
    np.testing.assert_allclose(world.state.velocity, [[2.0 - impulse, 0, 0], [impulse / 3.0, 0, 0]], rtol=1e-15)
    np.testing.assert_allclose(world.state.spin, [[0.1, 0.2, 0.3], [0, 0, 0]], rtol=1e-15)
    assert ledger.impacts[0].law == "parallel"
    assert max(ledger.books.momentum, ledger.books.angular_momentum, ledger.books.energy) < ROUNDING


def test_a_rod_on_a_plane():
    """j = (1 + e) m |v| / (1 + 3 cos^2 theta) for a thin rod at theta to the plane, hit at its end."""
    thin, length, theta, e = 1e-4, 1.0, 0.6, 0.7
    q = np.array([np.cos(-theta / 2), 0.0, np.sin(-theta / 2), 0.0])  # about y: the end at -x goes down
    rod = free_box("rod", size=(length, thin, thin), mass=2.0, quaternion=q, velocity=(0.0, 0.0, -1.5))
    floor = moved_box("floor", (9.0, 9.0, 1.0), (0.0, 0.0, -3.0), (0.0, 0.0, 0.0))
    world, ledger = World(scene_of(floor, rod, restitution=e)), Ledger()
    world.take_off(np.zeros((2, 3)), np.zeros((2, 3)))
    tip = world.state.rotation[1] @ [-length / 2, 0.0, 0.0]
    respond(world, ledger, Touch(0, 1, tip, tip, np.array([0.0, 0.0, 1.0])), 0.0, 0.0, parallel=False)
    # the rod's own thickness changes its inertia by a relative 1e-8
    expected = (1 + e) * 2.0 * 1.5 / (1 + 3 * np.cos(theta) ** 2)
    assert ledger.impacts[0].impulse == pytest.approx(expected, rel=1e-7)
