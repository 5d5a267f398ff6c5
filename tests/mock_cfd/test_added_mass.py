"""Lagged added mass: the factor of its error per step, and a nodal distribution without moment."""

import numpy as np
import pytest

from comotion_mock_cfd.added_mass import AddedMass, spread_force
from comotion_mock_cfd.bodies import BodyTable
from comotion_mock_cfd.box_form import SIZE
from comotion_mock_cfd.cfd_client import CfdClient
from comotion_mock_cfd.fluid import Fluid, FluidError, FluidScene

GRAVITY, MASS = 9.81, 16.0
DRY = Fluid(level=-100.0)


@pytest.mark.parametrize("added", [4.0, 12.0, 20.0])
@pytest.mark.parametrize("sample", ["end", "midpoint"])
def test_an_error_is_multiplied_by_minus_added_mass_over_mass_per_step(box, one_body, added, sample):
    # m a_k = -m g - m_a a_(k-1): a settles at -m g / (m + m_a), and what is left is multiplied by -m_a / m. For 20 kg
    # on 16 kg it grows, at any step size.
    dt, steps = 0.01, 12
    motion = one_body(box(SIZE), MASS, sample=sample, dt=dt)
    fluid = DRY.model_copy(update={"added_mass": {"box": added}})
    CfdClient(motion, FluidScene(fluid, GRAVITY, dt, steps * dt)).run()
    acceleration = np.diff([state[5] for state in motion.states]) / dt
    error = acceleration + MASS * GRAVITY / (MASS + added)
    assert acceleration[0] == pytest.approx(-GRAVITY, rel=1e-13)
    # Accelerations come from differences of velocities of about 1 m/s over 0.01 s: 1e-14 m/s2, growing as the error.
    assert error[1:] == pytest.approx(-added / MASS * error[:-1], abs=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_the_spread_force_has_the_sum_and_no_moment_and_no_other_is_smaller(icosphere, seed):
    rng = np.random.default_rng(seed)
    arms = icosphere(1)[0] * [1.0, 0.5, 0.1] + rng.normal(size=3)  # the centre of mass is not the vertices' mean
    force = rng.normal(size=3)
    nodal = spread_force(force, arms)
    assert nodal.sum(axis=0) == pytest.approx(force, abs=1e-13)  # 42 vertices of forces of about 1 N
    assert np.cross(arms, nodal).sum(axis=0) == pytest.approx(0.0, abs=1e-12)
    # Least norm: orthogonal to every distribution without force and moment, made by projection from a random one.
    conditions = np.concatenate([np.tile(np.eye(3), len(arms)), np.hstack([skew(arm) for arm in arms])])
    other = rng.normal(size=3 * len(arms))
    other -= np.linalg.pinv(conditions) @ (conditions @ other)
    assert nodal.ravel() @ other == pytest.approx(0.0, abs=1e-11)


def skew(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


def test_a_body_wins_over_its_region_and_others_have_none(box, one_body):
    motion = one_body(box(SIZE), MASS)
    table = BodyTable.of(motion.opened.regions)
    twists = np.zeros((1, 6))
    for mass_of, expected in (({"floating": 3.0}, 3.0), ({"floating": 3.0, "box": 5.0}, 5.0), ({}, 0.0)):
        added = AddedMass(table, mass_of, twists)
        added.observe(np.array([[1.0, 0, 0, 0, 0, 0]]), 0.5)
        forces = {"floating": np.zeros((8, 3))}
        added.add_to(forces, motion.opened.vertices, np.zeros((1, 3)))
        assert forces["floating"].sum(axis=0) == pytest.approx([-2.0 * expected, 0, 0], abs=1e-14)


def test_an_unknown_name_is_refused_with_those_there_are(box, one_body):
    table = BodyTable.of(one_body(box(SIZE), MASS).opened.regions)
    with pytest.raises(FluidError, match=r"fluid.added_mass: 'flow' is neither .* \['box', 'floating'\]"):
        AddedMass(table, {"flow": 1.0}, np.zeros((1, 6)))
