"""The client's loop: step sizes, what it sends, what it tells, what it needs."""

from types import SimpleNamespace

import numpy as np
import pytest

from comotion_mock_cfd import cfd_client
from comotion_mock_cfd.box_form import SIZE
from comotion_mock_cfd.cfd_client import CfdClient, wants
from comotion_mock_cfd.fluid import Fluid, FluidError, FluidScene, Heave
from comotion_mock_cfd.heave import HeaveRecord, mean_period

GRAVITY, MASS = 9.81, 16.0


def scene(dt=0.01, duration=0.1, fluid=None):
    return FluidScene(fluid or Fluid(), GRAVITY, dt, duration)


@pytest.mark.parametrize(
    ("dt", "duration", "sizes"),
    [
        (0.1, 0.3, [0.1, 0.1, 0.1]),  # 0.3 / 0.1 is below 3 in doubles
        (0.1, 0.35, [0.1, 0.1, 0.1, 0.05]),
        (0.1, 0.05, [0.05]),
        (0.1, 0.1, [0.1]),
    ],
)
def test_steps_end_at_the_duration_and_the_next_size_is_announced(box, one_body, dt, duration, sizes):
    motion = one_body(box(SIZE), MASS)
    CfdClient(motion, scene(dt, duration)).run()
    assert [step[0] for step in motion.steps] == pytest.approx(sizes, rel=1e-12)
    assert motion.time == pytest.approx(duration, rel=1e-15)
    assert [step[1] for step in motion.steps[:-1]] == pytest.approx(sizes[1:], rel=1e-12)


def test_a_long_run_has_no_sliver_at_its_end(box, one_body):
    motion = one_body(box(SIZE), MASS)
    CfdClient(motion, scene(0.005, 6.0)).run()
    assert len(motion.steps) == 1200


def test_a_run_that_was_begun_before_is_played_to_its_end(box, one_body):
    motion = one_body(box(SIZE), MASS)
    motion.time = motion.opened.time = 0.06
    CfdClient(motion, scene(0.01, 0.1)).run()
    assert len(motion.steps) == 4


def test_every_step_is_told_with_its_wrenches(box, one_body):
    motion = one_body(box(SIZE), MASS, position=(3.0, 0.0, 0.0))
    records = []
    CfdClient(motion, scene()).run(records.append)
    assert [record.step for record in records] == list(range(1, 11))
    assert records[-1].time == pytest.approx(0.1, rel=1e-14)
    # At rest half under water: the lift acts through the centre of mass, wherever in the world that is.
    weight = MASS * GRAVITY
    expected = pytest.approx(np.array([[0, 0, weight, 0, 0, 0]]), abs=1e-12 * weight)
    assert all(record.wrenches == expected for record in records)


def test_a_callback_that_raises_ends_the_run(box, one_body):
    motion = one_body(box(SIZE), MASS)

    def stop(record):
        if record.step == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        CfdClient(motion, scene()).run(stop)
    assert len(motion.steps) == 3


def test_vacuum_sends_zeros(box, one_body):
    motion = one_body(box(SIZE), MASS)
    CfdClient(motion, FluidScene(None, GRAVITY, 0.01, 0.05)).run()
    assert motion.states[-1][5] == pytest.approx(-GRAVITY * 0.05, rel=1e-14)


def test_surfaces_that_a_reply_leaves_out_are_not_computed_again(box, one_body, monkeypatch):
    motion = one_body(box(SIZE), MASS, position=(0.0, 0.0, -0.05))
    calls, compute, step = [], cfd_client.fluid_forces, motion.step

    def counted(*arguments):
        calls.append(arguments)
        return compute(*arguments)

    def still(dt, forces, *, dt_next):
        reply = step(dt, forces, dt_next=dt_next)
        return SimpleNamespace(**{**vars(reply), "vertices": {}})

    monkeypatch.setattr(cfd_client, "fluid_forces", counted)
    monkeypatch.setattr(motion, "step", still)
    CfdClient(motion, scene()).run()
    assert len(calls) == 1
    # The same force in every step: 3/4 of the box under water.
    assert motion.states[-1][5] == pytest.approx(0.1 * GRAVITY * (0.15 / 0.1 - 1), rel=1e-12)


@pytest.mark.parametrize(("lacking", "value"), [("poses", None), ("twists", None), ("velocities", {})])
def test_a_session_without_what_is_needed_is_refused(box, one_body, lacking, value):
    motion = one_body(box(SIZE), MASS)
    setattr(motion.opened, lacking, value)
    with pytest.raises(FluidError, match=r"poses, twists and velocities are needed: .*wants\(\)"):
        CfdClient(motion, scene())


def test_what_is_asked_for():
    asked = wants()
    assert asked.sample == "midpoint"
    assert (asked.vertices, asked.velocities, asked.poses, asked.twists) == (True,) * 4
    assert wants("end").sample == "end"


def test_heave_needs_a_body_of_the_run(box, one_body):
    bodies = CfdClient(one_body(box(SIZE), MASS), scene()).bodies
    with pytest.raises(FluidError, match="names no body"):
        HeaveRecord(scene(), bodies)
    with pytest.raises(FluidError, match=r"fluid.heave.body: there is no body 'ship'; there are \['box'\]"):
        HeaveRecord(scene(fluid=Fluid(heave=Heave(body="ship", draught=0.1))), bodies)


def test_a_record_shorter_than_a_cycle_has_no_period(box, one_body):
    short = scene(fluid=Fluid(heave=Heave(body="box", draught=0.1)))
    client = CfdClient(one_body(box(SIZE), MASS, position=(0, 0, 0.01)), short)
    record = HeaveRecord(short, client.bodies)
    client.run(record.add)
    assert len(record.times) == 10
    assert record.period() is None


def test_the_mean_period_of_a_damped_oscillation():
    times = np.arange(0.0, 10.0, 0.001)
    period, cycles = mean_period(times, -np.exp(-0.3 * times) * np.sin(2 * np.pi * times / 0.7 + 0.4))
    assert cycles == 13
    assert period == pytest.approx(0.7, rel=1e-7)  # chords of a sine sampled 700 times a period: (0.009)^3 / 13
