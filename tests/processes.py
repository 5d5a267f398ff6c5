"""The command line as users run it: in processes of its own."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

COMMAND = (sys.executable, "-m", "comotion")
START_PATIENCE = 280.0  # [s]: the first start on a machine compiles the kernels


def run_command(*arguments, **options):
    """A command run to its end."""
    return subprocess.run(
        [*COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=START_PATIENCE, check=False, **options
    )


def wait_until(happened, patience=START_PATIENCE):
    """Poll until something is true; returns it."""
    deadline = time.monotonic() + patience
    while not (result := happened()):
        assert time.monotonic() < deadline, f"not within {patience} s: {happened}"
        time.sleep(0.01)
    return result


def is_running(pid):
    """Whether a process is there and not merely waiting to be reaped."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def children_of(pid):
    """Process ids of a process's children."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
        except (FileNotFoundError, ProcessLookupError):
            continue
        if parent == pid:
            found.append(int(stat.parent.name))
    return found


class LongRun:
    """`comotion run` in the middle of a scene that would take very long, and its server."""

    def __init__(self, folder):
        arguments = ("run", "float_box", "--duration", "100000", "--out", str(folder))
        self.process = subprocess.Popen(
            [*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
        wait_until(lambda: (folder / "wrenches.csv").is_file() and (folder / "wrenches.csv").stat().st_size > 1000)
        (self.server,) = children_of(self.process.pid)

    def wait(self, patience=START_PATIENCE):
        """Seconds until it ended, and what it wrote."""
        start = time.monotonic()
        out, errors = self.process.communicate(timeout=patience)
        return time.monotonic() - start, out, errors

    def end(self):
        """Leave nothing behind."""
        for pid in (self.process.pid, self.server):
            if is_running(pid):
                os.kill(pid, signal.SIGKILL)
        self.process.communicate()
