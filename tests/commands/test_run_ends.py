"""Whatever ends a run, both sides end, in time, and what was written stays readable."""

import csv
import os
import signal
import time
from pathlib import Path

import h5py
import pytest
from processes import LongRun, is_running, wait_until

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
