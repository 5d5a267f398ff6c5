"""What a step gives back. Vectors are in the world frame, SI units."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Impact:
    """One contact of an impact (P10, P11): a patch of several points gives one for each."""

    time: float  # [s] since the start of the scene
    body_a: str
    body_b: str
    point: Array  # (3,) on body b [m]
    normal: Array  # (3,) unit, from a to b
    impulse: float  # along the normal: + on b, - on a [N s]
    approach_speed: float  # before the impact, positive [m/s]
    restitution: float
    law: str  # "together", "sequential", "soft" (e = 0 to come to rest), "merge"; of the paper: "ordinary", "parallel"
    friction: Array | None = None  # (3,) tangential impulse on body b [N s]; None without friction


@dataclass(frozen=True, slots=True)
class Contact:
    """All impulses of one pair in one step: of impacts and of contacts that are held."""

    body_a: str
    body_b: str
    impulse: Array  # (3,) on body b, of both kinds; on body a the opposite [N s]
    count: int  # of impacts
    held: Array = field(default_factory=lambda: np.zeros(3))  # (3,) share of held contacts [N s]


@dataclass(frozen=True, slots=True)
class Blocked:
    """A motion that cannot be: bodies that were kept where they are from `time` to the end of the step."""

    time: float  # [s] since the start of the scene
    bodies: tuple[str, ...]  # kept in place, in the order of their names
    contacts: tuple[tuple[str, str], ...]  # pairs of bodies whose contacts exclude each other


@dataclass(slots=True)
class Books:
    """Largest relative errors in the balances of a step's impacts, what coming to rest took, and the overlaps met."""

    momentum: float = 0.0
    angular_momentum: float = 0.0
    energy: float = 0.0
    impacts: int = 0
    overlaps: int = 0
    overlap_max: float = 0.0  # [m]
    rest_energy: float = (
        0.0  # [J] taken by contacts that come to rest (hops and collapses below the tolerance) and by merging
    )
    shift_work: float = 0.0  # [J] done by keeping held contacts at their gap

    def meet_overlap(self, depth: float, *, new: bool) -> None:
        """Books an overlap of `depth` [m]; `new` if the pair was apart at the sub-step before."""
        self.overlaps += new
        self.overlap_max = max(self.overlap_max, depth)


@dataclass(frozen=True, slots=True)
class Budget:
    """Responses allowed and used in the step, and where less exact means had to do: zeros in all but extreme scenes."""

    limit: int
    used: int
    capped: int = 0  # impacts whose reflections did not end: answered with e = 0
    fallback: float = 0.0  # share of the step and of the bodies, 0 to 1, whose contacts were held by time-stepping

    @property
    def exhausted(self) -> bool:
        """Whether the step ran out: the rest of it was taken with e = 0 (rule `exact`) or without responses."""
        return self.used >= self.limit > 0


@dataclass(frozen=True, slots=True)
class Sums:
    """Total of the received forces."""

    force: Array  # (3,) [N]
    moment: Array  # (3,) about the world origin [N m]


@dataclass(frozen=True, slots=True)
class Wear:
    """What a body lost when it was scaled down to be free (P16): it went out of the simulation."""

    time: float  # [s] since the start of the scene
    body: str  # of a group its first member
    scale: float  # of the body now, relative to the scene's
    depth: float  # the overlap that was to be cleared [m]
    mass: float  # [kg]; 0 where healing is of the geometry only
    momentum: Array  # (3,) [N s]
    angular_momentum: Array  # (3,) about the world origin [N m s]
    energy: float  # kinetic [J]


@dataclass(frozen=True, slots=True)
class CollisionRecord:
    """What the queue did in a step."""

    impacts: tuple[Impact, ...] = ()
    contacts: tuple[Contact, ...] = ()
    books: Books = field(default_factory=Books)
    budget: Budget = Budget(0, 0)
    blocked: tuple[Blocked, ...] = ()
    wear: tuple[Wear, ...] = ()


@dataclass(frozen=True, slots=True)
class StepResult:
    """One step of the simulation."""

    time: float  # at its end, since the start of the scene [s]
    dt: float  # [s]
    status: str  # "ok", or "blocked" when `blocked` says by whom
    sums: Sums
    impacts: tuple[Impact, ...]
    contacts: tuple[Contact, ...]
    books: Books
    budget: Budget
    blocked: tuple[Blocked, ...] = ()
    wear: tuple[Wear, ...] = ()


def together(records: Sequence[CollisionRecord]) -> CollisionRecord:
    """What the parts of a step did, as one."""
    contacts: dict[tuple[str, str], Contact] = {}
    for contact in (contact for record in records for contact in record.contacts):
        pair = contact.body_a, contact.body_b
        before = contacts.get(pair, Contact(*pair, np.zeros(3), 0))
        held, count = before.held + contact.held, before.count + contact.count
        contacts[pair] = Contact(*pair, before.impulse + contact.impulse, count, held)
    books = Books()
    for part in (record.books for record in records):
        books.momentum = max(books.momentum, part.momentum)
        books.angular_momentum = max(books.angular_momentum, part.angular_momentum)
        books.energy = max(books.energy, part.energy)
        books.impacts += part.impacts
        books.rest_energy += part.rest_energy
        books.shift_work += part.shift_work
        books.overlaps += part.overlaps
        books.overlap_max = max(books.overlap_max, part.overlap_max)
    budgets = [record.budget for record in records]
    budget = Budget(
        max(budget.limit for budget in budgets),
        sum(budget.used for budget in budgets),
        sum(budget.capped for budget in budgets),
        max(budget.fallback for budget in budgets),
    )
    return CollisionRecord(
        tuple(impact for record in records for impact in record.impacts),
        tuple(contacts[pair] for pair in sorted(contacts)),
        books,
        budget,
        tuple(blocked for record in records for blocked in record.blocked),
        tuple(wear for record in records for wear in record.wear),
    )
