"""The server as a child process of `comotion run`.

It is `comotion serve` with its standard input on a pipe from here: when this process ends in whatever way, SIGKILL
included, the pipe closes and the server stops (`--stop-with-stdin`; works on every platform). It gets a session of its
own, so that Ctrl-C reaches this process alone, which then ends both in order.
"""

import json
import socket
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from comotion.commands.errors import BAD_OUTCOME, ChildError, UserError

EXIT_PATIENCE = 0.5  # [s] between the news that the server is gone and its exit code
STOP_PATIENCE = 1.0  # [s] between asking the server to stop and killing it; both sides are to be gone within 2 s


@dataclass(frozen=True)
class Ready:
    """The server's ready line: where it is, and how each body moves ("free", "fixed" or "prescribed")."""

    run: str
    endpoint: str
    motion: dict[str, str]


def free_endpoint() -> str:
    """An endpoint on loopback whose port nobody uses just now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


class ServerProcess:
    """A running `comotion serve`; leaving the block ends it."""

    def __init__(self, scene: Path) -> None:
        command = [sys.executable, "-m", "comotion", "serve", str(scene), "--listen", free_endpoint()]
        self._errors = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115  # until `stop`
        self._process = subprocess.Popen(
            [*command, "--json", "--stop-with-stdin"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            start_new_session=True,
        )

    def wait_until_ready(self) -> Ready:
        """Wait for the ready line; the first run ever compiles the kernels, which takes a while.

        Raises:
            UserError: the server refused; the text and the exit code are its own.
        """
        assert self._process.stdout is not None  # noqa: S101  # for the type checker: it is a pipe
        line = self._process.stdout.readline()
        if not line:
            raise self.failure("the server does not start")
        facts: dict[str, Any] = json.loads(line)
        return Ready(facts["run"], facts["endpoint"], facts["motion"])

    def failure(self, seen: str) -> UserError:
        """Why the server is gone: its own words, as far as it had any; what was `seen` from here if it still runs."""
        try:
            code = self._process.wait(EXIT_PATIENCE)
        except subprocess.TimeoutExpired:
            return UserError(seen, BAD_OUTCOME)
        self._errors.seek(0)
        how = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
        words = self._errors.read().strip() or f"comotion: the server {how}"
        return ChildError(words, code if code > 0 else BAD_OUTCOME)

    def stop(self) -> None:
        """End the server: ask by closing its input, kill it when it takes too long."""
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
        try:
            self._process.wait(STOP_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._errors.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()
