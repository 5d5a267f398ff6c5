"""The contacts of a cluster at one time, and what is to become of each: it closes, is closed, is held, or parts."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.event_scene import Scene
from comotion_server.meetings import Meeting

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]
Pair = tuple[int, int]

ROUNDING = 1e-13  # of the bodies' speeds: slower opening or closing counts as none


@dataclass(slots=True, eq=False)
class Touching:
    """Contacts of some bodies: c rows."""

    members: Rows  # (k,) the reacting bodies, ascending
    contacts: Contacts
    pair: Rows  # (c,) rows of the queue's pairs
    delta: Array  # (c,) gap up to which bodies touch [m]
    elastic: Mask  # (c,) restitution 1: never brought to rest
    friction: Array  # (c,) coefficients
    known: Mask  # (c,) of pairs that were held already

    @property
    def count(self) -> int:
        """How many contacts."""
        return len(self.pair)

    @property
    def bodies(self) -> Rows:
        """All bodies that take part, ascending."""
        return np.union1d(self.members, self.contacts.bodies.ravel())

    @property
    def near(self) -> Mask:
        """Which are within delta (c,); others may come so soon."""
        within: Mask = self.contacts.gap <= self.delta
        return within

    def of(self, rows: Mask) -> "Touching":
        """Some of the contacts."""
        contacts = Contacts(*(np.ascontiguousarray(column[rows]) for column in self.contacts))
        return Touching(
            self.members,
            contacts,
            self.pair[rows],
            self.delta[rows],
            self.elastic[rows],
            self.friction[rows],
            self.known[rows],
        )

    def joined(self, other: "Touching") -> "Touching":
        """These contacts, then others of the same members."""
        columns = zip(self.contacts, other.contacts, strict=True)
        return Touching(
            self.members,
            Contacts(*(np.concatenate(both) for both in columns)),
            np.concatenate([self.pair, other.pair]),
            np.concatenate([self.delta, other.delta]),
            np.concatenate([self.elastic, other.elastic]),
            np.concatenate([self.friction, other.friction]),
            np.concatenate([self.known, other.known]),
        )

    def copy(self) -> Contacts:
        """The contacts, to be moved on."""
        return Contacts(*(column.copy() for column in self.contacts))

    def totals(self, values: Array) -> Array:
        """The sum over all contacts of the same pair, for each contact (c,)."""
        _, where = np.unique(self.pair, return_inverse=True)
        sums: Array = np.bincount(where, weights=values, minlength=1).astype(np.float64)
        return sums[where]


def approach_of(scene: Scene, contacts: Contacts, rows: Rows, movers: Mask) -> Array:
    """Speeds (k,) [m/s] at which contacts `rows` close by the motion of the bodies that `movers` (n,) marks."""
    closing = np.zeros(len(rows))
    for side, arms in enumerate((contacts.arm_a, contacts.arm_b)):
        j = contacts.bodies[rows, side]
        velocity = movers[j, None] * (scene.v[j] + np.cross(scene.w[j], arms[rows]))
        closing += (1.0 - 2.0 * side) * np.einsum("ij,ij->i", velocity, contacts.normal[rows])
    return closing


def meetings_of(scene: Scene, contacts: Contacts, rows: Rows, movers: Mask) -> list[Meeting]:
    """Contacts `rows` of bodies at their states; approaching by the motion of bodies that `movers` marks."""
    found = []
    for i, approach in zip(rows.tolist(), approach_of(scene, contacts, rows, movers).tolist(), strict=True):
        a, b = contacts.bodies[i].tolist()
        found.append(Meeting(a, b, scene.x[b] + contacts.arm_b[i], contacts.normal[i].copy(), approach))
    return found


@dataclass(slots=True, eq=False)
class Judgement:
    """What is found of each contact (c,)."""

    speed: Array  # at which it opens [m/s]
    pressing: Array  # acceleration that presses it [m/s2]
    force: Array  # that would hold it [N]
    inside: Mask  # it neither closes nor opens, or shall not
    closing: Mask
    hard: Mask  # closing, and of a pair that bounces higher than delta
    stick: Mask  # pressed, and opening less than such a bounce


@dataclass(slots=True, eq=False)
class SoftImpact:
    """A contact that closed with e = 0 to come to rest."""

    time: float  # local [s]
    pair: Pair
    point: Array  # (3,) on b [m]
    normal: Array  # (3,)
    impulse: float  # [N s]
    approach: float  # [m/s]


@dataclass(slots=True, eq=False)
class RestRecord:
    """What islands did in a step."""

    held: dict[Pair, Array] = field(default_factory=dict)  # impulses (3,) on b [N s]
    soft: list[SoftImpact] = field(default_factory=list)
    rest_energy: float = 0.0  # [J]
    shift_work: float = 0.0  # [J]
    fallback: float = 0.0  # [s] of body time that was taken by time-stepping

    def add_held(self, pairs: Rows, impulses: Array) -> None:
        """Adds impulses (c,3) of contacts between `pairs` (c,2)."""
        for (a, b), impulse in zip(pairs.tolist(), impulses, strict=True):
            self.held[a, b] = self.held.get((a, b), np.zeros(3)) + impulse
