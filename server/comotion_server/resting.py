"""What the parts of coming to rest share (docs/rest.md): the scene, its queue, the step's forces, the record."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from comotion_server.island import Island
from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.event_scene import Queue, Rules, Scene
from comotion_server.kernels.held_contacts import begin_rows
from comotion_server.kernels.impact_cluster import BLOCKED
from comotion_server.touching import RestRecord, meetings_of

if TYPE_CHECKING:
    from comotion_server.meetings import Meeting

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Resting:
    """Of one world: n bodies."""

    def __init__(self, scene: Scene, queue: Queue, rules: Rules) -> None:
        self.scene, self.queue, self.rules = scene, queue, rules
        count = len(scene.x)
        self.force, self.torque, self.acceleration = (np.zeros((count, 3)) for _ in range(3))  # of the step, free
        self.record = RestRecord()
        self.blocked: list[Meeting] = []  # contacts that exclude each other, approaching by motion that is given
        self.trial = tuple(array.copy() for array in self.state)
        self.room = np.zeros((count, 3)), np.zeros((count, 3))

    @property
    def state(self) -> tuple[Array, ...]:
        """In the order of kernels: x, v, R, L, w."""
        scene = self.scene
        return scene.x, scene.v, scene.R, scene.L, scene.w

    @property
    def free(self) -> tuple[Array, Array]:
        """Forces [N] and torques [N m] (n,3) beside those of contacts."""
        return self.force, self.torque

    def take_forces(self) -> Mask:
        """Takes the step's forces from the flights that all bodies have begun: whose have changed (n,)."""
        flights, ease = self.scene.flights, self.scene.bodies.inverse_mass
        force = np.divide(flights.acceleration, ease, out=np.zeros_like(ease), where=ease > 0.0)
        changed: Mask = (force != self.force).any(axis=1) | (flights.torque != self.torque).any(axis=1)
        self.force, self.torque, self.acceleration = force, flights.torque.copy(), flights.acceleration.copy()
        return changed

    def begin(self, rows: Rows, acceleration: Array, torque: Array, time: float) -> None:
        """Begins flights of some bodies from where they are at a local time."""
        begin_rows(self.scene.flights, self.scene.bodies, rows, acceleration, torque, time, self.state)

    def possible(self, status: int, contacts: Contacts, certificate: Mask) -> bool:
        """Whether there is a motion; otherwise the contacts that exclude each other are noted."""
        if status == BLOCKED:
            given = ~self.scene.bodies.reacts
            self.blocked = meetings_of(self.scene, contacts, np.flatnonzero(certificate), given)
        return status != BLOCKED

    def others_stand(self, island: Island) -> bool:
        """Whether what an island stands on does not move."""
        return not (self.scene.v[island.others].any() or self.scene.w[island.others].any())
