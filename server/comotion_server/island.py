"""Bodies in held contact: how they come to rest on each other, stay, turn and slide, and part (docs/rest.md).

An island is a set of reacting bodies that loaded contacts join. It lives from one sub-step to the next: at the end of
each, or when something hits it, its bodies are landed, the contacts are found afresh from the geometry, and

  (1) contacts that close are answered: with e = 0 where the bounce would be no higher than `delta`, else as an impact;
  (2) contacts that are pressed together and open no faster than such a bounce are closed;
  (3) contacts that have come off the middle of `delta` are put back there, which takes no momentum;
  (4) the bodies take off on a flight under the contact forces, as far as that flight is true (`held_flight`).

An island whose bodies all stand still sleeps: nothing is done until a force on it changes or somebody comes.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.held_flight import Course

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(slots=True, eq=False)
class Island:
    """Bodies on a flight under contact forces."""

    members: Rows  # (k,) reacting bodies, ascending
    touched: Rows  # they and all they touch
    contacts: Contacts  # (c,) at the beginning
    course: Course | None  # None: by time-stepping, at constant velocities
    begin: float  # local time [s]
    end: float
    push: Array  # (c,3) of a body asleep or of time-stepping: impulse per second on b [N]
    asleep: bool = False
    change: tuple[Array, Array] | None = None  # (k,3) of v and L by the end of a step of time-stepping
    others: Rows = field(init=False)  # that it touches, but which are no members

    def __post_init__(self) -> None:
        self.others = np.setdiff1d(self.touched, self.members)

    def weights(self, time: float) -> Array:
        """What each stage (4,) counts for the velocities gained until `time` [s]: dense output of third order."""
        passed = time - self.begin
        h = self.end - self.begin
        s = passed / h
        middle = h * s * s * (1.0 - s * (2.0 / 3.0))
        last = h * s * s * (s * (2.0 / 3.0) - 0.5)
        return np.array([passed - 2.0 * middle - last, middle, middle, last])

    def gains(self, time: float) -> tuple[Array, Array]:
        """What velocities and angular momenta (k,3) lack on the flight at `time` [s]."""
        nothing = np.zeros((len(self.members), 3)), np.zeros((len(self.members), 3))
        if self.asleep:
            return nothing
        if self.change is not None:
            share = (time - self.end) / (self.end - self.begin)
            return share * self.change[0], share * self.change[1]
        if self.course is None:
            return nothing
        weights = self.weights(time) - (time - self.begin) * np.array([1.0, 1.0, 1.0, 0.0]) / 3.0
        return np.tensordot(weights, self.course.acceleration, 1), np.tensordot(weights, self.course.torque, 1)

    def impulses(self, time: float) -> Array:
        """Impulse (c,3) of each contact on its body b until `time` [N s]."""
        if self.course is None or self.asleep:
            return (time - self.begin) * self.push
        impulses: Array = np.einsum("s,sc,sci->ci", self.weights(time), self.course.force, self.course.normal)
        return impulses
