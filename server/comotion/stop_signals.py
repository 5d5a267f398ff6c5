"""What ends a command before its time: SIGTERM, taken as Ctrl-C is, and the end of standard input."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

STDIN = 0
GRACE = 1.5  # [s] from the end of standard input to the end of the process, whatever it is at


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt


@contextmanager
def terminate_as_interrupt() -> Iterator[None]:
    """Within the block SIGTERM raises KeyboardInterrupt in the main thread."""
    before = signal.signal(signal.SIGTERM, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


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
