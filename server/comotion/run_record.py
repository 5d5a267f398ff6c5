"""What a run was like: figures that are gathered step by step and told at its end."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from comotion_mock_cfd.cfd_client import StepRecord


@dataclass
class RunRecord:
    """Figures of the steps so far.

    The errors are the worst of all impacts, relative to the scale of the books of that impact (docs/outputs.md).
    """

    start: float  # time of the run when this client came [s]
    time: float  # the run's time now [s]
    steps: int = 0
    impacts: int = 0
    momentum_error: float = 0.0
    angular_momentum_error: float = 0.0
    energy_error: float = 0.0
    overlaps: int = 0
    overlap_max: float = 0.0  # [m]
    budgets_exhausted: int = 0  # steps that needed more responses than allowed
    blocked_at: list[float] = field(default_factory=list)  # ends of blocked steps [s]

    @property
    def simulated(self) -> float:
        """Time simulated with this client [s]."""
        return self.time - self.start

    def add(self, step: "StepRecord") -> None:
        """Take one step."""
        books = step.reply.books
        self.steps += 1
        self.time = step.reply.time
        self.impacts += books.impacts
        self.momentum_error = max(self.momentum_error, books.momentum)
        self.angular_momentum_error = max(self.angular_momentum_error, books.angular_momentum)
        self.energy_error = max(self.energy_error, books.energy)
        self.overlaps += books.overlaps
        self.overlap_max = max(self.overlap_max, books.overlap_max)
        self.budgets_exhausted += step.reply.budget.exhausted
        if step.reply.status == "blocked":
            self.blocked_at.append(step.reply.time)
