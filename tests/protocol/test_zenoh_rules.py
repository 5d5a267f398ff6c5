"""Section Z of the SPEC, and what else takes a network: real sessions on loopback, real processes to kill."""

import json
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import zenoh
from protocol_peers import PATIENCE, RUN, Peers, ask, error_of, free_port
from trivial_engine import TrivialEngine

from comotion_protocol import EndpointError, MotionClient, PeerAbsentError, arena, keys, zenoh_link
from comotion_protocol.blocks import Frame
from comotion_protocol.endpoints import check_endpoint
from comotion_protocol.zenoh_link import ZenohLink, ZenohServer
from comotion_protocol.zenoh_settings import DEFAULT_ENDPOINT, configure
from comotion_server.desk import Desk
from comotion_server.service import Service
from comotion_server.serving import serve

TESTS = Path(__file__).parents[1]
KILL_NOTICED = 1.0
"""A kill is told of within this time [s] (Z6)."""
FREEZE_NOTICED = 5.0
"""A frozen server within the transport lease of 2 s; the rest is for a machine that is busy with other tests [s]."""
STOP_TIME = 2.0
"""Serving ends within this time [s] after it was told to."""


@pytest.fixture
def endpoint():
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture
def process():
    """Start a script of the tests; it is killed at the end."""
    started = []

    def start(script, *arguments, says):
        child = subprocess.Popen(
            [sys.executable, TESTS / script, *arguments], stdout=subprocess.PIPE, text=True, cwd=TESTS
        )
        started.append(child)
        assert child.stdout.readline().strip() == says
        return child

    yield start
    for child in started:
        child.kill()
        child.wait()
        child.stdout.close()


def config_of(mode, config=None, **given):
    """Zenoh's configuration, or a user's, with our settings."""
    config = config or zenoh.Config()
    wanted = {"listen": None, "connect": None, "timeout": 5.0, "shared_memory": True, "allow_insecure": False} | given
    configure(config, zenoh.Config(), mode=mode, **wanted)
    return config


def settings(mode="peer", config=None, **given):
    """A function that reads a setting at a path."""
    config = config_of(mode, config, **given)
    return lambda path: json.loads(config.get_json(path))


# Settings and endpoints ----------------------------------------------------------------------------------------------


@pytest.mark.rule("Z1", "Z5", "Z6")
def test_settings_of_both_sides():
    server, client = settings("peer"), settings("client")
    assert DEFAULT_ENDPOINT == "tcp/127.0.0.1:7447"
    assert (server("listen/endpoints"), server("connect/endpoints")) == ([DEFAULT_ENDPOINT], [])
    assert (client("listen/endpoints"), client("connect/endpoints")) == ([], [DEFAULT_ENDPOINT])
    for side in (server, client):
        assert side("scouting/multicast/enabled") is False
        assert side("scouting/gossip/enabled") is False
        assert side("transport/link/tx/lease") == 2000
        assert side("connect/timeout_ms") == 5000
        assert side("connect/retry")["period_init_ms"] == 50
        assert side("connect/retry")["period_max_ms"] == 200


SAFE = [
    "tcp/127.0.0.1:7447",
    "tcp/127.9.9.9:1",
    "tcp/[::1]:7447",
    "tcp/localhost:7447#iface=lo",
    "tls/example.org:7447",
    "quic/10.0.0.1:1",
    "unixsock-stream//tmp/socket",
]
UNSAFE = ["tcp/0.0.0.0:7447", "tcp/[::]:7447", "udp/10.0.0.1:7447", "tcp/example.org:7447", "ws/192.168.0.1:80"]


@pytest.mark.rule("Z2")
@pytest.mark.parametrize("endpoint", SAFE)
def test_safe_endpoints(endpoint):
    assert check_endpoint(endpoint, allow_insecure=False) == endpoint


@pytest.mark.rule("Z2")
@pytest.mark.parametrize("endpoint", UNSAFE)
def test_unsafe_endpoints(endpoint):
    with pytest.raises(EndpointError) as refusal:
        MotionClient.open(RUN, endpoint)
    assert refusal.value.code == "insecure_endpoint"
    with pytest.raises(EndpointError, match="without TLS"):
        serve(TrivialEngine(), RUN, [endpoint], stop=threading.Event())
    assert settings(listen=[endpoint], allow_insecure=True)("listen/endpoints") == [endpoint]


@pytest.mark.rule("Z1")
@pytest.mark.parametrize("endpoint", ["", "127.0.0.1:7447", "tcp/", "/127.0.0.1:7447"])
def test_what_is_no_endpoint(endpoint):
    with pytest.raises(EndpointError, match="expected such as"):
        check_endpoint(endpoint, allow_insecure=True)


@pytest.mark.rule("Z9")
def test_a_users_file_goes_first(tmp_path, endpoint):
    file = tmp_path / "zenoh.json5"
    file.write_text(
        f'{{listen: {{endpoints: ["{endpoint}"]}}, transport: {{link: {{tx: {{lease: 4000}}}}}}, // a comment\n'
        "scouting: {gossip: {enabled: true}}}"
    )
    read = settings("peer", zenoh.Config.from_file(file))
    assert read("listen/endpoints") == [endpoint]
    assert read("transport/link/tx/lease") == 4000
    assert read("scouting/gossip/enabled") is True
    assert read("scouting/multicast/enabled") is False
    assert settings("peer", zenoh.Config.from_file(file), listen=[DEFAULT_ENDPOINT])("listen/endpoints") == [
        DEFAULT_ENDPOINT
    ]
    file.write_text('{listen: {endpoints: {peer: ["tcp/0.0.0.0:1"]}}}')
    with pytest.raises(EndpointError, match="without TLS"):
        serve(TrivialEngine(), RUN, zenoh_config=file, stop=threading.Event())
    file.write_text("{listen: ")
    with pytest.raises(EndpointError, match="cannot be read"):
        MotionClient.open(RUN, zenoh_config=file)
    with pytest.raises(EndpointError, match="cannot be read"):
        MotionClient.open(RUN, zenoh_config=tmp_path / "none.json5")


# Opening and serving -------------------------------------------------------------------------------------------------


class Serving:
    """`serve` in a thread."""

    def __init__(self, engine, *arguments, **options):
        self.stop = threading.Event()
        ready = threading.Event()
        self._thread = threading.Thread(
            target=serve, args=(engine, RUN, *arguments), kwargs={"stop": self.stop, "on_ready": ready.set, **options}
        )
        self._thread.start()
        assert ready.wait(PATIENCE)

    def end(self):
        self.stop.set()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()


@pytest.mark.rule("Z3")
def test_a_port_that_is_taken():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(EndpointError, match="taken") as refusal:
            serve(TrivialEngine(), RUN, [endpoint], stop=threading.Event())
    assert refusal.value.detail["endpoint"] == endpoint


@pytest.mark.rule("Z3", "Z5")
def test_a_router_that_is_not_there(endpoint):
    with pytest.raises(EndpointError, match="out of reach"):
        ZenohServer(RUN, Desk(Service(TrivialEngine(), RUN)), connect=[endpoint], timeout=0.2)


@pytest.mark.rule("Z5")
def test_no_server(endpoint):
    started = time.monotonic()
    with pytest.raises(PeerAbsentError, match=f"no server at {endpoint}") as absent:
        MotionClient.open(RUN, endpoint, connect_timeout=0.3)
    assert absent.value.code == "no_server"
    assert 0.3 <= time.monotonic() - started < 5.0


@pytest.mark.rule("Z5")
def test_a_server_of_another_run():
    with Peers("zenoh") as peers, pytest.raises(PeerAbsentError, match="serves run 'other'"):
        MotionClient.open("other", peers.endpoint, connect_timeout=0.3)


@pytest.mark.rule("Z5")
def test_a_client_may_be_there_first(endpoint):
    opened = []
    client = threading.Thread(target=lambda: opened.append(MotionClient.open(RUN, endpoint, connect_timeout=PATIENCE)))
    client.start()
    serving = Serving(TrivialEngine(), [endpoint])
    client.join(PATIENCE)
    opened[0].close()
    serving.end()


def test_serving_ends_even_during_a_step(endpoint):
    engine = TrivialEngine()
    serving = Serving(engine, [endpoint])
    motion = MotionClient.open(RUN, endpoint)
    engine.hold.clear()
    told = []

    def step():
        try:
            motion.step(0.5)
        except PeerAbsentError as error:
            told.append(error.code)

    client = threading.Thread(target=step)
    client.start()
    assert engine.entered.wait(PATIENCE)
    started = time.monotonic()
    serving.end()
    assert time.monotonic() - started < STOP_TIME
    client.join(PATIENCE)
    assert told == ["server_gone"]
    engine.hold.set()
    motion._link.close()


@pytest.mark.rule("K3", "K4")
def test_tokens():
    with Peers("zenoh") as peers:
        motion = peers.open()

        def tokens():
            """What a session that looks for the first time sees."""
            with zenoh.open(config_of("client", listen=[], connect=[peers.endpoint])) as watcher:
                replies = watcher.liveliness().get("comotion/1/test/alive/**", timeout=PATIENCE)
                return {str(reply.ok.key_expr) for reply in replies}

        of_server = {keys.server_token(RUN), keys.instance_token(RUN, peers.service.info.instance)}
        assert tokens() == of_server | {keys.client_token(RUN, motion._link.client_id)}
        motion.close()
        assert tokens() == of_server


# Asking --------------------------------------------------------------------------------------------------------------


@pytest.mark.rule("Z4")
def test_how_a_client_asks():
    with Peers("zenoh") as peers:
        link = peers.link()
        session, asked = link._session, []

        class Recorder:
            def get(self, key, handler, **options):
                asked.append((key, options))
                return session.get(key, handler, **options)

            def is_closed(self):
                return False

        link._session = Recorder()
        assert ask(link, "status", {}, timeout=3.0)[0]
        ask(link, "step", {}, timeout=None)
        link._session = session
    (status_key, status), (step_key, step) = asked
    assert (status_key, step_key) == ("comotion/1/test/status", "comotion/1/test/step")
    for options in (status, step):
        assert options["target"] == zenoh.QueryTarget.BEST_MATCHING
        assert options["consolidation"] == zenoh.ConsolidationMode.NONE
        assert options["congestion_control"] == zenoh.CongestionControl.BLOCK
    assert 3.0 < status["timeout"] < 10.0
    assert step["timeout"] == zenoh_link.QUERY_TIME


@pytest.mark.rule("Z4", "S3")
def test_a_step_may_take_longer_than_a_query(monkeypatch):
    monkeypatch.setattr(zenoh_link, "QUERY_TIME", 0.05)
    with Peers("zenoh") as peers, peers.open() as motion:
        peers.engine.hold.clear()
        finish = peers.in_background(motion.step, 0.5)
        deadline = time.monotonic() + PATIENCE
        while peers.desk.waiting < 2:  # the step was asked for twice more
            assert time.monotonic() < deadline
            motion.status()
        peers.engine.hold.set()
        assert (finish().step, peers.engine.steps_taken) == (1, 1)
        assert motion.step(0.5).step == 2


@pytest.mark.rule("Z7")
def test_a_status_that_is_not_answered():
    with Peers("zenoh") as peers:
        link, kept = peers.link(), []
        peers.desk.receive = kept.append
        with pytest.raises(PeerAbsentError, match=r"no reply to 'status' within 0\.1 s") as silent:
            ask(link, "status", {}, timeout=0.1)
        assert (silent.value.code, silent.value.rule) == ("no_reply", "Z7")
        del peers.desk.receive
        assert ask(link, "status", {})[0]
        kept.clear()


@pytest.mark.rule("E5")
def test_a_callback_that_raises_is_answered():
    def broken(_):
        raise RuntimeError("broken desk")

    with Peers("zenoh") as peers:
        link = peers.link()
        peers.desk.receive = broken
        error = error_of(ask(link, "status", {}))
        assert (error.code, error.rule) == ("failed", "E5")
        del peers.desk.receive
        assert ask(link, "status", {})[0]


@pytest.mark.rule("Z10")
@pytest.mark.parametrize("room", [True, False])
def test_shared_memory_carries_the_same_bytes(room, monkeypatch):
    went = []
    fill = arena.Arena.fill

    def spy(self, frame):
        buffer = fill(self, frame)
        went.append((frame.size, buffer is not None))
        return buffer

    monkeypatch.setattr(arena.Arena, "fill", spy)
    if not room:
        monkeypatch.setattr(arena, "_free_bytes", lambda _: 0)
    received = []

    class Echo:
        def receive(self, question):
            header, bulk = question.frame()
            received.append(bulk)
            question.reply(Frame(header, (np.frombuffer(bulk, "<f8").reshape(-1, 3), np.arange(3.0))))

        def client_alive(self, client_id, *, alive):
            pass

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    rows = np.random.default_rng(0).random((10_000, 3))
    with ZenohServer(RUN, Echo(), listen=[endpoint]) as server:
        server._declare("step")
        token = server._session.liveliness().declare_token(keys.server_token(RUN))
        link = ZenohLink(RUN, endpoint)
        for count in (10, 3000, 10_000, 2731, 10_000):  # smaller and larger than the arena grew for
            assert ask(link, "step", b"h", [rows[:count]]) == (
                True,
                b"h",
                rows[:count].tobytes() + np.arange(3.0).tobytes(),
            )
            assert received[-1] == rows[:count].tobytes()
        link.close()
        token.undeclare()
    assert {size >= arena.LEAST for size, _ in went} == {True, False}
    assert all(shared == (room and size >= arena.LEAST) for size, shared in went)


# Second servers ------------------------------------------------------------------------------------------------------


@pytest.mark.rule("Z8")
def test_a_second_server_of_a_run_is_refused(endpoint):
    with Peers("zenoh") as first:
        with pytest.raises(EndpointError, match="served already") as refusal:
            serve(TrivialEngine(), RUN, [endpoint], [first.endpoint], stop=threading.Event())
        assert refusal.value.code == "already_served"
        with first.open() as motion:
            assert motion.step(0.5).step == 1
        serving_another = threading.Event()
        serving_another.set()
        serve(TrivialEngine(), "another", [endpoint], [first.endpoint], stop=serving_another)


@pytest.mark.rule("Z8")
@pytest.mark.parametrize("_attempt", range(3))
def test_of_two_servers_that_start_at_once_one_stays(_attempt):
    """Two servers that hear of each other through a peer in the middle, as through a router."""
    middle = f"tcp/127.0.0.1:{free_port()}"
    together, one_ended = threading.Barrier(2), threading.Event()
    stops, errors = [threading.Event(), threading.Event()], [None, None]

    def start(n):
        together.wait(PATIENCE)
        try:
            serve(TrivialEngine(), RUN, connect=[middle], stop=stops[n])
        except EndpointError as error:
            errors[n] = error
            one_ended.set()

    with zenoh.open(config_of("router", listen=[middle], connect=[])):
        threads = [threading.Thread(target=start, args=(n,)) for n in range(2)]
        for thread in threads:
            thread.start()
        assert one_ended.wait(PATIENCE)
        with MotionClient.open(RUN, middle) as motion:
            assert motion.step(0.5).step == 1
        for stop, thread in zip(stops, threads, strict=True):
            stop.set()
            thread.join(PATIENCE)
    assert [error is None for error in errors].count(True) == 1
    assert next(error for error in errors if error).code == "already_served"


# Processes that die --------------------------------------------------------------------------------------------------


def told_of_death(motion, child, how):
    """Send a signal to the server while a step runs; the error that the client raises, and after how long."""
    results = []
    computing = threading.Event()

    def step():
        try:
            motion.step(0.5)
        except PeerAbsentError as error:
            results.append((error, time.monotonic()))

    thread = threading.Thread(target=step)
    thread.start()
    while motion.status().phase != "computing":
        computing.wait(0.001)
    child.send_signal(how)
    sent = time.monotonic()
    thread.join(PATIENCE)
    error, heard = results[0]
    return error, heard - sent


@pytest.mark.rule("Z6")
def test_a_server_that_is_killed_in_the_middle_of_a_step(process, endpoint):
    child = process("serve_trivial.py", endpoint, "hold", says="ready")
    motion = MotionClient.open(RUN, endpoint)
    error, delay = told_of_death(motion, child, signal.SIGKILL)
    assert (error.code, error.rule) == ("server_gone", "Z6")
    assert "the server of run 'test' is gone" in error.message
    assert delay < KILL_NOTICED
    with pytest.raises(PeerAbsentError):
        motion.step(0.5)
    with pytest.raises(PeerAbsentError):
        motion.close()


@pytest.mark.rule("Z6")
def test_a_server_that_is_frozen_in_the_middle_of_a_step(process, endpoint):
    child = process("serve_trivial.py", endpoint, "hold", says="ready")
    motion = MotionClient.open(RUN, endpoint)
    error, delay = told_of_death(motion, child, signal.SIGSTOP)
    assert error.code == "server_gone"
    assert delay < FREEZE_NOTICED
    with pytest.raises(PeerAbsentError):
        motion.close()


@pytest.mark.rule("L4")
def test_a_client_that_is_killed_in_the_middle_of_a_step(process):
    with Peers("zenoh") as peers:
        peers.engine.hold.clear()
        child = process("step_and_hang.py", peers.endpoint, says="open")
        assert peers.engine.entered.wait(PATIENCE)
        child.kill()
        link = peers.link()
        deadline = time.monotonic() + PATIENCE
        while peers.service.status().client is not None:
            assert time.monotonic() < deadline
            ask(link, "status", {})
        peers.engine.hold.set()
        with peers.open() as motion:
            assert (motion.opened.step, motion.opened.time) == (2, 0.5)  # the step it died in was kept
            assert motion.step(0.5).step == 2


def test_a_server_process_ends_when_asked(process, endpoint):
    child = process("serve_trivial.py", endpoint, says="ready")
    with MotionClient.open(RUN, endpoint) as motion:
        motion.step(0.5)
    child.send_signal(signal.SIGTERM)
    assert child.wait(STOP_TIME) == 0


def test_a_server_process_ends_in_the_middle_of_a_step(process, endpoint):
    child = process("serve_trivial.py", endpoint, "hold", says="ready")
    motion = MotionClient.open(RUN, endpoint)
    error, delay = told_of_death(motion, child, signal.SIGTERM)
    assert error.code == "server_gone"
    assert delay < STOP_TIME
    assert child.wait(STOP_TIME) == 0
    with pytest.raises(PeerAbsentError):
        motion.close()
