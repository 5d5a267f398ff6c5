"""A shaded picture of the bodies: what colour each has, where the ground or the water is, and who draws it.

pyvista draws it off-screen when its libraries are there, matplotlib's 3-D axes otherwise. The vtk wheel does not refuse
but crashes the process where libEGL or libGL is missing, so both are looked for first.
"""

from collections.abc import Mapping, Sequence
from ctypes.util import find_library
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.frames import Frames
from comotion.outputs.surface import Surface

SIZE = (1280, 720)  # [pixels]
COLOURS = {"free": "#f1f6fa", "prescribed": "#34404d", "fixed": "#aaa69d"}  # floes light, hull dark, banks grey
WATER = "#3f86b5"
SHADOW = "#1d2b36"
MARK = "#e8541e"  # of impacts
FRAME = "#f0a020"
VIEW_FROM = np.array([-0.75, -1.0, 1.0])  # direction from the middle of the scene to the camera, z up
NEARBY = 0.7, 1.5  # of the size of what moves: a still body's own size, and both together, up to which it is seen
GRAPHICS_LIBRARIES = {"EGL": "libegl1", "GL": "libgl1"}  # library: the Debian package that has it

Box = tuple[NDArray[np.float64], NDArray[np.float64]]  # lowest and highest corner [m]


@dataclass(frozen=True)
class Mark:
    """An impact as it is drawn: where [m], how large (1 for the largest of the run), how long ago (0 now, 1 gone)."""

    point: tuple[float, float, float]
    size: float
    age: float


@dataclass(frozen=True)
class Still:
    """What the picture shows: the surface, each body's motion ("free", "fixed", "prescribed"), the water level [m].

    `seen`, points [m] of shape (n, 3), is where things move; where they are now unless told otherwise. `frames` are
    drawn translucent.
    """

    surface: Surface
    motion: Mapping[str, str]
    water_level: float | None
    seen: NDArray[np.float64] | None = None
    frames: Frames | None = None

    def colour(self, body: str) -> str:
        """Colour of a body by the way it moves."""
        return COLOURS[self.motion.get(body, "free")]

    def moves(self, body: str) -> bool:
        """Whether a body may move."""
        return self.motion.get(body, "free") != "fixed"

    def encloses(self, body: str) -> bool:
        """Whether a body that does not move has all that does inside its box, and would hide it."""
        if self.moves(body):
            return False
        own = next(self.surface.points_of(other) for other in self.surface.bodies if other.name == body)
        inside = self.points_seen
        return bool((own.min(axis=0) < inside.min(axis=0)).all() and (own.max(axis=0) > inside.max(axis=0)).all())

    @property
    def points_seen(self) -> NDArray[np.float64]:
        """Points [m], shape (n, 3), of what moves as far as the view takes it in."""
        return self.moving_points() if self.seen is None else self.seen

    @property
    def view(self) -> NDArray[np.float64]:
        """Points [m], shape (n, 3), that the view takes in: also still bodies that are small and near, or around it."""
        moving = self.points_seen
        low, high = moving.min(axis=0), moving.max(axis=0)
        own, joint = np.linalg.norm(high - low) * np.array(NEARBY)
        taken = [moving]
        for body in self.surface.bodies:
            points = self.surface.points_of(body)
            least, most = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
            near = np.linalg.norm(np.ptp(points, axis=0)) <= own and np.linalg.norm(most - least) <= joint
            if not self.moves(body.name) and (near or self.encloses(body.name)):
                taken.append(points)
        return np.concatenate(taken)

    @property
    def box(self) -> Box:
        """Lowest and highest corner [m] of what is seen, a little enlarged."""
        view = self.view
        low, high = view.min(axis=0), view.max(axis=0)
        margin = 0.05 * float(np.linalg.norm(high - low))
        return low - margin, high + margin

    def moving_points(self) -> NDArray[np.float64]:
        """Points [m], shape (n, 3), of what moves; of everything when nothing moves."""
        moving = [body for body in self.surface.bodies if self.moves(body.name)] or self.surface.bodies
        return np.concatenate([self.surface.points_of(body) for body in moving])

    @property
    def shadow_height(self) -> float:
        """Height [m] on which shadows fall: the water, else the highest fixed top below what moves, else the bottom."""
        if self.water_level is not None:
            return self.water_level
        lowest = {body.name: self.surface.points_of(body)[:, 2].min() for body in self.surface.bodies}
        highest = {body.name: self.surface.points_of(body)[:, 2].max() for body in self.surface.bodies}
        floor = min((z for name, z in lowest.items() if self.moves(name)), default=np.inf)
        slack = 0.01 * float(np.ptp(self.surface.points[:, 2]))  # a body at rest may overlap its floor by a little
        tops = [z for name, z in highest.items() if not self.moves(name) and z <= floor + slack]
        return float(max(tops, default=min(lowest.values())))


class Painter(Protocol):
    """Draws a still again and again, as its surface moves. A context manager."""

    name: str  # of the library

    def paint(self, path: Path, marks: Sequence[Mark] = (), caption: str = "") -> None:
        """Draw the surface as it is now into a PNG file."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


def missing_graphics() -> list[str]:
    """Debian packages that off-screen pyvista needs and that are not there."""
    return [package for library, package in GRAPHICS_LIBRARIES.items() if find_library(library) is None]


def painter(still: Still) -> Painter:
    """The best painter that can be had."""
    if find_spec("pyvista") is not None and not missing_graphics():
        from comotion.outputs.picture_pyvista import ShadedPainter

        return ShadedPainter(still)
    from comotion.outputs.picture_matplotlib import PlainPainter

    return PlainPainter(still)


def draw(path: Path, still: Still) -> str:
    """Draw into a PNG file; returns what drew it."""
    with painter(still) as hand:
        hand.paint(path)
        return hand.name
