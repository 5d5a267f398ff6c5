"""What a step gives back. Vectors are in the world frame, SI units."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Impact:
    """One response of the queue to a pair that collides (P10, P11)."""

    time: float  # [s] since the start of the scene
    body_a: str
    body_b: str
    point: Array  # (3,) on body b [m]
    normal: Array  # (3,) unit, from a to b
    impulse: float  # along the normal: + on b, - on a [N s]
    approach_speed: float  # before the impact, positive [m/s]
    restitution: float
    law: str  # "ordinary", or "parallel" (P12)


@dataclass(frozen=True, slots=True)
class Contact:
    """All impulses of one pair in one step."""

    body_a: str
    body_b: str
    impulse: Array  # (3,) on body b; on body a the opposite [N s]
    count: int


@dataclass(slots=True)
class Books:
    """Largest relative errors in the balances of the impacts of a step, and the overlaps it met (VALIDATION B)."""

    momentum: float = 0.0
    angular_momentum: float = 0.0
    energy: float = 0.0
    impacts: int = 0
    overlaps: int = 0
    overlap_max: float = 0.0  # [m]

    def meet_overlap(self, depth: float, *, new: bool) -> None:
        """Books an overlap of `depth` [m]; `new` if the pair was apart at the sub-step before."""
        self.overlaps += new
        self.overlap_max = max(self.overlap_max, depth)


@dataclass(frozen=True, slots=True)
class Budget:
    """Rounds of the queue: allowed and used in the step; exhausted: the rest of the step went without responses."""

    limit: int
    used: int

    @property
    def exhausted(self) -> bool:
        """Whether the step ran out of rounds."""
        return self.used >= self.limit > 0


@dataclass(frozen=True, slots=True)
class Sums:
    """Total of the received forces."""

    force: Array  # (3,) [N]
    moment: Array  # (3,) about the world origin [N m]


@dataclass(frozen=True, slots=True)
class CollisionRecord:
    """What the queue did in a step."""

    impacts: tuple[Impact, ...] = ()
    contacts: tuple[Contact, ...] = ()
    books: Books = field(default_factory=Books)
    budget: Budget = Budget(0, 0)


@dataclass(frozen=True, slots=True)
class StepResult:
    """One step of the simulation."""

    time: float  # at its end, since the start of the scene [s]
    dt: float  # [s]
    status: str  # "ok"
    sums: Sums
    impacts: tuple[Impact, ...]
    contacts: tuple[Contact, ...]
    books: Books
    budget: Budget
