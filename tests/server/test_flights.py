"""Flights against closed forms and an independent integrator (VALIDATION A)."""

import numpy as np
import pytest
from scenes_by_hand import free_box, scene_of
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from comotion_server.kernels.flight import AXIS, SPLIT, SYMMETRIC, kind_of_spin, split
from comotion_server.simulation import Simulation

NO_TORQUE = np.zeros(3)


def hat(w):
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def attitude_by_dop853(moments, momentum, torque, duration):
    """R' = w^ R with w = R I^-1 R^T (L0 + M t), by an explicit Runge-Kutta method of order 8."""

    def rate(t, flat):
        R = flat.reshape(3, 3)
        return (hat(R @ (R.T @ (momentum + t * torque) / moments)) @ R).ravel()

    solution = solve_ivp(rate, (0.0, duration), np.eye(3).ravel(), method="DOP853", rtol=1e-13, atol=1e-14)
    return solution.y[:, -1].reshape(3, 3)


def attitude(moments, momentum, torque, duration):
    R, L = np.eye(3), momentum.copy()
    split(R, L, moments, np.eye(3), torque, duration)
    return R, L


@pytest.mark.parametrize("torque", [NO_TORQUE, np.array([0.3, -0.2, 0.1]), np.array([20.0, 5.0, -9.0])])
@pytest.mark.parametrize("moments", [(0.4, 0.7, 1.0), (0.02, 0.99, 1.0), (0.7, 0.7, 1.0), (1.0, 1.0, 1.0)])
def test_attitude_agrees_with_a_runge_kutta_method_of_order_eight(moments, torque):
    moments, momentum = np.array(moments), np.array([0.3, 0.5, -0.4])
    R, L = attitude(moments, momentum, torque, 1.0)
    # DOP853 at its tightest tolerance is right to some 1e-12 over these turns
    np.testing.assert_allclose(R, attitude_by_dop853(moments, momentum, torque, 1.0), atol=1e-11)
    np.testing.assert_allclose(L, momentum + torque, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("spin", [1.0, 1e5])
def test_a_triaxial_top_follows_jacobis_elliptic_functions(spin):
    """Angular velocity in the body frame, Landau and Lifshitz, Mechanics, section 37; by scaling at any spin."""
    A, B, C = 0.4, 0.7, 1.0
    w1, w3 = 0.6 * spin, 0.9 * spin
    energy2, square = A * w1**2 + C * w3**2, (A * w1) ** 2 + (C * w3) ** 2
    assert square > energy2 * B
    rate = np.sqrt((C - B) * (square - energy2 * A) / (A * B * C))
    k2 = (B - A) * (energy2 * C - square) / ((C - B) * (square - energy2 * A))
    duration = 50.0 / spin  # about 50 radians
    sn, cn, dn, _ = ellipj(rate * duration, k2)
    second = np.sqrt((energy2 * C - square) / (B * (C - B)))
    exact = np.array([w1 * cn, second * sn, w3 * dn])
    R, L = attitude(np.array([A, B, C]), np.array([A * w1, 0.0, C * w3]), NO_TORQUE, duration)
    # the tolerance of the splitting, 1e-13 per radian, times |L| / I_min t = 117 radians, and room for a factor of 4
    np.testing.assert_allclose(np.abs(R.T @ L / (A, B, C)), np.abs(exact), atol=5e-11 * spin)


def test_dzhanibekov_first_flip():
    """Starting at a small angle from the middle axis the first flip takes half the period of the elliptic functions."""
    moments = np.array([0.4, 0.7, 1.0])
    momentum = np.array([1e-3 * 0.4, 0.7, 0.0])
    A, B, C = moments
    energy2, square = (momentum**2 / moments).sum(), (momentum**2).sum()
    # the axis that the tip of L goes round: that of the least inertia here, as L^2 < 2 E B
    rate = np.sqrt((B - A) * (energy2 * C - square) / (A * B * C))
    k2 = (C - B) * (square - energy2 * A) / ((B - A) * (energy2 * C - square))
    flip = 2.0 * ellipk(k2) / rate
    R, L = attitude(moments, momentum, NO_TORQUE, flip)
    assert (R.T @ L)[1] == pytest.approx(-0.7, rel=1e-9)  # the flip multiplies errors by about 1e3


def test_a_symmetric_top_is_exact_in_one_step_of_any_length():
    top = free_box(size=(1.0, 1.0, 3.0), angular_velocity=(0.3, 2.0, 5.0))
    inertia = np.diag(top.inertia)
    L, w = inertia * top.angular_velocity, top.angular_velocity
    sim = Simulation(scene_of(top))
    sim.step(1000.0)
    # R = exp(t L / I1) exp(t (1/I3 - 1/I1) l3 e3), by scipy's rotations
    from scipy.spatial.transform import Rotation

    own = Rotation.from_rotvec([0.0, 0.0, 1000.0 * (w[2] - L[2] / inertia[0])])
    x, y, z, s = (Rotation.from_rotvec(1000.0 * L / inertia[0]) * own).as_quat()
    expected = np.array([s, x, y, z])
    expected *= np.sign(expected @ sim.bodies.quaternion[0])
    np.testing.assert_allclose(sim.bodies.quaternion[0], expected, atol=1e-12)  # 5000 rad at 1e-16


def test_energy_and_momentum_over_many_steps():
    """Cut into 20 000 steps of |w| h = 0.06, a triaxial top keeps both (VALIDATION A)."""
    sim = Simulation(scene_of(free_box(angular_velocity=(0.3, 0.8, 0.5))))
    inertia = np.diag(sim.scene.bodies[0].inertia)
    before = inertia * sim.bodies.angular_velocity[0] ** 2
    for _ in range(20_000):
        sim.step(0.06)
    w = sim.bodies.angular_velocity[0]
    q = sim.bodies.quaternion[0]
    from scipy.spatial.transform import Rotation

    R = Rotation.from_quat([*q[1:], q[0]]).as_matrix()
    body = R.T @ w
    assert (inertia * body**2).sum() == pytest.approx(before.sum(), rel=5e-13, abs=0.0)
    start = np.linalg.norm(inertia * np.array([0.3, 0.8, 0.5]))
    assert np.linalg.norm(inertia * body) == pytest.approx(start, rel=5e-13, abs=0.0)


@pytest.mark.parametrize("pieces", [2, 5, 10])
def test_a_step_cut_in_pieces_under_the_same_wrench_ends_the_same(pieces):
    def end(count):
        sim = Simulation(scene_of(free_box(angular_velocity=(1.0, 2.0, 0.3)), gravity=(0.0, 0.0, -9.81)))
        for _ in range(count):
            sim.step(0.1 / count, wrenches=[[1.0, 2.0, 3.0, 0.4, -0.5, 0.6]])
        return np.concatenate([sim.bodies.position, sim.bodies.quaternion, sim.bodies.velocity], axis=1)

    np.testing.assert_allclose(end(pieces), end(1), atol=1e-12)


def test_translation_is_a_parabola_to_rounding():
    sim = Simulation(scene_of(free_box(velocity=(1.0, 0.0, 2.0)), gravity=(0.0, 0.0, -9.81)))
    sim.step(3.0, wrenches=[[4.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    exact = [3.0 + 0.5 * 4.0 / 2.0 * 9.0, 0.0, 6.0 - 0.5 * 9.81 * 9.0]
    np.testing.assert_allclose(sim.bodies.position[0], exact, rtol=1e-15)


def test_rotation_locked_about_two_axes_is_a_closed_form():
    """A body that turns about world z alone: angle w t + M t^2 / (2 I_zz), whatever the other moments do."""
    from comotion_server.scene import Free

    hinged = free_box(motion=Free(locked=(True, True, True, True, True, False)), angular_velocity=(0.0, 0.0, 0.5))
    sim = Simulation(scene_of(hinged, gravity=(0.0, 0.0, -9.81)))
    sim.step(2.0, wrenches=[[7.0, 8.0, 9.0, 3.0, 4.0, 0.1]])
    angle = 0.5 * 2.0 + 0.5 * 0.1 / hinged.inertia[2, 2] * 4.0
    np.testing.assert_allclose(sim.bodies.quaternion[0], [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)], atol=1e-14)
    np.testing.assert_array_equal(sim.bodies.position[0], 0.0)


@pytest.mark.parametrize(
    ("moments", "torque", "kind"),
    [
        ((1.0, 1.0, 1.0), NO_TORQUE, AXIS),
        ((1.0, 1.0, 2.0), NO_TORQUE, SYMMETRIC),
        ((1.0, 2.0, 2.0), NO_TORQUE, SYMMETRIC),
        ((1.0, 1.5, 2.0), NO_TORQUE, SPLIT),
        ((1.0, 1.0, 1.0), np.array([0.0, 1e-9, 0.0]), SPLIT),
    ],
)
def test_the_cheapest_exact_kind_of_flight_is_taken(moments, torque, kind):
    assert kind_of_spin(np.array(moments), np.array([1.0, 2.0, 3.0]), torque) == kind
