"""All that `comotion run --out` writes, step by step: the tables always, the rest where its library is installed."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.picture import Still, draw, missing_graphics
from comotion.outputs.resistance import ContactImpulses, plot_resistance, resistance
from comotion.outputs.surface import Surface
from comotion.outputs.tables import Tables

if TYPE_CHECKING:
    from comotion.outputs.surface_series import SurfaceSeries
    from comotion_mock_cfd.cfd_client import StepRecord
    from comotion_protocol.messages import OpenReply, StepReply

FRAME_INTERVAL = 0.02  # [s] of simulated time between states of the series: 50 a second play smoothly
TIME_ROUNDING = 1e-9  # [s]: sample times are sums of steps
INSTALL = "pip install 'comotion[view]'"


@dataclass(frozen=True)
class Subject:
    """What the plot and the picture are about."""

    motion: Mapping[str, str]  # how each body moves: "free", "fixed" or "prescribed"
    water_level: float | None  # [m]
    resistance_of: str | None  # body
    window: float  # [s] of the resistance


class RunOutputs:
    """Writes into one folder. `notes` says what was left out and what to install for it."""

    def __init__(self, folder: Path, opened: "OpenReply", subject: Subject) -> None:
        self._folder = folder
        self._subject = subject
        self._surface = Surface(opened.regions, opened.vertices, opened.triangles)
        self._names = [body.name for body in self._surface.bodies]  # the order of the rows of poses (SPEC M6)
        self._tables = Tables(folder)
        self._start = self._time = opened.time
        self._next_frame = opened.sample_time
        self.notes: list[str] = []
        self._series = self._open_series()
        self._impulses = ContactImpulses(subject.resistance_of) if subject.resistance_of else None
        self._first_position = self._last_position = self._write_state(opened)

    def add(self, step: "StepRecord") -> None:
        """Write one step."""
        reply = step.reply
        self._tables.write_wrenches(self._time, self._names, step.wrenches)
        self._time = step.time
        self._tables.write_impacts(reply.impacts or ())
        self._tables.write_contacts(step.time, reply.contacts or ())
        if self._impulses is not None:
            self._impulses.add(step.time, reply.contacts or ())
        self._surface.update(reply.vertices)
        self._last_position = self._write_state(reply)

    def draw(self) -> None:
        """Draw what is drawn once, at the end."""
        if self._impulses is not None and self._needs("matplotlib", "resistance.png"):
            self._plot_resistance(self._impulses)
        if self._needs("matplotlib", "final.png"):
            still = Still(self._surface, self._subject.motion, self._subject.water_level)
            drawn_by = draw(self._folder / "final.png", still)
            if drawn_by != "pyvista" and (packages := missing_graphics()):
                self.notes.append(f"final.png is drawn plainly: pyvista needs {' and '.join(packages)} (apt install)")

    def write_summary(self, summary: Mapping[str, Any]) -> None:
        """Write the summary as JSON."""
        text = json.dumps(summary, indent=2, allow_nan=False)
        (self._folder / "summary.json").write_text(text + "\n", encoding="utf-8")

    def close(self) -> None:
        """Close every file; what was written stays readable."""
        self._tables.close()
        if self._series is not None:
            self._series.close()

    def _write_state(self, sample: "OpenReply | StepReply") -> NDArray[np.float64]:
        """Write where everything is; returns the centres of mass [m], shape (bodies, 3), world frame."""
        if sample.poses is None or sample.twists is None:
            raise ValueError("the session was opened without poses or twists; both are written")
        self._tables.write_poses(sample.sample_time, self._names, sample.poses, sample.twists)
        if self._series is not None and sample.sample_time >= self._next_frame - TIME_ROUNDING:
            self._series.append(sample.sample_time, self._surface.points)
            self._next_frame = sample.sample_time + FRAME_INTERVAL
        return sample.poses[:, :3]

    def _open_series(self) -> "SurfaceSeries | None":
        if not self._needs("h5py", "bodies.vtkhdf"):
            return None
        from comotion.outputs.surface_series import SurfaceSeries

        surface = self._surface
        path = self._folder / "bodies.vtkhdf"
        return SurfaceSeries(path, surface.triangles, surface.body_of_triangle, len(surface.points))

    def _plot_resistance(self, impulses: ContactImpulses) -> None:
        row = self._names.index(impulses.body)
        travel = self._last_position[row] - self._first_position[row]
        curve = resistance(impulses, travel, self._start, self._subject.window)
        plot_resistance(self._folder / "resistance.png", impulses.body, curve, self._subject.window)

    def _needs(self, library: str, file: str) -> bool:
        if find_spec(library) is not None:
            return True
        self.notes.append(f"{file} is left out: {library} is not installed ({INSTALL})")
        return False
