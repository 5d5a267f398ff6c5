"""What a queue comes back with when bodies have to change before the step can go on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Meeting:
    """A contact of two bodies, by their rows."""

    a: int
    b: int
    point: Array  # (3,) on b [m]
    normal: Array  # (3,) unit, from a to b
    approach: float  # speed at which it closes; where bodies are pinched, by motion that is given alone [m/s]
    depth: float = 0.0  # by which the bodies overlap [m]
