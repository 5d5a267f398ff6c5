"""All that `comotion run --out` writes, step by step: the tables always, the rest where its library is installed."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from heapq import nlargest
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.history import History
from comotion.outputs.report import LARGEST, Report
from comotion.outputs.resistance import ContactImpulses, plot_resistance, resistance
from comotion.outputs.stl import StepChoice, StlFiles
from comotion.outputs.surface import Surface
from comotion.outputs.tables import Tables

if TYPE_CHECKING:
    from comotion.outputs.film import Film
    from comotion.outputs.surface_series import ImpactSeries, SurfaceSeries
    from comotion.summary import Summary
    from comotion_mock_cfd.cfd_client import StepRecord
    from comotion_protocol.messages import Impact, OpenReply, StepReply

SERIES_INTERVAL = 0.02  # [s] of simulated time between states of the series: 50 a second play smoothly
TIME_ROUNDING = 1e-9  # [s]: sample times are sums of steps
INSTALL = "pip install 'comotion[view]'"

Array = NDArray[np.float64]
Show = Callable[[int, int], None]


@dataclass(frozen=True)
class Subject:
    """What the pictures and plots are about."""

    title: str
    scene: Path  # its file
    motion: dict[str, str]  # how each body moves: "free", "fixed" or "prescribed"
    water_level: float | None  # [m]
    resistance_of: str | None  # body
    window: float  # [s] of the resistance
    frame_interval: float | None  # [s] between pictures; none without
    stl: StepChoice | None  # steps whose surfaces are written


class RunOutputs:
    """Writes into one folder. `notes` says what was left out and what to install for it."""

    def __init__(self, folder: Path, opened: "OpenReply", subject: Subject, waited: Callable[[], float]) -> None:
        """Begin with the open reply; `waited` tells how long [s] the client has waited for replies so far."""
        self._folder = folder
        self._subject = subject
        self._opened = opened
        self._surface = Surface(opened.regions, opened.vertices, opened.triangles)
        self._names = [body.name for body in self._surface.bodies]  # the order of the rows of poses (SPEC M12)
        self._tables = Tables(folder)
        self._history = History.into(folder)
        self._waited, self._waited_before = waited, waited()
        self._start = self._time = opened.time
        self._next_state = opened.sample_time
        self.notes: list[str] = []
        self._states: list[tuple[float, Array, Array]] = []  # times [s], poses and scales of the series
        self._sizes: Array = np.empty(0)  # of the bodies in the first of them
        self._placed = self._sizes, self._sizes  # the latest poses and scales
        self._new_impacts: list[Impact] = []
        self._largest: list[Impact] = []
        self._series = self._open_series()
        self._film = self._open_film()
        still = [region.name for region in opened.regions if not region.moves]
        self._stl = StlFiles(folder / "stl", opened.triangles, still) if subject.stl is not None else None
        self._step, self._vertices = opened.step - 1, dict(opened.vertices)
        self._impulses = ContactImpulses(subject.resistance_of) if subject.resistance_of else None
        self._first_position = self._last_position = self._write_state(opened)
        self._write_stl(opened.vertices)

    def add(self, step: "StepRecord") -> None:
        """Write one step."""
        reply, impacts = step.reply, step.reply.impacts or ()
        waited = self._waited()
        self._history.add(step, waited - self._waited_before)
        self._waited_before = waited
        self._tables.write_wrenches(self._time, self._names, step.wrenches)
        self._time, self._step = step.time, step.step
        self._tables.write_impacts(impacts)
        self._tables.write_contacts(step.time, reply.contacts or ())
        self._tables.write_wear(reply.wear or ())
        if self._impulses is not None:
            self._impulses.add(step.time, reply.contacts or ())
        self._largest = nlargest(LARGEST, [*self._largest, *impacts], key=lambda hit: hit.impulse)
        if self._series is not None:
            self._new_impacts += impacts
        if self._film is not None:
            self._film.add_impacts(impacts)
        self._surface.update(reply.vertices)
        self._vertices |= reply.vertices
        self._last_position = self._write_state(reply)
        self._write_stl(reply.vertices)

    def draw(self, summary: "Summary", show: Show = lambda _, __: None) -> None:
        """Draw what is drawn once, at the end, and tell it in the report; `show(done, of)` tells how far it is."""
        if self._stl is not None and self._subject.stl is not None and self._subject.stl.last:
            self._stl.write(self._step, self._time, self._vertices)
        if self._needs("matplotlib", "plots and pictures"):
            self._plot()
            pictures = self._draw_pictures(show)
        else:
            pictures = []
        self._write_glb()
        self._write_report(summary, pictures)

    def write_summary(self, summary: Mapping[str, object]) -> None:
        """Write the summary as JSON."""
        text = json.dumps(summary, indent=2, allow_nan=False)
        (self._folder / "summary.json").write_text(text + "\n", encoding="utf-8")

    def close(self) -> None:
        """Close every file; what was written stays readable."""
        self._tables.close()
        self._history.close()
        for series in self._series or ():
            series.close()

    def _write_state(self, sample: "OpenReply | StepReply") -> Array:
        """Write where everything is; returns the centres of mass [m], shape (bodies, 3), world frame."""
        if sample.poses is None or sample.twists is None:
            raise ValueError("the session was opened without poses or twists; both are written")
        time = sample.sample_time
        self._tables.write_poses(time, self._names, sample.poses, sample.twists)
        if not self._states:
            self._sizes = self._surface.sizes(sample.poses)
        scales = self._surface.scales(sample.poses, self._sizes)
        if self._film is not None:
            self._film.add(time, self._surface.points, sample.poses, scales)
        self._placed = sample.poses, scales
        if time >= self._next_state - TIME_ROUNDING:
            self._states.append((time, sample.poses, scales))
            if self._series is not None:
                surfaces, impacts = self._series
                surfaces.append(time, self._surface.points, sample.poses, sample.twists, scales)
                impacts.append(time, self._new_impacts)
                self._new_impacts = []
            self._next_state = time + SERIES_INTERVAL
        return sample.poses[:, :3]

    def _write_stl(self, vertices: Mapping[str, Array]) -> None:
        if self._stl is not None and self._subject.stl is not None and self._step in self._subject.stl:
            self._stl.write(self._step, self._time, vertices)

    def _open_series(self) -> "tuple[SurfaceSeries, ImpactSeries] | None":
        if not self._needs("h5py", "bodies.vtkhdf and impacts.vtkhdf"):
            return None
        from comotion.outputs.surface_series import ImpactSeries, SurfaceSeries

        path, subject = self._folder / "bodies.vtkhdf", self._subject
        surfaces = SurfaceSeries(path, self._surface, subject.motion, subject.water_level)
        return surfaces, ImpactSeries(self._folder / "impacts.vtkhdf", self._names)

    def _open_film(self) -> "Film | None":
        if self._subject.frame_interval is None or find_spec("matplotlib") is None:
            return None
        from comotion.outputs.film import Film

        return Film(self._subject.frame_interval)

    def _plot(self) -> None:
        if self._impulses is not None and self._impulses.times:
            row = self._names.index(self._impulses.body)
            travel = self._last_position[row] - self._first_position[row]
            curve = resistance(self._impulses, travel, self._start, self._subject.window)
            plot_resistance(self._folder / "resistance.png", self._impulses.body, curve, self._subject.window)
        if self._history.rows:
            self._history.plot_books(self._folder / "books.png")
            self._history.plot_step_time(self._folder / "step_time.png")

    def _draw_pictures(self, show: Show) -> Sequence[Path]:
        """The last state, and the frames with their animation; returns the frames."""
        from comotion.outputs.film import write_gif
        from comotion.outputs.frames import Frames
        from comotion.outputs.picture import Still, draw, missing_graphics

        frames = Frames.of_scene(self._subject.scene, self._names)
        if frames is not None:
            frames.place(*self._placed)
        still = Still(self._surface, self._subject.motion, self._subject.water_level, frames=frames)
        drawn_by = draw(self._folder / "final.png", still)
        pictures: Sequence[Path] = ()
        if self._film is not None:
            pictures = self._film.draw(self._folder / "frames", still, self._subject.title, show)
            write_gif(self._folder / "animation.gif", pictures, self._film.interval)
        if drawn_by != "pyvista" and (packages := missing_graphics()):
            self.notes.append(f"pictures are drawn plainly: pyvista needs {' and '.join(packages)} (apt install)")
        return pictures

    def _write_glb(self) -> None:
        from comotion.outputs.body_shapes import body_shapes
        from comotion.outputs.gltf import write_glb

        start = Surface(self._opened.regions, self._opened.vertices, self._opened.triangles)
        times, poses, scales = map(np.array, zip(*self._states, strict=True))
        shapes = body_shapes(start, poses[0])
        write_glb(self._folder / "bodies.glb", shapes, self._subject.motion, times, poses, scales)

    def _write_report(self, summary: "Summary", frames: Sequence[Path]) -> None:
        from comotion.outputs.film import STRIP

        chosen = np.unique(np.linspace(0, len(frames) - 1, STRIP).astype(int)) if frames else ()
        Report(
            title=self._subject.title,
            opened=self._opened,
            lines=summary.lines(),
            warnings=[*summary.warnings(), *self.notes],
            motion=self._subject.motion,
            largest=self._largest,
            version=version("comotion"),
            folder=self._folder,
            strip=[frames[index] for index in chosen],
            files=sorted(path.name for path in self._folder.iterdir()),
        ).write(self._folder / "report.html")

    def _needs(self, library: str, files: str) -> bool:
        if find_spec(library) is not None:
            return True
        self.notes.append(f"left out: {files}: {library} is not installed ({INSTALL})")
        return False
