"""A cell of the matrix of stiff and extreme cases."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """One case at one value: passes where `measure()` is at most `limit`."""

    case: str
    value: str
    required: str
    criterion: str
    measure: Callable[[], float]
    limit: float
    long: bool = False  # takes more than about a second
    explained: str = ""  # why it fails, where it is known to

    @property
    def name(self) -> str:
        """For a test's name."""
        return f"{self.case}, {self.value}"


def refused(run: Callable[[], object], error: type[Exception], *words: str) -> float:
    """0 where `run` raises `error` with all `words` in its text, else 1."""
    try:
        run()
    except error as refusal:
        return float(not all(word in str(refusal) for word in words))
    return 1.0
