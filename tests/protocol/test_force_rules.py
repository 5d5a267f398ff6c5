"""Forces: section F of the SPEC, over memory and over zenoh. Each refusal names what was expected and what came."""

import numpy as np
import pytest
from protocol_peers import Peers, ask, error_of
from trivial_engine import TETRAHEDRON, TrivialEngine

from comotion_protocol import LocalProtocolError, Sums, Wants

DT = 0.5
ICE = np.array([3.0, 4.0, 5.0])  # where the body of the second region starts


@pytest.fixture
def motion(peers):
    with peers.open(wants=Wants(poses=True)) as motion:
        yield motion
        assert motion.step(DT, {"ice": np.ones((4, 3))}).step >= 1  # the next good message works


def refusal(call, *arguments, **named):
    with pytest.raises(LocalProtocolError) as error:
        call(*arguments, **named)
    return error.value.code, error.value.rule, error.value.message


@pytest.mark.rule("F1")
@pytest.mark.parametrize("name", ["ice/heat", "forces", "/forces", "poses", "wrenches "])
def test_other_blocks_are_refused(motion, peers, name):
    block = {"name": name, "dtype": "<f8", "shape": [1, 3]}
    header = {"lease": motion.opened.lease, "step": 1, "attempt": 0, "dt": DT, "blocks": [block]}
    error = error_of(ask(peers.link(), "step", header, [np.zeros(3)]))
    assert (error.code, error.rule) == ("unknown_block", "F1")
    assert repr(name) in error.message


@pytest.mark.rule("F1")
def test_integers_are_no_forces(motion, peers):
    block = {"name": "ice/forces", "dtype": "<u4", "shape": [4, 3]}
    header = {"lease": motion.opened.lease, "step": 1, "attempt": 0, "dt": DT, "blocks": [block]}
    error = error_of(ask(peers.link(), "step", header, [np.zeros((4, 3), "<u4")]))
    assert (error.code, error.rule) == ("unknown_block", "F1")


@pytest.mark.rule("F2")
def test_unknown_region(motion):
    code, rule, message = refusal(motion.step, DT, {"water": np.ones((4, 3))})
    assert (code, rule) == ("unknown_region", "F2")
    assert message == "forces: expected a region of 'hull', 'ice', 'wall', got 'water'"


@pytest.mark.rule("F2")
def test_regions_left_out_have_no_forces(motion):
    assert motion.step(DT, {"hull": np.ones((4, 3))}).poses[1, :3].tolist() == [3.0, 4.0, 5.0]
    assert motion.step(DT).sums.force == (0.0, 0.0, 0.0)


@pytest.mark.rule("F3")
@pytest.mark.parametrize("shape", [(3, 3), (5, 3), (4, 2), (0, 3), (12, 1)])
def test_wrong_length(motion, shape):
    code, rule, message = refusal(motion.step, DT, {"ice": np.ones(shape)})
    assert (code, rule) == ("wrong_shape", "F3")
    assert message == f"forces of region 'ice': expected shape (4, 3), got {shape}"


@pytest.mark.rule("F4")
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite(motion, bad):
    forces = np.ones((4, 3))
    forces[2, 1] = bad
    code, rule, message = refusal(motion.step, DT, {"ice": forces})
    assert (code, rule) == ("not_finite", "F4")
    assert message == f"forces of region 'ice': expected finite numbers, got {bad} in row 2, column 1"
    wrenches = np.zeros((3, 6))
    wrenches[1, 5] = bad
    code, rule, message = refusal(motion.step, DT, wrenches=wrenches)
    assert (code, rule) == ("not_finite", "F4")
    assert "wrenches" in message


@pytest.mark.rule("F5")
def test_wrenches(motion):
    code, rule, message = refusal(motion.step, DT, wrenches=np.zeros((2, 6)))
    assert (code, rule, message) == ("wrong_shape", "F5", "wrenches: expected shape (3, 6), got (2, 6)")
    code, rule, _ = refusal(motion.step, DT, {"ice": np.zeros((4, 3))}, wrenches=np.zeros((3, 6)))
    assert (code, rule) == ("unknown_block", "F5")
    wrenches = np.zeros((3, 6))
    wrenches[0, :3] = [1.0, 2.0, 4.0]
    assert motion.step(DT, wrenches=wrenches).poses[0, :3].tolist() == [0.25, 1.5, 3.0]


@pytest.mark.rule("F6")
@pytest.mark.parametrize("dt", [0.0, -0.0, -1.0, np.nan, np.inf, -np.inf])
def test_dt(motion, dt):
    for named in ({}, {"dt_next": dt}):
        code, rule, message = refusal(motion.step, DT if named else dt, **named)
        assert (code, rule) == ("bad_dt", "F6")
        assert message == f"{'dt_next' if named else 'dt'}: expected a positive finite number of seconds, got {dt}"


@pytest.mark.rule("F6", "M6")
@pytest.mark.parametrize("dt", [0.0, -1.0, np.nan, np.inf])
def test_dt_of_the_first_step(peers, dt):
    with pytest.raises(LocalProtocolError, match="dt: expected a positive"):
        peers.open(wants=Wants(sample="midpoint"), dt=dt)
    peers.open(wants=Wants(sample="midpoint"), dt=DT).close()


@pytest.mark.rule("F7")
def test_sums(motion):
    forces = {"ice": np.array([[1e6, 0.0, 0.0], [-1e6, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]])}
    arms = TETRAHEDRON + ICE
    force, moment = forces["ice"].sum(axis=0), np.cross(arms, forces["ice"]).sum(axis=0)
    # The scale is the sum of magnitudes, 2e6 N: 1e-9 of it is 2e-3 N.
    x, y, _ = np.eye(3)
    for wrong, named in (((force + 3e-3 * x, moment), "sums.force"), ((force, moment + 0.1 * y), "sums.moment")):
        sums = Sums(force=tuple(wrong[0].tolist()), moment=tuple(wrong[1].tolist()))
        code, rule, message = refusal(motion.step, DT, forces, sums=sums)
        assert (code, rule) == ("sums_mismatch", "F7")
        assert named in message
    right = Sums(force=tuple((force + 1e-3 * x).tolist()), moment=tuple(moment.tolist()))
    reply = motion.step(DT, forces, sums=right)
    assert reply.step == 1
    assert reply.sums == Sums(force=tuple(force.tolist()), moment=tuple(moment.tolist()))


@pytest.mark.rule("F7")
def test_sums_of_wrenches(motion):
    wrenches = np.arange(18.0).reshape(3, 6)
    centres = motion.opened.poses[:, :3]
    moment = (wrenches[:, 3:] + np.cross(centres, wrenches[:, :3])).sum(axis=0)
    force = wrenches[:, :3].sum(axis=0)
    wrong = Sums(force=tuple(force.tolist()), moment=tuple((2 * moment).tolist()))
    assert refusal(motion.step, DT, wrenches=wrenches, sums=wrong)[0] == "sums_mismatch"
    sums = Sums(force=tuple(force.tolist()), moment=tuple(moment.tolist()))
    assert motion.step(DT, wrenches=wrenches, sums=sums).step == 1


@pytest.mark.rule("F8")
def test_numbers_the_simulation_cannot_take(motion, peers):
    before = peers.engine.position.tobytes()
    peers.engine.fail = ValueError("the motion leaves the range of numbers")
    assert refusal(motion.step, DT) == ("bad_step", "F8", "the motion leaves the range of numbers")
    assert peers.engine.position.tobytes() == before


@pytest.mark.rule("F9")
@pytest.mark.parametrize("kind", ["memory", "zenoh"])
@pytest.mark.parametrize("vertices", [True, False])
def test_forces_act_where_the_last_sample_was(kind, vertices):
    """Moments of unit forces about the origin tell the vertices at which they were taken to act."""
    engine = TrivialEngine()
    engine.velocity[1] = [2.0, 0.0, 0.0]
    wants = Wants(sample="midpoint", vertices=vertices)
    with Peers(kind, engine) as peers, peers.open(wants=wants, dt=1.0) as motion:
        lift = {"ice": np.array([[0.0, 0.0, 1e-9], [0, 0, 0], [0, 0, 0], [0, 0, 0]])}

        def arm(reply):
            return -reply.sums.moment[1] / 1e-9

        assert arm(motion.step(1.0, lift)) == pytest.approx(3.0 + 2.0 * 0.5)  # rounding of one product
        second = motion.step(1.0, lift, dt_next=4.0)
        assert arm(second) == pytest.approx(3.0 + 2.0 * 1.5)
        assert arm(motion.redo(1.0, lift, dt_next=0.5)) == pytest.approx(3.0 + 2.0 * 1.5)
        assert arm(motion.step(1.0, lift)) == pytest.approx(3.0 + 2.0 * 2.25)
