"""The heave period of a floating body, measured and by theory."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.fluid import FluidError, FluidScene

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from comotion_mock_cfd.bodies import BodyTable
    from comotion_mock_cfd.cfd_client import StepRecord


@dataclass(frozen=True)
class HeavePeriod:
    """Measured and theoretical period of a body's heave."""

    body: str
    measured: float
    """Mean over whole cycles [s]."""
    theory: float
    """Of the undamped wall-sided body [s]."""
    cycles: int

    @property
    def error(self) -> float:
        """Relative to theory."""
        return self.measured / self.theory - 1.0


@dataclass
class HeaveRecord:
    """Collects the heave of the body named by `[fluid] heave`; `add` is a callback for `CfdClient.run`."""

    scene: FluidScene
    bodies: BodyTable
    times: list[float] = field(default_factory=list)
    speeds: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        heave = self.scene.fluid.heave if self.scene.fluid else None
        if heave is None:
            raise FluidError("fluid.heave: the scene names no body whose heave is to be recorded")
        if heave.body not in self.bodies.names:
            raise FluidError(f"fluid.heave.body: there is no body {heave.body!r}; there are {list(self.bodies.names)}")
        self._heave = heave
        self._row = self.bodies.names.index(heave.body)

    def add(self, record: StepRecord) -> None:
        """Take one step."""
        if record.reply.twists is not None:
            self.times.append(record.time)
            self.speeds.append(float(record.reply.twists[self._row, 2]))

    def period(self) -> HeavePeriod | None:
        """The result; None while the record is shorter than a cycle."""
        measured, cycles = mean_period(self.times, self.speeds)
        if cycles == 0:
            return None
        return HeavePeriod(self._heave.body, measured, heave_period(self.scene.gravity, self._heave.draught), cycles)


def heave_period(gravity: float, draught: float) -> float:
    """Period [s] of undamped heave of a wall-sided body: 2 pi sqrt(T / g), from m = rho A T and stiffness rho g A."""
    return 2.0 * math.pi * math.sqrt(draught / gravity)


def mean_period(times: ArrayLike, speeds: ArrayLike) -> tuple[float, int]:
    """Mean period [s] of an oscillation and the number of whole cycles (0: nan) it was taken over.

    A cycle lies between two lowest points, where the speed goes through zero upwards. Unlike the height's zeros they
    need no rest position; between steps the speed is linear in time, because the force is held.
    """
    t, v = np.asarray(times, dtype=float), np.asarray(speeds, dtype=float)
    low = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    cycles = max(len(low) - 1, 0)
    if cycles == 0:
        return math.nan, 0
    zeros = t[low] - v[low] * (t[low + 1] - t[low]) / (v[low + 1] - v[low])
    return float((zeros[-1] - zeros[0]) / cycles), cycles
