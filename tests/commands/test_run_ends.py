"""Whatever ends a run, both sides end, in time, and what was written stays readable."""

import csv
import os
import signal
import subprocess
import time
from pathlib import Path

import h5py
import pytest
from processes import COMMAND, LongRun, children_of, is_running, wait_until

BOTH_GONE = 2.0  # [s]: the promise for Ctrl-C and SIGTERM
SERVER_MISSED = 1.0  # [s]: the promise for saying that the server died

pytestmark = pytest.mark.skipif(not Path("/proc/self/stat").is_file(), reason="looks at processes through /proc")


@pytest.fixture
def long_run(tmp_path):
    run = LongRun(tmp_path)
    yield run
    run.end()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_both_sides_in_time_with_whole_files(long_run, tmp_path, number):
    long_run.process.send_signal(number)
    seconds, out, errors = long_run.wait()
    assert seconds < BOTH_GONE
    assert not is_running(long_run.server)
    assert long_run.process.returncode == 1
    assert "float_box: interrupted" in out
    assert "Traceback" not in errors
    with (tmp_path / "poses.csv").open() as table:
        assert {len(row) for row in csv.reader(table)} == {15}
    with h5py.File(tmp_path / "bodies.vtkhdf") as series:
        assert series["VTKHDF/Steps"].attrs["NSteps"] == len(series["VTKHDF/Steps/Values"]) > 0
    assert '"status": "interrupted"' in (tmp_path / "summary.json").read_text()


def test_an_interrupt_while_the_server_compiles_its_kernels_ends_both(tmp_path):
    cold = os.environ | {"COMOTION_CACHE": str(tmp_path)}
    process = subprocess.Popen(
        [*COMMAND, "run", "drop"], stderr=subprocess.PIPE, text=True, start_new_session=True, env=cold
    )
    (server,) = wait_until(lambda: children_of(process.pid))
    wait_until(lambda: list(tmp_path.rglob("*.nb[ci]")))  # the first kernel is compiled, others are to come
    start = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert time.monotonic() - start < BOTH_GONE
    assert not is_running(server)
    assert process.returncode == 1
    assert errors == "comotion: interrupted\n"


def test_a_killed_run_leaves_no_server_behind(long_run):
    long_run.process.kill()
    start = time.monotonic()
    wait_until(lambda: not is_running(long_run.server))
    assert time.monotonic() - start < BOTH_GONE


def test_a_killed_server_is_named_at_once(long_run, tmp_path):
    os.kill(long_run.server, signal.SIGKILL)
    seconds, out, errors = long_run.wait()
    assert seconds < SERVER_MISSED
    assert long_run.process.returncode == 1
    assert out == ""
    assert errors == "comotion: the server was killed by signal 9\n"
    with (tmp_path / "wrenches.csv").open() as table:
        assert {len(row) for row in csv.reader(table)} == {8}
