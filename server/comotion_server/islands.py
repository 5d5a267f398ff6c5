"""How bodies come to rest on each other, stay, turn and slide, and part (docs/rest.md).

Islands live from one sub-step to the next. At the end of each, or when something hits one, its bodies are landed, the
contacts are found afresh from the geometry, and

  (1) contacts that close are answered: with e = 0 where the bounce would be no higher than `delta`, else as an impact;
  (2) contacts that are pressed together and open no faster than such a bounce are closed;
  (3) contacts that have come off the middle of `delta` are put back there, which takes no momentum;
  (4) the bodies take off on a flight under the contact forces, as far as that flight is true (`held_flight`).

An island whose bodies all stand still sleeps: nothing is done until a force on it changes or somebody comes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from comotion_server.island import Island
from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.event_cluster import gather_about
from comotion_server.kernels.event_queue import set_timer, took_off
from comotion_server.kernels.event_scene import DELTA, Queue, Rules, Scene
from comotion_server.kernels.held_contacts import begin_rows, contacts_of_pairs, eases, move, opening_speeds
from comotion_server.kernels.held_flight import correct, evaluate, new_course, straying, try_flight
from comotion_server.kernels.impact_cluster import BLOCKED, SOLVED, displacements, settle_velocities

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]

TURN = 0.02  # [rad] per sub-step at most; larger: contact forces are less well known on the way
STRAY = 0.125  # of delta: how far a flight may stray from its contacts on the way; above 0.4 they touch
BAND = 0.25  # of delta: how far a held gap may be off its middle before it is put back; above 0.4 it touches or opens
KEEP = 0.1  # of delta: the gap that all others keep when some are put back; below, they touch
ATTEMPTS = 40  # to find the length of a sub-step before it is taken as it is
SHORTEST = 1e-4  # of the first length tried: sub-steps are not made shorter to find where a contact parts
STEADY = 1e-12  # of the free acceleration: what is left of less counts as none
STILL = 1e-9  # of the speed of a hop as high as delta: slower bodies stand still
ROUNDING = 1e-13  # of the bodies' speeds: slower opening or closing counts as none
PASSES = 50  # of impacts and closings at one time; more: the rest is taken with e = 0


@dataclass(slots=True)
class Touching:
    """The contacts of some bodies at one time: c rows."""

    bodies: Rows  # (k,) all of them
    contacts: Contacts
    pair: Rows  # (c,) rows of the queue's pairs
    delta: Array  # (c,) [m]
    restitution: Array  # (c,)

    def of(self, rows: Mask) -> "Touching":
        """Some of the rows."""
        contacts = Contacts(*(np.ascontiguousarray(column[rows]) for column in self.contacts))
        return Touching(self.bodies, contacts, self.pair[rows], self.delta[rows], self.restitution[rows])

    @property
    def count(self) -> int:
        """How many contacts."""
        return len(self.pair)


class Islands:
    """The islands of a world."""

    def __init__(self, scene: Scene, queue: Queue, rules: Rules) -> None:
        self.scene, self.queue, self.rules = scene, queue, rules
        count = len(scene.x)
        self.of_body = np.full(count, -1)
        self.all: dict[int, Island] = {}
        self.held: dict[tuple[int, int], Array] = {}
        self._next = 0
        self._trial = tuple(array.copy() for array in self.state)
        self._answer = np.zeros((count, 3)), np.zeros((count, 3))
        self._free = np.zeros((count, 3)), np.zeros((count, 3))

    @property
    def state(self) -> tuple[Array, ...]:
        """In the order of kernels."""
        scene = self.scene
        return scene.x, scene.v, scene.R, scene.L, scene.w
