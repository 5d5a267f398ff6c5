"""Keys, messages and errors: sections K, M and E of the SPEC, over memory and over zenoh."""

import hashlib

import numpy as np
import pytest
from protocol_peers import PATIENCE, RUN, Peers, ask, error_of, send
from trivial_engine import FACETS, TETRAHEDRON, TrivialEngine

from comotion_protocol import (
    LocalProtocolError,
    MotionClient,
    PeerAbsentError,
    RemoteProtocolError,
    Wants,
    codec,
    keys,
    limits,
)
from comotion_protocol.messages import UNITS, StepRequest
from comotion_server.results import Blocked, Wear

DT = 0.5
PUSH = {"ice": np.ones((4, 3))}
ICE = np.array([3.0, 4.0, 5.0])  # where the body of the second region starts


def place(row):
    """The vertices of a region at the start."""
    return TETRAHEDRON + np.arange(3.0 * row, 3.0 * row + 3.0)


# K: keys -------------------------------------------------------------------------------------------------------------


@pytest.mark.rule("K1", "K3", "K4")
def test_keys():
    assert {message: keys.message_key("a", message) for message in keys.MESSAGES} == {
        "open": "comotion/1/a/open",
        "step": "comotion/1/a/step",
        "close": "comotion/1/a/close",
        "status": "comotion/1/a/status",
        "look": "comotion/1/a/look",
    }
    assert keys.server_token("a") == "comotion/1/a/alive/server"
    assert keys.instance_token("a", "x2") == "comotion/1/a/alive/instance/x2"
    assert keys.client_token("a", "x1") == "comotion/1/a/alive/client/x1"


@pytest.mark.rule("K1")
def test_other_messages_are_unknown():
    with Peers("memory") as peers:
        error = error_of(ask(peers.link(), "resume", {}))
    assert (error.code, error.rule) == ("unknown_message", "K1")


@pytest.mark.rule("K2")
@pytest.mark.parametrize("run", ["a", "A.b-c_d", "0", "x" * 64])
def test_names_of_runs(run):
    assert keys.check_run(run) == run


@pytest.mark.rule("K2")
@pytest.mark.parametrize("run", ["", "x" * 65, "a/b", "*", "a$b", "-a", ".a", "a b", "a\n", "é", "a#", "a?", None, 7])
def test_other_names_are_refused(run):
    with pytest.raises(LocalProtocolError, match="run name"):
        keys.check_run(run)


# M: messages ---------------------------------------------------------------------------------------------------------


@pytest.mark.rule("M1")
def test_the_four_messages(peers):
    with peers.open(wants=Wants(poses=True, twists=True, velocities=True, impacts=True, contacts=True)) as motion:
        opened = motion.opened
        assert [region.name for region in motion.regions] == ["hull", "ice", "wall"]
        assert opened.protocol == limits.PROTOCOL
        assert motion.plan[0].stage == "move"
        for row, region in enumerate(motion.regions):
            assert (region.vertex_count, region.triangle_count, region.moves) == (4, 4, region.name != "wall")
            assert region.bodies[0].name == f"{region.name}-body"
            assert motion.vertices[region.name].tolist() == place(row).tolist()
            assert motion.triangles[region.name].tolist() == FACETS.tolist()
        assert opened.poses.shape == (3, 7)
        assert opened.twists.shape == (3, 6)
        reply = motion.step(DT, PUSH)
        assert reply.sums.force == (4.0, 4.0, 4.0)
        assert reply.poses[1].tolist() == [4.0, 5.0, 6.0, 1.0, 0.0, 0.0, 0.0]
        assert reply.twists[1].tolist() == [2.0, 2.0, 2.0, 0.0, 0.0, 0.0]
        assert reply.velocities["ice"].tolist() == [[2.0, 2.0, 2.0]] * 4
        assert reply.impacts[0].law == "ordinary"
        assert reply.contacts[0].impulse == (2.0, 0.0, 0.0)
        assert (reply.books.impacts, reply.budget.limit, reply.status) == (1, 10, "ok")
        assert motion.status().step == 1
    assert ask(peers.link(), "status", b"\x80")[0]


@pytest.mark.rule("M1")
def test_only_what_is_wanted_comes(peers):
    with peers.open(wants=Wants(vertices=False)) as motion:
        assert set(motion.vertices) == {"hull", "ice", "wall"}  # of the open reply, always
        reply = motion.step(DT, PUSH)
        assert (reply.vertices, reply.velocities) == ({}, {})
        assert (reply.poses, reply.twists, reply.impacts, reply.contacts) == (None, None, None, None)


@pytest.mark.rule("M2")
def test_versions(link):
    client = {"name": "c", "version": "1", "id": link.client_id}
    error = error_of(ask(link, "open", {"protocol": [2, 0], "client": client}))
    assert (error.code, error.rule) == ("protocol_version", "M2")
    assert ask(link, "open", {"protocol": [1, 99], "client": client})[0]


@pytest.mark.rule("M3")
def test_units(peers):
    with peers.open() as motion:
        assert motion.units == UNITS
    assert UNITS == {
        "length": "m",
        "mass": "kg",
        "time": "s",
        "velocity": "m/s",
        "angular_velocity": "rad/s",
        "force": "N",
        "moment": "N m",
        "impulse": "N s",
    }


@pytest.mark.rule("M4", "M6")
def test_where_samples_hold(peers):
    with peers.open() as motion:
        assert (motion.opened.time, motion.opened.sample_time) == (0.0, 0.0)
        reply = motion.step(DT, PUSH)
        assert (reply.time, reply.sample_time) == (0.5, 0.5)
    with peers.open(wants=Wants(sample="midpoint", poses=True), dt=0.25) as motion:
        assert (motion.opened.time, motion.opened.sample_time) == (0.5, 0.625)
        reply = motion.step(0.25, dt_next=1.0)
        assert (reply.time, reply.sample_time) == (0.75, 1.25)
        assert reply.poses[1, :3].tolist() == [4.0 + 2.0 * 0.75, 5.0 + 2.0 * 0.75, 6.0 + 2.0 * 0.75]
        assert reply.vertices["ice"][0].tolist() == reply.poses[1, :3].tolist()
        assert motion.step(0.25).sample_time == 1.125


@pytest.mark.rule("M6")
def test_midpoint_needs_dt_and_resume_is_not_supported(peers):
    with pytest.raises(LocalProtocolError, match="dt is missing") as refusal:
        peers.open(wants=Wants(sample="midpoint"))
    assert (refusal.value.code, refusal.value.rule) == ("missing", "M6")
    link = peers.link()
    header = {"protocol": [1, 0], "client": {"name": "c", "version": "1"}, "resume": {"step": 1}}
    error = error_of(ask(link, "open", header))
    assert (error.code, error.rule) == ("not_supported", "M6")
    assert "not supported by this server" in error.message
    peers.open().close()


@pytest.mark.rule("M5")
def test_facets(peers):
    with peers.open(wants=Wants(indexing="facets")) as motion:
        region = motion.regions[1]
        assert (region.vertex_count, region.triangle_count) == (12, 4)
        assert (region.bodies[0].first_vertex, region.bodies[0].vertex_count) == (0, 12)
        assert motion.triangles["ice"].ravel().tolist() == list(range(12))
        assert motion.vertices["ice"].tolist() == (TETRAHEDRON + ICE)[FACETS.ravel()].tolist()
        forces = np.arange(36.0).reshape(12, 3)
        reply = motion.step(DT, {"ice": forces})
        assert reply.vertices["ice"].shape == (12, 3)
        assert reply.sums.force == tuple(forces.sum(axis=0))
    welded = np.zeros((4, 3))
    np.add.at(welded, FACETS.ravel(), forces)
    straight = TrivialEngine()
    straight.step(DT, {"ice": welded})
    assert peers.engine.position.tobytes() == straight.position.tobytes()


@pytest.mark.rule("M7")
def test_digest(peers):
    by_hand = hashlib.sha256()
    for row, name in enumerate(("hull", "ice", "wall")):
        start = place(row)
        by_hand.update(name.encode() + b"\0" + start.astype("<f8").tobytes() + FACETS.astype("<u4").tobytes())
    with peers.open(digest=by_hand.hexdigest()) as motion:
        assert motion.opened.digest == by_hand.hexdigest()
        motion.step(DT, PUSH)
    with pytest.raises(LocalProtocolError, match="digest"):
        peers.open(digest="0" * 64)
    peers.open(digest=by_hand.hexdigest(), wants=Wants(indexing="facets")).close()


@pytest.mark.rule("M8")
def test_still_regions_are_sent_once(peers):
    with peers.open(wants=Wants(velocities=True)) as motion:
        request = StepRequest(lease=motion.opened.lease, step=1, attempt=0, dt=DT, forces=PUSH)
        accepted, header, bulk = send(peers.link(), request)
        assert accepted
        sent = codec.decode_step_reply(header, bulk)
        assert set(sent.vertices) == set(sent.velocities) == {"hull", "ice"}
        reply = motion.step(DT, PUSH)  # the very same bytes: answered from memory
        assert set(reply.vertices) == set(reply.velocities) == {"hull", "ice", "wall"}
        assert reply.vertices["wall"].tolist() == motion.vertices["wall"].tolist()


@pytest.mark.rule("M9")
@pytest.mark.parametrize("kind", ["memory", "zenoh"])
def test_two_runs_give_the_same_bytes(kind):
    answers = []
    for _ in range(2):
        with Peers(kind) as peers:
            link = peers.link()
            lease = MotionClient.open(RUN, link=link, wants=Wants(impacts=True, poses=True)).opened.lease
            peers.clock.now += 17.0
            requests = [
                StepRequest(lease=lease, step=1, attempt=0, dt=DT, forces=PUSH),
                StepRequest(lease=lease, step=1, attempt=1, dt=0.3, forces=PUSH),
                StepRequest(lease=lease, step=2, attempt=0, dt=0.1),
            ]
            answers.append([send(link, request) for request in requests])
    assert answers[0] == answers[1]


@pytest.mark.rule("M10")
def test_long_lists_of_impacts_are_cut():
    class ManyImpacts(TrivialEngine):
        def step(self, dt, forces=None, wrenches=None):
            out = super().step(dt, forces, wrenches)
            out.impacts *= limits.IMPACTS + 7
            out.books.impacts = len(out.impacts)
            return out

    with Peers("memory", ManyImpacts()) as peers, peers.open(wants=Wants(impacts=True)) as motion:
        reply = motion.step(DT)
        assert len(reply.impacts) == limits.IMPACTS
        assert reply.books.impacts == limits.IMPACTS + 7


@pytest.mark.rule("M11")
def test_busy_counts_computing_alone(peers, link):
    with peers.open() as motion:
        peers.clock.now += 5.0
        assert motion.status().busy == 0.0
        peers.engine.hold.clear()
        finish = peers.in_background(motion.step, DT)
        assert peers.engine.entered.wait(PATIENCE)
        peers.clock.now += 3.0
        _, header, bulk = ask(link, "status", {})
        assert codec.decode_status_reply(header, bulk).busy == 3.0
        peers.engine.hold.set()
        assert finish().step == 1
        peers.clock.now += 5.0
        status = motion.status()
        assert (status.busy, status.phase, status.step, status.time) == (3.0, "idle", 1, DT)


@pytest.mark.rule("M12")
def test_bodies_are_numbered_by_name(peers):
    with peers.open(wants=Wants(poses=True)) as motion:
        names = [body.name for region in motion.regions for body in region.bodies]
        assert sorted(names) == list(peers.engine.bodies.names)
        assert motion.opened.poses[:, 0].tolist() == [0.0, 3.0, 6.0]


@pytest.mark.rule("M12")
def test_bodies_without_a_surface_have_no_number():
    class WithAFloor(TrivialEngine):
        def __init__(self):
            super().__init__(("hull", "hull-floor", "ice"))
            self.everything, self.loads = self.regions, []
            self.regions = (self.regions[0], self.regions[2])  # the body in the middle has no surface

        def step(self, dt, forces=None, wrenches=None):
            self.loads.append(wrenches)
            seen, self.regions = self.regions, self.everything
            out = super().step(dt, forces, wrenches)
            self.regions = seen
            return out

    wrenches = np.arange(12.0).reshape(2, 6)
    with Peers("memory", WithAFloor()) as peers, peers.open(wants=Wants(poses=True, twists=True)) as motion:
        reply = motion.step(DT, wrenches=wrenches)
        np.testing.assert_array_equal(peers.engine.loads, [[wrenches[0], np.zeros(6), wrenches[1]]])
        assert reply.twists[:, 0].tolist() == [0.0, 6.0 * DT]


@pytest.mark.rule("M13")
def test_blocked_bodies_are_named(peers):
    with peers.open() as motion:
        assert motion.step(DT).blocked is None
    hull, wall = peers.engine.bodies.names[0], peers.engine.bodies.names[-1]

    class Jammed(TrivialEngine):
        def step(self, dt, forces=None, wrenches=None):
            out = super().step(dt, forces, wrenches)
            out.status, out.blocked = "blocked", (Blocked(0.25, (hull,), ((hull, wall),)),)
            return out

    with Peers("memory", Jammed()) as jammed, jammed.open() as motion:
        reply = motion.step(DT)
        (blocked,) = reply.blocked
        assert (reply.status, blocked.time, blocked.bodies) == ("blocked", 0.25, (hull,))
        assert [(pair.body_a, pair.body_b) for pair in blocked.contacts] == [(hull, wall)]


@pytest.mark.rule("M14")
def test_bodies_that_were_scaled_down_are_listed(peers):
    with peers.open() as motion:
        assert motion.step(DT).wear is None
    floe = peers.engine.bodies.names[0]

    class Crushed(TrivialEngine):
        def step(self, dt, forces=None, wrenches=None):
            out = super().step(dt, forces, wrenches)
            out.wear = (Wear(0.25, floe, 0.5, 0.1, 7.0, np.array([1.0, 0.0, 0.0]), np.array([0.0, 2.0, 0.0]), 3.0),)
            return out

    with Peers("memory", Crushed()) as crushed, crushed.open() as motion:
        (wear,) = motion.step(DT).wear
        assert (wear.time, wear.body, wear.scale, wear.depth, wear.mass, wear.energy) == (
            0.25,
            floe,
            0.5,
            0.1,
            7.0,
            3.0,
        )
        assert (wear.momentum, wear.angular_momentum) == ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0))


# E: errors -----------------------------------------------------------------------------------------------------------


@pytest.mark.rule("E1", "E4")
def test_a_refused_request_changes_nothing(peers):
    with peers.open() as motion:
        motion.step(DT, PUSH)
        before = peers.engine.checkpoint()[0], peers.engine.position.tobytes(), peers.engine.velocity.tobytes()
        for bad in (
            lambda: motion.step(-1.0, PUSH),
            lambda: motion.step(DT, {"water": np.ones((4, 3))}),
            lambda: motion.step(DT, {"ice": np.ones((5, 3))}),
            lambda: motion.step(DT, {"ice": np.full((4, 3), np.nan)}),
            lambda: motion.redo(np.nan, PUSH),
        ):
            with pytest.raises(LocalProtocolError):
                bad()
        assert before == (peers.engine.time, peers.engine.position.tobytes(), peers.engine.velocity.tobytes())
        assert motion.redo(DT, PUSH).attempt == 1  # the open step is still open
        assert motion.step(DT, PUSH).step == 2


@pytest.mark.rule("E5", "E3", "E4")
@pytest.mark.parametrize("failure", [RuntimeError("out of luck"), MemoryError(), ZeroDivisionError("0")])
def test_a_fault_of_the_server_is_answered_and_undone(peers, failure, caplog):
    with peers.open() as motion:
        motion.step(DT, PUSH)
        first = peers.engine.position.tobytes()
        for attempt in (motion.step, motion.redo):
            peers.engine.fail = failure
            with pytest.raises(RemoteProtocolError, match=type(failure).__name__) as answer:
                attempt(DT, PUSH)
            assert (answer.value.code, answer.value.rule) == ("failed", "E5")
            assert peers.engine.position.tobytes() == first
        assert motion.redo(DT, PUSH).attempt == 1
        assert peers.engine.position.tobytes() == first
    assert "a request failed" in caplog.text


@pytest.mark.rule("E5")
def test_what_waits_when_the_server_stops_is_told():
    with Peers("memory") as peers:
        motion = peers.open()
        peers.engine.hold.clear()
        first = peers.in_background(motion.step, DT)
        assert peers.engine.entered.wait(PATIENCE)
        request = StepRequest(lease=motion.opened.lease, step=2, attempt=0, dt=DT)
        second = peers.in_background(send, peers.link(), request)
        while peers.desk.waiting == 0:
            motion.status()
        stopping = peers.in_background(peers.desk.__exit__)
        while not peers.desk._stopping:
            pass
        peers.engine.hold.set()
        assert first().step == 1
        assert error_of(second()).code == "stopping"
        stopping()


@pytest.mark.rule("E6")
def test_an_empty_set_of_replies_is_an_absent_peer():
    with Peers("zenoh") as peers:
        link = peers.link()
        peers.desk.receive = lambda _: None  # it loses the query, so that zenoh ends it without a reply
        with pytest.raises(PeerAbsentError) as absent:
            ask(link, "status", {})
        assert (absent.value.code, absent.value.rule) == ("server_gone", "Z6")
