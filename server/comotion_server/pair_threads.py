"""The distances of many pairs on several threads.

The kernel runs without Python's lock, so plain threads share the rows: no second compilation and no thread library
under the server. Each pair is answered on its own, so the number of threads does not change a bit of the result. Few
pairs stay on the calling thread, which always works along: where the other processors are busy, it does most itself.
"""

import os
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.mesh_pair import closest_points_of_rows

FEWEST = 64  # pairs that are worth a second thread: handing out a share costs about 50 us, a pair 5 to 50
SHARES = 4  # per thread: pairs differ in cost, so a thread that is done early takes another share


def thread_count() -> int:
    """COMOTION_THREADS, or the processors that this process may use."""
    given = os.environ.get("COMOTION_THREADS", "")
    if given:
        if not given.isdecimal() or int(given) < 1:
            raise ValueError(f"COMOTION_THREADS must be a whole number of at least 1; got {given!r}")
        return int(given)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class PairThreads:
    """Threads that answer the rows of a pair table; they start when there is first enough to do."""

    def __init__(self, count: int | None = None) -> None:
        self.count = thread_count() if count is None else count
        self._pool: ThreadPoolExecutor | None = None

    def closest_points(self, rows: NDArray[np.int64], *arguments: Any) -> None:
        """As `closest_points_of_rows`, the arguments after `rows`."""
        if self.count == 1 or len(rows) < FEWEST:
            closest_points_of_rows(rows, *arguments)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self.count - 1, "comotion-pairs")
        shares = deque(np.array_split(rows, self.count * SHARES))

        def work() -> None:
            with suppress(IndexError):
                while True:
                    closest_points_of_rows(shares.popleft(), *arguments)

        helpers = [self._pool.submit(work) for _ in range(self.count - 1)]
        work()
        for helper in helpers:
            if not helper.cancel():  # one that has not begun is not waited for
                helper.result()
