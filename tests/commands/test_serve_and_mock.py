"""`serve` and `mock` as two processes that know each other by an endpoint alone."""

import json
import signal
import subprocess
import time

import pytest
from processes import COMMAND, START_PATIENCE, run_command

from comotion.child_server import free_endpoint

STOPPED = 2.0  # [s]: the promise for SIGINT and SIGTERM


class Server:
    """`comotion serve float_box`, ready."""

    def __init__(self, *arguments):
        self.endpoint = free_endpoint()
        command = [*COMMAND, "serve", "float_box", "--run", "box", "--listen", self.endpoint, *arguments]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.ready_line = self.process.stdout.readline()

    def stop(self, number=signal.SIGKILL):
        """Seconds until it was gone, and its words."""
        start = time.monotonic()
        if self.process.poll() is None:
            self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=START_PATIENCE)
        return time.monotonic() - start, errors


@pytest.fixture(scope="module")
def server():
    server = Server()
    yield server
    server.stop()


@pytest.fixture
def own_server(request):
    server = Server(*request.param)
    yield server
    server.stop()


def test_the_mock_plays_against_a_server_twice(server):
    assert server.ready_line == f"comotion: run 'box' is served on {server.endpoint}; stop with Ctrl-C\n"
    arguments = ("mock", "float_box", "--run", "box", "--connect", server.endpoint, "--json")
    first = run_command(*arguments, "--duration", "0.2")
    assert first.returncode == 0, first.stderr
    assert json.loads(first.stdout)["steps"] == 40
    # The server's time goes on; a client that comes later plays to its scene's end.
    second = run_command(*arguments, "--duration", "0.3")
    assert second.returncode == 0, second.stderr
    assert json.loads(second.stdout)["steps"] == 20
    assert json.loads(second.stdout)["simulated_s"] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("own_server", "number"), [(("--json",), signal.SIGINT), ((), signal.SIGTERM)], indirect=["own_server"]
)
def test_a_signal_stops_the_server_cleanly(own_server, number):
    if own_server.ready_line.startswith("{"):
        expected = {"ready": True, "run": "box", "endpoint": own_server.endpoint, "motion": {"box": "free"}}
        assert json.loads(own_server.ready_line) == expected
    seconds, errors = own_server.stop(number)
    assert seconds < STOPPED
    assert own_server.process.returncode == 0
    assert errors == ""


@pytest.mark.parametrize("own_server", [("--stop-with-stdin",)], indirect=True)
def test_the_end_of_standard_input_stops_the_server_if_asked_to(own_server):
    start = time.monotonic()
    own_server.process.stdin.close()
    own_server.process.stdin = None  # or `communicate` would flush it
    assert own_server.process.wait(START_PATIENCE) == 0
    assert time.monotonic() - start < STOPPED


def test_a_port_that_is_taken_is_named(server):
    done = run_command("serve", "drop", "--listen", server.endpoint)
    assert done.returncode == 2
    assert server.endpoint in done.stderr
    assert "Traceback" not in done.stderr


def test_an_absent_server_is_named():
    endpoint = free_endpoint()
    done = run_command("mock", "float_box", "--run", "box", "--connect", endpoint, "--wait", "0.5")
    assert done.returncode == 1
    assert endpoint in done.stderr
    assert "no server" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_run_that_nobody_serves_is_named(server):
    done = run_command("mock", "float_box", "--run", "bx", "--connect", server.endpoint, "--wait", "0.5")
    assert done.returncode == 1
    assert "'bx'" in done.stderr


def test_a_fluid_that_does_not_fit_the_run_is_named(server, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text("[scene]\nduration = 1.0\ndt = 0.01\n[fluid]\nadded_mass = { boks = 1.0 }\n")
    done = run_command("mock", scene, "--run", "box", "--connect", server.endpoint)
    assert done.returncode == 2
    assert "'boks'" in done.stderr
    assert "Traceback" not in done.stderr


def test_an_endpoint_beyond_this_machine_needs_the_flag():
    everywhere = "tcp/0.0.0.0:7447"
    done = run_command("serve", "drop", "--listen", everywhere)
    assert done.returncode == 2
    assert everywhere in done.stderr
    assert "Traceback" not in done.stderr
