"""Prescribed motion as a table of poses over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from comotion_server.quaternions import quaternion_of, quaternion_product, rotation_vector

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PoseTable:
    """Poses at strictly increasing times: at rest before the first, constant twist between two, at rest after the last.

    Attributes:
        times: [s], shape (k,).
        positions: of the centre of mass [m], shape (k, 3), world frame.
        quaternions: (w, x, y, z), body to world, unit length, shape (k, 4), neighbours on the same side (dot >= 0).
    """

    times: Floats
    positions: Floats
    quaternions: Floats

    def twist(self, time: float) -> tuple[Floats, Floats]:
        """Velocity [m/s] and angular velocity [rad/s] just after `time` [s], each of shape (3,), world frame."""
        row = int(np.searchsorted(self.times, time, side="right")) - 1
        if row < 0 or row + 1 >= len(self.times):
            return np.zeros(3), np.zeros(3)
        duration = self.times[row + 1] - self.times[row]
        velocity = (self.positions[row + 1] - self.positions[row]) / duration
        turn = quaternion_product(self.quaternions[row + 1], self.quaternions[row] * (1.0, -1.0, -1.0, -1.0))
        return velocity, rotation_vector(turn) / duration

    def pose(self, time: float) -> tuple[Floats, Floats]:
        """Position [m], shape (3,), and unit quaternion (w, x, y, z) at `time` [s]."""
        row = min(max(int(np.searchsorted(self.times, time, side="right")) - 1, 0), len(self.times) - 1)
        velocity, angular_velocity = self.twist(time)
        elapsed = time - self.times[row]
        turn = quaternion_of(angular_velocity * elapsed)
        return self.positions[row] + velocity * elapsed, quaternion_product(turn, self.quaternions[row])
