"""Section W of the protocol: who watches sees everything and changes nothing."""

import time
from contextlib import ExitStack

import numpy as np
import pytest
from protocol_peers import PATIENCE, RUN, Peers, ask
from trivial_engine import TETRAHEDRON

from comotion_protocol import codec, keys
from comotion_protocol import messages as m
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.watch_client import WatchClient

DT = 0.5


class Listeners:
    """An audience that listens to what it is told to, and keeps what it hears."""

    def __init__(self, *news):
        self.listening = set(news)
        self.heard = []

    def listens(self, news):
        return news in self.listening

    def publish(self, news, frame):
        self.heard.append((news, codec.decode_news(news, frame.header, frame.bulk())))

    def of(self, kind):
        return [told for news, told in self.heard if news == kind]


def wait_until(true):
    deadline = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.005)


@pytest.fixture
def memory():
    with Peers("memory") as peers:
        yield peers


@pytest.mark.rule("W1", "M1")
def test_look_takes_no_lease_and_sees_the_present(peers):
    motion = peers.open(dt=DT)
    motion.step(DT, {"ice": np.full((4, 3), 0.25)})
    accepted, header, bulk = ask(peers.link(), "look", {})
    assert accepted
    look = codec.decode_look_reply(header, bulk)
    assert (look.step, look.attempt, look.time, look.run) == (1, 0, DT, RUN)
    assert look.regions == motion.regions
    assert look.digest == motion.opened.digest
    assert [body.name for region in look.regions for body in region.bodies] == ["hull-body", "ice-body", "wall-body"]
    for row, region in enumerate(look.regions):
        np.testing.assert_array_equal(look.vertices[region.name], TETRAHEDRON + look.poses[row, :3])
    np.testing.assert_allclose(look.poses[1, :3], np.array([3.0, 4, 5]) + DT * DT)  # F = 1 N on 1 kg
    motion.step(DT)  # the lease and the step are as before
    motion.close()


@pytest.mark.rule("W2")
def test_nothing_is_made_for_nobody(memory, monkeypatch):
    memory.service.meet(Listeners())
    monkeypatch.setattr(codec, "encode_news", lambda _: pytest.fail("news were made"))
    motion = memory.open()
    motion.step(DT)
    motion.close()


@pytest.mark.rule("W2", "W3", "W4")
def test_each_kind_of_news_alone(memory):
    audience = Listeners("state")
    memory.service.meet(audience)
    motion = memory.open()
    motion.step(DT)
    wait_until(lambda: len(audience.heard) == 1)
    audience.listening = {"events"}
    motion.step(DT)
    wait_until(lambda: len(audience.heard) == 2)
    assert [news for news, _ in audience.heard] == ["state", "events"]


@pytest.mark.rule("W3")
def test_state_is_that_of_the_end_of_the_step_whatever_the_client_wants(memory):
    audience = Listeners("state")
    memory.service.meet(audience)
    motion = memory.open(dt=DT, wants=m.Wants(vertices=False, sample="midpoint"))
    motion.step(DT, wrenches=np.tile([1.0, 0, 0, 0, 0, 0], (3, 1)))
    wait_until(lambda: audience.heard)
    (state,) = audience.of("state")
    assert (state.step, state.attempt, state.time) == (1, 0, DT)
    np.testing.assert_array_equal(state.twists[:, 0], [DT, DT, 0.0])
    np.testing.assert_array_equal(state.poses[:, 0], [DT * DT, 3.0 + DT * DT, 6.0])


@pytest.mark.rule("W7")
def test_a_look_and_a_state_tell_scales_once_a_body_was_scaled(memory):
    audience = Listeners("state")
    memory.service.meet(audience)
    motion = memory.open()
    for count, scale in enumerate((1.0, 0.5), 1):
        memory.engine.scales[1] = scale
        motion.step(DT)
        wait_until(lambda count=count: len(audience.heard) == count)  # news are made after the reply
    first, second = audience.of("state")
    assert first.scales is None
    np.testing.assert_array_equal(second.scales, [[1.0], [0.5], [1.0]])
    look = codec.decode_look_reply(*ask(memory.link(), "look", {})[1:])
    np.testing.assert_array_equal(look.scales, second.scales)


@pytest.mark.rule("W7")
def test_scales_of_some_bodies_are_refused():
    state = m.StateNews(
        step=1, attempt=0, time=DT, poses=np.ones((2, 7)), twists=np.ones((2, 6)), scales=np.ones((1, 1))
    )
    frame = codec.encode_news(state)
    with pytest.raises(RemoteProtocolError, match="scales of all bodies or of none"):
        codec.decode_news("state", frame.header, frame.bulk())


@pytest.mark.rule("W4")
def test_events_are_told_once_and_not_for_what_was_refused(memory):
    audience = Listeners("events")
    memory.service.meet(audience)
    motion = memory.open()
    link = motion._link
    step = {"lease": motion.opened.lease, "step": 1, "attempt": 0, "dt": DT}
    for header in (step, step, step | {"dt": -1.0}, step | {"step": 5}):  # accepted, from memory, refused twice
        ask(link, "step", header)
    memory.engine.fail = RuntimeError("a fault")
    ask(link, "step", step | {"step": 2})
    ask(link, "step", step | {"attempt": 1})
    wait_until(lambda: len(audience.heard) == 2)
    assert [(news.step, news.attempt) for news in audience.of("events")] == [(1, 0), (1, 1)]
    assert len(audience.of("events")[0].impacts) == 1
    assert audience.of("events")[0].contacts[0].impulse == (2.0, 0.0, 0.0)


@pytest.mark.rule("W5")
def test_progress_is_told_when_a_step_begins_and_after_every_answer(memory):
    audience = Listeners("progress")
    memory.service.meet(audience)
    motion = memory.open()
    wait_until(lambda: len(audience.heard) == 2)
    motion.step(DT)
    wait_until(lambda: len(audience.heard) == 4)
    motion.close()
    wait_until(lambda: len(audience.heard) == 5)
    phases = [(news.phase, news.step, news.client is None) for news in audience.of("progress")]
    of_open = [("computing", 0, True), ("idle", 0, False)]
    assert phases == [*of_open, ("computing", 0, False), ("idle", 1, False), ("free", 1, True)]


@pytest.mark.rule("W6")
def test_an_audience_that_fails_holds_nothing_up(memory):
    class Broken(Listeners):
        def publish(self, *_):
            raise OSError("gone")

    memory.service.meet(Broken("state", "events"))
    motion = memory.open()
    assert motion.step(DT).step == 1
    assert motion.step(DT).step == 2


@pytest.mark.rule("K5", "W2", "W6")
def test_over_zenoh_the_server_works_only_while_someone_listens():
    assert keys.news_key(RUN, "state") == "comotion/1/test/state"
    with ExitStack() as stack:
        peers = stack.enter_context(Peers("zenoh"))
        peers.service.meet(peers.server)
        watch = stack.enter_context(WatchClient(RUN, peers.endpoint))
        motion = peers.open()
        assert not any(peers.server.listens(news) for news in keys.NEWS)
        heard = {news: [] for news in keys.NEWS}
        with watch.listening({news: told.append for news, told in heard.items()}):
            wait_until(lambda: all(peers.server.listens(news) for news in keys.NEWS))
            motion.step(DT)
            wait_until(lambda: heard["state"] and heard["events"] and len(heard["progress"]) >= 2)
        wait_until(lambda: not any(peers.server.listens(news) for news in keys.NEWS))
        motion.step(DT)
        assert [state.step for state in heard["state"]] == [1]
        assert watch.look().step == 2
        assert watch.status().step == 2
        motion.close()


@pytest.mark.rule("K5")
def test_news_that_do_not_exist_or_are_cut_short():
    with pytest.raises(RemoteProtocolError, match="no news"):
        codec.decode_news("weather", b"\x80", b"")
    with pytest.raises(RemoteProtocolError, match="poses and twists"):
        codec.decode_news("state", b"\x80", b"")
