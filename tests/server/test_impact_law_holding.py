"""Contacts that are held, velocities that are settled, positions that are shifted: the same projection."""

import numpy as np
import pytest
from clusters_by_hand import Clump
from random_clusters import opening_speeds, random_clump, turned
from scipy.optimize import nnls

from comotion_server.kernels.cluster_rows import Rows
from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.impact_cluster import BLOCKED, SOLVED, displacements, hold, is_sound, settle_velocities

ROUNDING = 1e-13
G = 9.81


def held(clump, force, torque=None, bias=None):
    """Accelerations, changes of angular momentum, forces, and the contacts of a certificate."""
    bodies, contacts, _, R, L, w = clump.arrays()
    n, c = len(w), len(clump.rows)
    acceleration, change = np.zeros((n, 3)), np.zeros((n, 3))
    pressing, certificate = np.zeros(c), np.zeros(c, bool)
    torque = np.zeros((n, 3)) if torque is None else torque
    bias = np.zeros(c) if bias is None else np.asarray(bias, float)
    push = np.asarray(force, float)
    status = hold(bodies, contacts, c, bias, push, torque, R, L, w, acceleration, change, pressing, certificate)
    return status, acceleration, change, pressing, certificate


def box_on_floor(x=0.0):
    clump = Clump()
    floor_, box = clump.given(), clump.body(2.0, (0.3, 0.4, 0.5))
    for dx in (-0.5, 0.5):
        for dy in (-0.5, 0.5):
            clump.touch(floor_, box, (0, 0, 1), 0.5, (dx, dy, 0), (dx - x, dy, -0.2))
    return clump


def test_box_on_four_corners_rests():
    status, acceleration, change, pressing, _ = held(box_on_floor(), [[0, 0, 0], [0, 0, -2 * G]])
    assert status == SOLVED
    assert np.abs(acceleration).max() <= ROUNDING
    assert np.abs(change).max() <= ROUNDING
    np.testing.assert_allclose(pressing, 2 * G / 4, rtol=1e-13)


def test_off_centre_box_shares_its_weight():
    """Centre at x = .3 of corners at +-.5: moments leave .2 and .8 of the weight on the two sides."""
    _, acceleration, _, pressing, _ = held(box_on_floor(0.3), [[0, 0, 0], [0, 0, -2 * G]])
    assert np.abs(acceleration).max() <= ROUNDING * G
    np.testing.assert_allclose(pressing, 2 * G * np.array([0.1, 0.1, 0.4, 0.4]), rtol=1e-12)


def test_box_over_the_edge_tips():
    """Its centre beyond the corners: two corners carry it while it turns about them."""
    mass, x, inertia = 2.0, 0.7, 0.4
    _, acceleration, change, pressing, _ = held(box_on_floor(x), [[0, 0, 0], [0, 0, -mass * G]])
    arm = x - 0.5
    total = mass * G / (1 + mass * arm * arm / inertia)  # of the corners, frictionless: N (1/m + arm^2/I) = g
    np.testing.assert_allclose(pressing, [0, 0, total / 2, total / 2], rtol=1e-12, atol=1e-12)
    assert acceleration[1, 2] == pytest.approx(total / mass - G, abs=1e-12)
    assert change[1, 1] == pytest.approx(arm * total, abs=1e-12)


def test_stack_of_mass_ratio_1e10():
    """A light body under a heavy one: forces are the weights above, nothing moves."""
    clump, masses = Clump(), [1.0, 1e10, 1.0]
    below, weight = clump.given(), np.zeros((4, 3))
    for mass in masses:
        above = clump.ball((0, 0, 0), mass)
        clump.touch(below, above, (0, 0, 1), 0.0)
        weight[above, 2] = -mass * G
        below = above
    _, acceleration, _, pressing, _ = held(clump, weight)
    np.testing.assert_allclose(pressing, [sum(masses[i:]) * G for i in range(3)], rtol=1e-12)
    assert np.abs(acceleration).max() <= 1e-4 * G  # eps of 1e10 weights on one unit mass: 1e-6


@pytest.mark.parametrize("count", [20, 300])
def test_column_bears_its_weight(count):
    """The forces are the weights above; 300 contacts are answered by the sparse method."""
    clump, weight = Clump(), np.zeros((count + 1, 3))
    clump.given()
    for i in range(count):
        clump.ball((0, 0, 0))
        clump.touch(i, i + 1, (0, 0, 1), 0.0)
    weight[1:, 2] = -G
    _, acceleration, _, pressing, _ = held(clump, weight)
    np.testing.assert_allclose(pressing, G * np.arange(count, 0, -1), rtol=1e-10)
    assert np.abs(acceleration).max() <= 1e-11 * G


def test_body_lifts_off_where_bias_opens():
    clump = Clump()
    clump.touch(clump.given(), clump.ball((0, 0, 0)), (0, 0, 1), 0.0)
    _, acceleration, _, pressing, _ = held(clump, [[0, 0, 0], [0, 0, -G]], bias=[2 * G])
    assert pressing[0] == 0.0
    assert acceleration[1, 2] == -G


def test_gyroscopic_moment_of_a_free_body(rng):
    """Without contact forces dL/dt is the torque alone; held, L changes by the contacts' moments as well."""
    clump = Clump()
    floor_, top = clump.given(), clump.body(1.0, (0.2, 0.3, 0.4), w=(1, 2, 3), R=turned(rng))
    clump.touch(floor_, top, (0, 0, 1), 0.0, (0, 0, 0), (0.1, 0.2, -0.3))
    torque = rng.normal(size=(2, 3))
    bodies, _, _, R, L, w = clump.arrays()
    _, acceleration, change, pressing, _ = held(clump, [[0, 0, 0], [0, 0, -G]], torque)
    inertia = R[top] @ np.diag(bodies.moments[top]) @ R[top].T
    arm = np.array([0.1, 0.2, -0.3])
    np.testing.assert_allclose(change[top], torque[top] + np.cross(arm, [0, 0, pressing[0]]), rtol=0, atol=1e-13)
    alpha = np.linalg.solve(inertia, change[top] - np.cross(w[top], L[top]))
    if pressing[0] > 0:
        assert (acceleration[top] + np.cross(alpha, arm))[2] == pytest.approx(0.0, abs=1e-12)


def test_forces_against_least_squares(rng):
    """Held forces solve min |M^-1/2 (F + N f)|, f >= 0: the same by Lawson and Hanson."""
    for _ in range(40):
        clump = random_clump(rng, "mixed")
        clump.w = [0 * w for w in clump.w]
        n, reacts = len(clump.mass), np.array(clump.reacts)
        force, torque = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
        status, acceleration, _, _, _ = held(clump, force, torque)
        assert status == SOLVED
        columns = []
        for a, b, normal, arm_a, arm_b in clump.rows:
            column = np.zeros((n, 6))
            column[a], column[b] = (
                -np.append(normal, np.cross(arm_a, normal)),
                np.append(normal, np.cross(arm_b, normal)),
            )
            columns.append(column)
        root = np.zeros((n, 6, 6))
        for i in np.flatnonzero(reacts):
            root[i, :3, :3] = np.eye(3) / np.sqrt(clump.mass[i])
            root[i, 3:, 3:] = np.diag(1 / np.sqrt(clump.moments[i])) @ clump.R[i].T
        A = np.array([np.einsum("ijk,ik->ij", root, column).ravel() for column in columns])
        x = np.einsum("ijk,ik->ij", root, np.hstack([force, torque])).ravel()
        f, _ = nnls(A.T, -x)
        y = (x + A.T @ f).reshape(n, 6)[:, :3] / np.sqrt(np.array(clump.mass))[:, None]
        touched = reacts & np.isin(np.arange(n), [row[:2] for row in clump.rows])
        np.testing.assert_allclose(acceleration[touched], y[touched], rtol=0, atol=1e-10)


def test_pinch_under_prescribed_acceleration_is_blocked():
    clump = Clump()
    hull, floe, wall = clump.given(), clump.ball((0, 0, 0)), clump.given()
    clump.touch(hull, floe, (1, 0, 0), 0.0)
    clump.touch(floe, wall, (1, 0, 0), 0.0)
    status, _, _, _, certificate = held(clump, np.zeros((3, 3)), bias=[-1.0, 0.0])
    assert status == BLOCKED
    assert certificate.all()


def settle(clump, equal, target):
    bodies, contacts, v, R, L, w = clump.arrays()
    c = len(clump.rows)
    impulse, certificate = np.zeros(c), np.zeros(c, bool)
    status = settle_velocities(bodies, contacts, c, equal, target, v, R, L, w, impulse, certificate)
    return status, v, w, impulse


def test_settled_velocities_open_as_told(rng):
    for _ in range(40):
        clump = random_clump(rng, "mixed")
        if len(clump.rows) > 5 or len(clump.mass) < 4:
            continue
        c = len(clump.rows)
        equal, target = np.arange(c) % 2 == 0, 0.1 * rng.normal(size=c)
        status, v, w, impulse = settle(clump, equal, target)
        u = opening_speeds(clump, v, w)
        assert status == SOLVED
        np.testing.assert_allclose(u[equal], target[equal], rtol=0, atol=1e-12)
        assert (u - target).min() >= -1e-12
        assert impulse[~equal].min(initial=0.0) >= 0.0


def test_patch_with_tilted_normals_is_settled_without_a_kick():
    """Four equalities whose normals differ by 1e-8: the weak direction is left out, the box does not jump sideways."""
    clump = Clump()
    floor_, box = clump.given(), clump.body(1.0, (1 / 6,) * 3, v=(0.3, 0, 1e-6), spin=SPIN_FREE)
    for x in (-0.5, 0.5):
        for y in (-0.5, 0.5):
            clump.touch(floor_, box, (1e-8 * x, 3e-8 * y, 1), 0.0, (x, y, -0.5), (x, y, -0.5))
    status, v, _, _ = settle(clump, np.ones(4, bool), np.zeros(4))
    assert status == SOLVED
    np.testing.assert_allclose(v[box, :2], (0.3, 0), rtol=0, atol=1e-12)
    assert abs(v[box, 2]) <= 1e-8


def pack_of_floes(noise):
    """Five floes in a plane; two contacts of one pair have normals that differ by 1e-9, and one is an equality."""
    clump, moments, arms = Clump(), (0.00191145652, 0.00191145659, 0.00379916831), iter(noise)
    for v, spin in (
        ((0.958221648, 0.056922242), -0.832697774),
        ((0.999556744, -0.052376086), -1.301262133),
        ((0.984901296, 0.106061995), -1.203575994),
        ((0.837992161, 0.184192394), -1.436428459),
        ((0.991212762, -0.046461071), -0.894233384),
    ):
        clump.body(0.58355226356, moments, (*v, 0), (0, 0, spin), free=(1, 1, 0), spin=2)
    for a, b, n, arm_a, arm_b in (
        (0, 4, (0.9703221640040025, 0.241815834970726), (0.117975633, -0.025727), (-0.093677808, -0.082761515)),
        (1, 2, (0.984173094215845, 0.1772098208949198), (0.095464325, 0.080694254), (-0.116504133, 0.036155207)),
        (1, 2, (0.9841730942703847, 0.17720982059202156), (0.095464325, 0.080694254), (-0.116504133, 0.036155207)),
        (1, 4, (-0.9841732625081947, -0.17720888624438663), (-0.098243088, -0.065261707), (0.118512477, -0.039746602)),
        (2, 3, (0.3386183260770523, 0.9409238169186573), (0.087619368, 0.083517549), (0.021503662, -0.123136477)),
    ):
        clump.touch(a, b, (*n, 0), 0.0, (*(arm_a + next(arms)), 0), (*(arm_b + next(arms)), 0))
    return clump


def test_contacts_that_differ_by_noise_alone_get_no_more_than_what_they_close_by(rng):
    """One corner closed exactly, the other not: without the noise they are one condition, and so they are with it."""
    equal = np.array([True, True, False, True, True])
    for _ in range(200):
        clump = pack_of_floes(1e-9 * rng.normal(size=(10, 2)))
        status, v, w, impulse = settle(clump, equal, np.zeros(5))
        assert status == SOLVED
        np.testing.assert_allclose(opening_speeds(clump, v, w), 0.0, rtol=0, atol=2e-8)
        assert np.abs(impulse).max() <= 1e-7
        gained = np.array(clump.mass) @ (v - np.array(clump.v))
        np.testing.assert_allclose(gained, 0.0, rtol=0, atol=1e-15)


def test_edge_held_in_its_middle_is_not_kicked_by_its_ends(rng):
    """Three points in a line, the middle one closed exactly: the third depends on both others but for noise."""
    for _ in range(200):
        clump = Clump()
        floor_, box = clump.given(), clump.body(1.0, (1 / 6,) * 3, v=(0.3, 0.2, 1e-6), spin=SPIN_FREE)
        for x in (0.0, -0.5, 0.5):
            clump.touch(floor_, box, (*(1e-9 * rng.normal(size=2)), 1), 0.0, (x, 0, -0.5), (x, 0, -0.5))
        status, v, _, impulse = settle(clump, np.array([True, False, False]), np.zeros(3))
        assert status == SOLVED
        np.testing.assert_allclose(v[box], (0.3, 0.2, 0.0), rtol=0, atol=2e-8)
        assert np.abs(impulse).max() <= 1e-5


def test_a_projection_of_rounding_is_not_sound():
    """Multipliers do no work against rows at their bounds: what is off by more than rounding is told."""
    rows = Rows(np.array([[0, -1]]), np.array([[[1.0, 0, 0, 0, 0, 0], [0.0] * 6]]), np.ones(1))
    x, y = np.zeros((1, 6)), np.zeros((1, 6))
    y[0, 0] = 1.0
    assert is_sound(rows, np.ones(1), np.ones(1), x, y)
    assert is_sound(rows, np.full(1, 0.5), np.zeros(1), x, y)
    assert not is_sound(rows, np.full(1, 0.5), np.ones(1), x, y)


def test_displacements_open_gaps(rng):
    for _ in range(40):
        clump = random_clump(rng, "mixed")
        if len(clump.rows) > 5 or len(clump.mass) < 4:
            continue
        bodies, contacts, _, R, _, _ = clump.arrays()
        n, c = len(clump.mass), len(clump.rows)
        shift, turn, target = np.zeros((n, 3)), np.zeros((n, 3)), 1e-8 * rng.normal(size=c)
        equal, certificate = np.arange(c) == 0, np.zeros(c, bool)
        status = displacements(bodies, contacts, c, equal, target, R, shift, turn, certificate)
        opened = opening_speeds(clump, shift, turn)
        assert status == SOLVED
        assert opened[0] == pytest.approx(target[0], abs=1e-20)
        assert (opened - target).min() >= -1e-20
