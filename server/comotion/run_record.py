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
    rest_energy: float = 0.0  # [J] taken by contacts that came to rest
    shift_work: float = 0.0  # [J] done to keep held contacts at their gap
    healings: int = 0  # scalings of bodies that were pinched
    worn_mass: float = 0.0  # [kg] lost by them
    budgets_exhausted: int = 0  # steps that needed more responses than allowed
    capped: int = 0  # impacts whose reflections did not end
    fallback_steps: int = 0  # steps in which contacts were held by time-stepping
    blocked_at: list[float] = field(default_factory=list)  # ends of blocked steps [s]
    blocked_bodies: set[str] = field(default_factory=set)  # kept in place
    blocked_contacts: set[tuple[str, str]] = field(default_factory=set)  # pairs that left no motion

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
        self.rest_energy += books.rest_energy or 0.0
        self.shift_work += books.shift_work or 0.0
        self.healings += len(step.reply.wear or ())
        self.worn_mass += sum(worn.mass for worn in step.reply.wear or ())
        budget = step.reply.budget
        self.budgets_exhausted += budget.exhausted
        self.capped += budget.capped or 0
        self.fallback_steps += budget.fallback is not None
        if step.reply.status == "blocked":
            self.blocked_at.append(step.reply.time)
        for blocked in step.reply.blocked or ():
            self.blocked_bodies.update(blocked.bodies)
            self.blocked_contacts.update((pair.body_a, pair.body_b) for pair in blocked.contacts)
