"""What the service needs of a simulation, and no more; `Simulation` is one."""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class EngineSample(Protocol):
    """Where the bodies are at a time; world frame, SI units."""

    @property
    def time(self) -> float:
        """Since the start of the run [s]."""

    @property
    def vertices(self) -> Mapping[str, Array]:
        """Per region (n, 3) [m]; empty unless asked for."""

    @property
    def velocities(self) -> Mapping[str, Array]:
        """Per region (n, 3) [m/s]; empty unless asked for."""

    @property
    def poses(self) -> Array:
        """Per body (bodies, 7): x y z w qx qy qz."""

    @property
    def twists(self) -> Array:
        """Per body (bodies, 6): velocity [m/s] and angular velocity [rad/s]."""

    @property
    def scales(self) -> Array:
        """Per body (bodies,): size of its surface, relative to that at the start of the run."""


class EngineRegion(Protocol):
    """A surface: welded vertices, triangles, and the bodies' shares of both."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def vertex_count(self) -> int:
        """Welded vertices."""

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """Indices (m, 3) into the vertices."""

    @property
    def moves(self) -> bool:
        """Whether its vertices ever change."""

    @property
    def bodies(self) -> Sequence[Any]:
        """Shares: name, first_vertex, vertex_count."""


class Engine(Protocol):
    """A simulation as the service drives it. A ValueError is its word for input that it cannot use."""

    @property
    def time(self) -> float:
        """Since the start of the run [s]."""

    @property
    def regions(self) -> Sequence[EngineRegion]:
        """The surfaces, in the order of their names."""

    @property
    def plan(self) -> Any:
        """Its `explain()` lists the stages with `stage`, `kept` and `reason`."""

    @property
    def bodies(self) -> Any:
        """Its `names` are the bodies' names, in order."""

    def step(self, dt: float, forces: Mapping[str, Array] | None = None, wrenches: Array | None = None) -> Any:
        """Advance by dt [s] under forces at the vertices marked as sent, or under wrenches."""

    def sample(self, offset: float, *, vertices: bool = True, velocities: bool = False) -> Any:
        """An `EngineSample` of new arrays `offset` [s] ahead; the state is untouched."""

    def mark_sent(self, sample: Any) -> None:
        """From now on forces act at the vertices and centres of this sample."""

    def checkpoint(self) -> Any:
        """Everything that a step changes."""

    def restore(self, checkpoint: Any) -> None:
        """Go back to a checkpoint, as often as wanted."""
