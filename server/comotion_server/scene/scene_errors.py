"""Mistakes in a scene, all of them at once, each as one line that an editor can jump to."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable


@dataclass(frozen=True)
class Problem:
    """One mistake.

    Attributes:
        file: the file with the mistake, as the user named it.
        line: its line, counted from 1, or None where no line is to blame.
        where: the key, for instance `body "hull".mass`; empty when the file itself is to blame.
        message: what was given and what is allowed.
    """

    file: str
    line: int | None
    where: str
    message: str

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        return f"{place}: {self.where}: {self.message}" if self.where else f"{place}: {self.message}"

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self)


class SceneError(ValueError):
    """A scene that cannot be used; `problems` has every mistake, in the order of their lines."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=lambda problem: (problem.file, problem.line or 0)))
        super().__init__("\n".join(map(str, self.problems)))
