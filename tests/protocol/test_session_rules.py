"""Leases and steps: sections L and S of the SPEC, over memory and over zenoh."""

import numpy as np
import pytest
from protocol_peers import PATIENCE, Peers, ask, error_of, send
from trivial_engine import TrivialEngine

from comotion_protocol import LocalProtocolError, MotionClient, Wants, codec, limits
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.messages import CloseRequest, StepRequest
from comotion_protocol.session import TABLE, Refuse

DT = 0.5
PUSH = {"ice": np.ones((4, 3))}


def open_header(link, **more):
    return {"protocol": [1, 0], "client": {"name": "c", "version": "1", "id": link.client_id}} | more


def open_by(link, **more):
    accepted, header, bulk = ask(link, "open", open_header(link, **more))
    assert accepted, codec.decode_error(header)
    return codec.decode_open_reply(header, bulk)


def step(lease, number, attempt=0, forces=None, dt=DT):
    return StepRequest(lease=lease, step=number, attempt=attempt, dt=dt, forces=PUSH if forces is None else forces)


@pytest.fixture
def lease(link):
    return open_by(link).lease


def refused(answer, code, rule):
    error = error_of(answer)
    assert (error.code, error.rule) == (code, rule)
    return error


def state(engine):
    return engine.time, engine.position.tobytes(), engine.velocity.tobytes()


# The table -----------------------------------------------------------------------------------------------------------


def test_every_refusal_of_the_table_names_a_known_code():
    from comotion_protocol.errors import CODES

    assert {entry.code for entry in TABLE.values() if isinstance(entry, Refuse)} <= set(CODES)


# L: the lease --------------------------------------------------------------------------------------------------------


@pytest.mark.rule("L1")
def test_one_lease_at_a_time(peers, link, lease):
    error = refused(ask(peers.link(), "open", open_header(link)), "lease_held", "L1")
    assert error.detail["holder"] == "c"
    assert send(link, step(lease, 1))[0]


@pytest.mark.rule("L1", "S8")
def test_an_open_during_a_step_is_refused_at_once(peers, link, lease):
    peers.engine.hold.clear()
    finish = peers.in_background(send, link, step(lease, 1))
    assert peers.engine.entered.wait(PATIENCE)
    other = peers.link()
    refused(ask(other, "open", open_header(other)), "lease_held", "L1")
    assert not peers.engine.hold.is_set()  # the answer came while the step lasted
    peers.engine.hold.set()
    assert finish()[0]


@pytest.mark.rule("L2")
def test_a_lease_that_is_not_held_is_refused(peers, link):
    refused(send(link, step("nobody's", 1)), "wrong_lease", "L2")
    refused(send(link, CloseRequest(lease="nobody's", step=0), "close"), "wrong_lease", "L2")
    lease = open_by(link).lease
    before = state(peers.engine)
    refused(send(link, step(lease[:-1] + "x", 1)), "wrong_lease", "L2")
    refused(send(link, CloseRequest(lease="é" + lease, step=0), "close"), "wrong_lease", "L2")
    assert state(peers.engine) == before
    assert send(link, step(lease, 1))[0]


@pytest.mark.rule("L3")
def test_leases_are_random_and_secret(link):
    leases = set()
    for _ in range(5):
        opened = open_by(link)
        assert len(bytes.fromhex(opened.lease)) * 8 >= 128
        leases.add(opened.lease)
        _, status, _ = ask(link, "status", {})
        assert opened.lease.encode() not in status
        assert send(link, CloseRequest(lease=opened.lease, step=0), "close")[0]
    assert len(leases) == 5


@pytest.mark.rule("L4")
def test_the_lease_falls_free_with_the_token(peers):
    dying = peers.link()
    open_by(dying)
    assert peers.service.status().phase == "idle"
    dying.close()
    wait_until_free(peers)
    assert open_by(peers.link()).step == 1


@pytest.mark.rule("L4", "S7")
def test_a_step_in_progress_is_kept_when_its_client_dies(peers):
    dying = peers.link()
    lease = open_by(dying).lease
    assert send(dying, step(lease, 1))[0]
    peers.engine.hold.clear()
    peers.engine.entered.clear()
    peers.in_background(send, dying, step(lease, 2))
    assert peers.engine.entered.wait(PATIENCE)
    dying.close()
    wait_until_free(peers)
    link = peers.link()
    waiting = peers.in_background(open_by, link)  # the lease is free, and the worker is not
    peers.engine.hold.set()
    opened = waiting()
    assert opened.step == 3
    assert opened.time == 2 * DT
    refused(send(link, step(opened.lease, 2, attempt=1)), "wrong_step", "S6")
    assert send(link, step(opened.lease, 3))[0]


def wait_until_free(peers):
    """The token's end is heard by another thread of the link: ask until it was."""
    link = peers.link()
    for _ in range(10_000):
        _, header, bulk = ask(link, "status", {})
        if codec.decode_status_reply(header, bulk).client is None:
            return
    raise AssertionError("the lease never fell free")


@pytest.mark.rule("L5")
@pytest.mark.parametrize("kind", ["memory", "zenoh"])
def test_a_silent_holder_without_a_token_loses_the_lease_to_who_asks(kind):
    with Peers(kind, idle_time=60.0) as peers:
        link, other = peers.link(), peers.link()
        header = {"protocol": [1, 0], "client": {"name": "tokenless", "version": "1"}}
        accepted, reply, bulk = ask(link, "open", header)
        assert accepted
        opened = codec.decode_open_reply(reply, bulk)
        assert opened.limits.idle_time == 60.0
        peers.clock.now += 59.0
        assert send(link, step(opened.lease, 1))[0]
        peers.clock.now += 59.0
        refused(ask(other, "open", open_header(other)), "lease_held", "L1")
        peers.clock.now += 2.0
        assert open_by(other).step == 2
        refused(send(link, step(opened.lease, 2)), "wrong_lease", "L2")


@pytest.mark.rule("L5")
def test_a_long_step_is_no_silence():
    with Peers("memory", idle_time=60.0) as peers:
        link, other = peers.link(), peers.link()
        _, reply, bulk = ask(link, "open", {"protocol": [1, 0], "client": {"name": "tokenless", "version": "1"}})
        lease = codec.decode_open_reply(reply, bulk).lease
        peers.engine.hold.clear()
        finish = peers.in_background(send, link, step(lease, 1))
        assert peers.engine.entered.wait(PATIENCE)
        peers.clock.now += 3600.0
        refused(ask(other, "open", open_header(other)), "lease_held", "L1")
        peers.engine.hold.set()
        assert finish()[0]
        assert send(link, step(lease, 2))[0]


@pytest.mark.rule("L6", "S6")
def test_close_gives_the_lease_back(link, lease):
    assert send(link, step(lease, 1))[0]
    refused(send(link, CloseRequest(lease=lease, step=0), "close"), "wrong_step", "S6")
    accepted, header, bulk = send(link, CloseRequest(lease=lease, step=1), "close")
    assert accepted
    closed = codec.decode_close_reply(header, bulk)
    assert (closed.steps, closed.time) == (1, DT)
    refused(send(link, step(lease, 2)), "wrong_lease", "L2")
    assert open_by(link).step == 2


# S: steps ------------------------------------------------------------------------------------------------------------


@pytest.mark.rule("S1", "S6")
def test_steps_follow_each_other(peers, link, lease):
    refused(send(link, step(lease, 2)), "wrong_step", "S6")
    assert send(link, step(lease, 1))[0]
    assert send(link, step(lease, 2, attempt=7))[0]
    refused(send(link, step(lease, 4)), "wrong_step", "S6")
    refused(send(link, step(lease, 1)), "wrong_step", "S6")
    assert peers.engine.steps_taken == 2


@pytest.mark.rule("S2")
def test_a_higher_attempt_starts_from_the_beginning_of_the_step(peers, link, lease):
    assert send(link, step(lease, 1))[0]
    assert send(link, step(lease, 2))[0]
    again = {"hull": np.full((4, 3), 2.0)}
    accepted, header, bulk = send(link, step(lease, 2, attempt=1, forces=again, dt=0.25))
    assert accepted
    reply = codec.decode_step_reply(header, bulk)
    straight = TrivialEngine()
    straight.step(DT, PUSH)
    straight.step(0.25, again)
    assert state(peers.engine) == state(straight)
    assert (reply.step, reply.attempt, reply.time) == (2, 1, 0.75)
    assert reply.vertices["hull"].tolist() == straight.sample(0.0).vertices["hull"].tolist()
    assert send(link, step(lease, 3))[0]  # and makes it final
    refused(send(link, step(lease, 2, attempt=2)), "wrong_step", "S6")


@pytest.mark.rule("S3")
def test_an_identical_repeat_is_answered_from_memory(peers, link, lease):
    first = send(link, step(lease, 1))
    assert first[0]
    assert send(link, step(lease, 1)) == first
    redone = send(link, step(lease, 1, attempt=1))
    assert send(link, step(lease, 1, attempt=1)) == redone
    assert peers.engine.steps_taken == 2


@pytest.mark.rule("S3")
def test_a_repeat_that_waits_for_its_step_has_no_second_effect(peers, link, lease):
    peers.engine.hold.clear()
    first = peers.in_background(send, link, step(lease, 1))
    assert peers.engine.entered.wait(PATIENCE)
    second = peers.in_background(send, link, step(lease, 1))
    peers.engine.hold.set()
    assert first() == second()
    assert peers.engine.steps_taken == 1


@pytest.mark.rule("S4")
def test_other_bytes_are_a_conflict(link, lease):
    first = send(link, step(lease, 1))
    refused(send(link, step(lease, 1, dt=0.25)), "conflict", "S4")
    refused(send(link, step(lease, 1, forces={"ice": -np.ones((4, 3))})), "conflict", "S4")
    assert send(link, step(lease, 1)) == first


@pytest.mark.rule("S5")
def test_a_lower_attempt_is_refused(link, lease):
    assert send(link, step(lease, 1, attempt=5))[0]
    refused(send(link, step(lease, 1, attempt=4)), "attempt_passed", "S5")


@pytest.mark.rule("S7")
def test_an_open_makes_the_step_before_final(peers):
    with peers.open() as first:
        first.step(DT, PUSH)
        first.redo(DT, PUSH)
    with peers.open() as second:
        assert second.opened.step == 2
        with pytest.raises(LocalProtocolError) as refusal:
            second.redo(DT, PUSH)
        assert refusal.value.code == "wrong_step"
        assert second.step(DT, PUSH).step == 2


@pytest.mark.rule("S8")
def test_status_is_answered_during_a_step(peers, link, lease):
    peers.engine.hold.clear()
    finish = peers.in_background(send, link, step(lease, 1))
    assert peers.engine.entered.wait(PATIENCE)
    peers.clock.now += 30.0
    accepted, header, bulk = ask(peers.link(), "status", {})
    assert accepted
    status = codec.decode_status_reply(header, bulk)
    assert (status.phase, status.phase_seconds, status.step, status.busy) == ("computing", 30.0, 0, 30.0)
    assert status.client is not None
    assert status.client.name == "c"
    peers.engine.hold.set()
    assert finish()[0]


@pytest.mark.rule("S8")
def test_requests_are_done_in_the_order_they_came(peers, link, lease):
    peers.engine.hold.clear()
    waiting = [peers.in_background(send, link, step(lease, 1))]
    assert peers.engine.entered.wait(PATIENCE)
    for number in (2, 3):
        queued = peers.desk.waiting
        waiting.append(peers.in_background(send, link, step(lease, number)))
        while peers.desk.waiting == queued:  # until it is queued behind the one before
            ask(link, "status", {})
    peers.engine.hold.set()
    assert [codec.decode_step_reply(*finish()[1:]).step for finish in waiting] == [1, 2, 3]


@pytest.mark.rule("S9")
def test_too_many_waiting_requests_are_refused(peers, link, lease):
    peers.engine.hold.clear()
    first = peers.in_background(send, link, step(lease, 1))
    assert peers.engine.entered.wait(PATIENCE)
    repeats = [peers.in_background(send, link, step(lease, 1)) for _ in range(limits.WAITING)]
    while peers.desk.waiting < limits.WAITING:
        ask(link, "status", {})
    error = error_of(send(link, step(lease, 1)))
    assert (error.code, error.rule, type(error)) == ("busy", "S9", RemoteProtocolError)
    peers.engine.hold.set()
    answer = first()
    assert answer[0]
    assert all(repeat() == answer for repeat in repeats)


def test_the_client_counts_for_its_caller(peers):
    with peers.open(wants=Wants(poses=True)) as motion:
        assert isinstance(motion, MotionClient)
        assert [motion.step(DT).step for _ in range(3)] == [1, 2, 3]
        assert [motion.redo(DT).attempt for _ in range(2)] == [1, 2]
        assert motion.step(DT).attempt == 0
