"""Wall time, warm: the median of repeated runs."""

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import TypeVar

Result = TypeVar("Result")

REPEATS = 5


def timed(run: Callable[[], Result], repeats: int = REPEATS) -> tuple[float, Result]:
    """Median wall time [s] of `repeats` runs, and what the last one returned."""
    spent = []
    for _ in range(repeats):
        begin = perf_counter()
        result = run()
        spent.append(perf_counter() - begin)
    return median(spent), result


def timed_from(make: Callable[[], Callable[[], Result]], repeats: int = REPEATS) -> tuple[float, Result]:
    """As `timed`, for runs that start from something made anew each time, which is not in the figure."""
    spent = []
    for _ in range(repeats):
        run = make()
        begin = perf_counter()
        result = run()
        spent.append(perf_counter() - begin)
    return median(spent), result
