"""Resistance on one body: contact impulse per stated window of time.

Contact forces are impulses, so a curve of force against time exists only for a stated window: the impulse that fell
into the window over its length. Its mean does not depend on the window; its peaks do. The sign is that of a resistance:
positive against the direction of travel, which is from the body's first to its last centre of mass.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from comotion_protocol.messages import Contact


@dataclass
class ContactImpulses:
    """Impulses [N s] of contacts on one body, step by step."""

    body: str
    times: list[float] = field(default_factory=list)
    impulses: list[NDArray[np.float64]] = field(default_factory=list)

    def add(self, time: float, contacts: Iterable["Contact"]) -> None:
        """Take the contacts of the step that ends at a time [s]."""
        total = np.zeros(3)
        for pair in contacts:
            if pair.body_b == self.body:
                total += pair.impulse
            elif pair.body_a == self.body:
                total -= pair.impulse
        self.times.append(time)
        self.impulses.append(total)


@dataclass(frozen=True)
class Resistance:
    """Mean contact force against the direction of travel in each window: `edges` (n+1,) [s], `force` (n,) [N]."""

    edges: NDArray[np.float64]
    force: NDArray[np.float64]

    @property
    def mean(self) -> float:
        """Mean force over all windows [N]: total impulse over total time, whatever the window."""
        lengths = np.diff(self.edges)
        return float(self.force @ lengths / lengths.sum())


def resistance(impulses: ContactImpulses, travel: NDArray[np.float64], start: float, window: float) -> Resistance:
    """Resistance per window [s], from `start` [s] on; `travel` (3,) [m] gives the direction (x where there is none).

    The last window ends with the run and is as long as what is left, so that no impulse is lost.
    """
    length = float(np.linalg.norm(travel))
    direction = travel / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
    times = np.array(impulses.times)
    against = -np.array(impulses.impulses) @ direction
    count = max(int(np.ceil((times[-1] - start) / window - 1e-9)), 1)  # 1e-9: a whole number, but for rounding
    edges = np.array([*(start + window * index for index in range(count)), times[-1]], dtype=np.float64)
    # A step belongs to the window in which it ends; 1e-9 windows absorb the rounding of summed steps.
    place = np.clip(np.ceil((times - start) / window - 1e-9).astype(int) - 1, 0, count - 1)
    impulse = np.zeros(count)
    np.add.at(impulse, place, against)
    return Resistance(edges, impulse / np.diff(edges))


def plot_resistance(path: Path, body: str, curve: Resistance, window: float) -> None:
    """Draw the curve as steps, with its mean, into a picture file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.stairs(curve.force, curve.edges, fill=True, color="#9ec3e0")
    axes.stairs(curve.force, curve.edges, color="#1f4e79", label=f"impulse per {window:g} s")
    axes.axhline(curve.mean, color="#b5482a", linestyle="--", label=f"mean of the run: {curve.mean:.4g} N")
    axes.set_title(f"Contact resistance on {body}: impulse per window of {window:g} s")
    axes.set_xlabel("time [s]")
    axes.set_ylabel("force against travel [N]")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=120)
