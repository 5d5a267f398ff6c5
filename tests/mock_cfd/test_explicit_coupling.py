"""The whole client against a body with an exact flight: what explicit coupling does to heave, drag and fall."""

import numpy as np
import pytest
from scipy.special import lambertw

from comotion_mock_cfd.box_form import SIZE
from comotion_mock_cfd.cfd_client import CfdClient
from comotion_mock_cfd.fluid import Drag, Fluid, FluidScene, Heave
from comotion_mock_cfd.heave import HeaveRecord, heave_period

GRAVITY, WATER, DRAUGHT = 9.81, 1000.0, 0.1
AREA = SIZE[0] * SIZE[1]
MASS = WATER * AREA * DRAUGHT
OMEGA = np.sqrt(GRAVITY / DRAUGHT)


def play(motion, fluid, dt, duration, callback=None):
    CfdClient(motion, FluidScene(fluid, GRAVITY, dt, duration)).run(callback)
    return np.array(motion.states)


def heave_map(states):
    """The matrix that takes (z, w) to the next step's, from three states in a row."""
    z = states[:, [2, 5]]
    return np.linalg.solve(z[0:2], z[1:3]).T


@pytest.mark.parametrize("dt", [0.005, 0.02, 0.1])
@pytest.mark.parametrize("sample", ["end", "midpoint"])
def test_a_step_of_heave_is_the_linear_map_of_theory(box, one_body, sample, dt):
    motion = one_body(box(SIZE), MASS, position=(0, 0, 0.02), velocity=(0, 0, 0.01), sample=sample, dt=dt)
    states = play(motion, Fluid(), dt, 3 * dt)
    w2 = OMEGA**2
    if sample == "end":  # force -w2 z of the beginning, held
        expected = np.array([[1 - w2 * dt**2 / 2, dt], [-w2 * dt, 1]])
        pumping = 1 + w2 * dt**2 / 2
    else:  # force of the middle that the drift alone predicts, z + w dt / 2
        expected = np.array([[1 - w2 * dt**2 / 2, dt - w2 * dt**3 / 4], [-w2 * dt, 1 - w2 * dt**2 / 2]])
        pumping = 1.0
    # Two states a step apart turn by 1/20 rad at least: solving for the map costs two to three digits of 1e-15.
    assert heave_map(states) == pytest.approx(expected, rel=1e-10, abs=1e-12)
    # A complex pair of factors: the square of their magnitude is the determinant.
    assert np.linalg.det(heave_map(states)) == pytest.approx(pumping, rel=1e-10)


def test_held_forces_pump_energy_and_the_midpoint_sample_does_not(box, one_body):
    dt, steps, start = 0.02, 1000, 1e-6
    energy = {}
    for sample in ("end", "midpoint"):
        motion = one_body(box(SIZE), MASS, position=(0, 0, start), sample=sample, dt=dt)
        states = play(motion, Fluid(), dt, steps * dt)
        energy[sample] = ((OMEGA * states[:, 2]) ** 2 + states[:, 5] ** 2) / (OMEGA * start) ** 2
    # |lambda|^2 per step; a millionth of a metre grows to 16 mm, still wall-sided. Energy as formed here also swings
    # within a period, by w dt / 2 = 10 % at most, which is spread over the steps.
    growth = np.log(energy["end"][-1]) / steps
    assert growth == pytest.approx(np.log1p((OMEGA * dt) ** 2 / 2), abs=0.1 / steps)
    # The midpoint's swings by (w dt / 2)^2 = 1 % above its least, for ever.
    assert energy["midpoint"].max() <= 1.0 + 1.01 * (OMEGA * dt / 2) ** 2
    assert energy["midpoint"].min() >= 1.0 - 1e-9  # rounding of 1e-6 m beside 0.1 m, over 1000 steps


def test_the_heave_period_is_that_of_theory_to_the_order_of_the_scheme(box, one_body):
    for dt in (0.01, 0.005):
        fluid = Fluid(heave=Heave(body="box", draught=DRAUGHT))
        scene = FluidScene(fluid, GRAVITY, dt, 6.0)
        client = CfdClient(one_body(box(SIZE), MASS, position=(0, 0, 0.02), dt=dt), scene)
        record = HeaveRecord(scene, client.bodies)
        client.run(record.add)
        period = record.period()
        assert period.cycles == 8
        assert period.theory == heave_period(GRAVITY, DRAUGHT) == pytest.approx(2 * np.pi / OMEGA, rel=1e-15)
        # The midpoint scheme has cos(w' dt) = 1 - w^2 dt^2 / 2 exactly.
        exact = OMEGA * dt / np.arccos(1 - (OMEGA * dt) ** 2 / 2) - 1
        # The speed is sampled from a sine and taken as linear between: the first and the last zero are each off by a
        # fraction of (w dt)^3 periods, spread over the cycles.
        assert period.error == pytest.approx(exact, abs=(OMEGA * dt) ** 3 / 50 / period.cycles)


def test_drag_slows_a_body_down_as_the_closed_form_says(box, one_body):
    # m v' = -c v^2: v = v0 / (1 + c v0 t / m). The forces are held: first order, halving dt halves the error.
    form, speed, duration = 0.8, 2.0, 1.0
    rate = 0.5 * WATER * form * SIZE[1] * SIZE[2] / (WATER * AREA * SIZE[2])
    exact = speed / (1 + rate * speed * duration)
    errors = []
    for dt in (0.01, 0.005, 0.0025):
        motion = one_body(box(SIZE), WATER * AREA * SIZE[2], position=(0, 0, -5), velocity=(speed, 0, 0), dt=dt)
        states = play(motion, Fluid(drag=Drag(form=form)), dt, duration)
        errors.append(states[-1, 3] - exact)
        # Neutrally buoyant: depth is kept to the rounding of pressures 5 m down, 1e-15 of 5e4 N over 1 s on 32 kg.
        assert np.abs(states[:, 2] + 5).max() < 1e-10
    assert np.array(errors[:-1]) / errors[1:] == pytest.approx([2, 2], rel=0.02)
    assert 2 * errors[2] - errors[1] == pytest.approx(0.0, abs=1e-5)  # Richardson: second order left, (dt rate v)^2


def test_terminal_velocity_is_reached_along_the_tanh_law(box, one_body):
    # m v' = (m - rho V) g - c v^2 from rest: v = v_t tanh(t / tau), v_t = sqrt(W / c), tau = m / sqrt(W c).
    form, mass = 1.2, 80.0
    weight = (mass - WATER * AREA * SIZE[2]) * GRAVITY
    resistance = 0.5 * WATER * form * AREA
    terminal, time_scale = np.sqrt(weight / resistance), mass / np.sqrt(weight * resistance)
    errors = []
    for dt in (time_scale / 100, time_scale / 200):
        motion = one_body(box(SIZE), mass, position=(0, 0, -10), dt=dt)
        states = play(motion, Fluid(drag=Drag(form=form)), dt, 3 * time_scale)
        times = dt * np.arange(len(states))
        errors.append(states[:, 5] + terminal * np.tanh(times / time_scale))
    assert 0 < np.abs(errors[1]).max() < 2e-3 * terminal
    # First order: the error halves with dt. Where it is largest it is 1e-3, its own second order 1e-2 of that.
    coarse, fine = np.abs(errors[0]).max(), np.abs(errors[1]).max()
    assert coarse / fine == pytest.approx(2.0, rel=0.02)


def test_falling_at_terminal_velocity_is_steady(box, one_body):
    form, mass = 1.2, 80.0
    terminal = np.sqrt((mass - WATER * AREA * SIZE[2]) * GRAVITY / (0.5 * WATER * form * AREA))
    motion = one_body(box(SIZE), mass, position=(0, 0, -10), velocity=(0, 0, -terminal), dt=0.01)
    states = play(motion, Fluid(drag=Drag(form=form)), 0.01, 1.0)
    # The fixed point is stable, so that what is left is the rounding of pressures 10 m down.
    assert states[:, 5] == pytest.approx(-terminal, rel=1e-11)


def test_heave_with_quadratic_drag_decays_by_lambert_w(box, one_body):
    # Drag acts on the way down only, where the bottom moves into the water: z'' = -w^2 z + k z'^2. From rest at +a the
    # box goes to -b with (1 - 2 k b) e^(2 k b) = (1 + 2 k a) e^(-2 k a), and comes up to +b without loss.
    form, start, dt = 2.0, 0.05, 0.0025
    k = 0.5 * WATER * form * AREA / MASS
    heights = [start]
    for _ in range(4):
        q = 1 + 2 * k * heights[-1]
        heights.append((1 + lambertw(-q * np.exp(-q)).real) / (2 * k))
    motion = one_body(box(SIZE), MASS, position=(0, 0, start), dt=dt)
    states = play(motion, Fluid(drag=Drag(form=form)), dt, 4.5 * 2 * np.pi / OMEGA)
    z, w = states[:, 2], states[:, 5]
    tops = np.flatnonzero((w[:-1] > 0) & (w[1:] <= 0))
    # The height at the top, under the force held over its step: z + w^2 / (2 |a|).
    deceleration = (w[tops] - w[tops + 1]) / dt
    measured = z[tops] + w[tops] ** 2 / (2 * deceleration)
    # The drag is of the step's beginning: first order, k a w dt = 1.2 % of a loss of a half in the first swing.
    assert measured == pytest.approx(heights[1:], rel=0.02)
