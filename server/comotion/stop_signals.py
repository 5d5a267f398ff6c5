"""What ends a command before its time: Ctrl-C, SIGTERM, and the end of standard input."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Self

STDIN = 0
GRACE = 1.5  # [s] from the end of standard input to the end of the process, whatever it is at


class Interrupts:
    """Within the block SIGINT (Ctrl-C) and SIGTERM both raise KeyboardInterrupt in the main thread, unless held.

    An interrupt that comes while a library calls back into Python may be swallowed there. It stays noted, and is raised
    again when the next held work is done.
    """

    def __init__(self) -> None:
        self._held = False
        self._noted = False

    @contextmanager
    def held(self) -> Iterator[None]:
        """Work that is to be whole, such as writing a step to files: an interrupt waits until it is done."""
        self._held = True
        try:
            yield
        finally:
            self._held = False
        if self._noted:
            raise KeyboardInterrupt

    def __enter__(self) -> Self:
        self._before = {number: signal.signal(number, self._receive) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _receive(self, _number: int, _frame: FrameType | None) -> None:
        self._noted = True
        if not self._held:
            raise KeyboardInterrupt


def stop_with_stdin(stop: threading.Event) -> None:
    """Set `stop` when standard input ends; a process that does not heed it in time is ended all the same."""

    def watch() -> None:
        # Not through sys.stdin: a thread inside its buffer would hold a lock that the interpreter needs at its end.
        while os.read(STDIN, 4096):
            pass
        stop.set()
        threading.Event().wait(GRACE)
        os._exit(1)

    threading.Thread(target=watch, name="comotion stdin", daemon=True).start()
