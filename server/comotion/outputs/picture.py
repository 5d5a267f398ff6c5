"""A shaded picture of the bodies: what colour each has, where the ground or the water is, and who draws it.

pyvista draws it off-screen when its libraries are there, matplotlib's 3-D axes otherwise. The vtk wheel does not refuse
but crashes the process where libEGL or libGL is missing, so both are looked for first.
"""

from collections.abc import Mapping
from ctypes.util import find_library
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.surface import Surface

SIZE = (1280, 720)  # [pixels]
COLOURS = {"free": "#eef4f8", "prescribed": "#37424f", "fixed": "#a8a49c"}  # floes light, hull dark, banks grey
WATER = "#3f86b5"
SHADOW = "#1d2b36"
VIEW_FROM = np.array([-0.75, -1.0, 0.62])  # direction from the middle of the scene to the camera, z up
GRAPHICS_LIBRARIES = {"EGL": "libegl1", "GL": "libgl1"}  # library: the Debian package that has it


@dataclass(frozen=True)
class Still:
    """What the picture shows: the surface, each body's motion ("free", "fixed", "prescribed"), the water level [m]."""

    surface: Surface
    motion: Mapping[str, str]
    water_level: float | None

    def colour(self, body: str) -> str:
        """Colour of a body by the way it moves."""
        return COLOURS[self.motion.get(body, "free")]

    @property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner [m] of what moves, a little enlarged; of everything when nothing moves."""
        moving = [b for b in self.surface.bodies if self.motion.get(b.name, "free") != "fixed"] or self.surface.bodies
        points = np.concatenate([self.surface.points_of(body) for body in moving])
        low, high = points.min(axis=0), points.max(axis=0)
        margin = 0.05 * float(np.linalg.norm(high - low))
        return low - margin, high + margin

    @property
    def shadow_height(self) -> float:
        """Height [m] on which shadows fall: the water, else the highest fixed top below what moves, else the bottom."""
        if self.water_level is not None:
            return self.water_level
        lowest = {body.name: self.surface.points_of(body)[:, 2].min() for body in self.surface.bodies}
        highest = {body.name: self.surface.points_of(body)[:, 2].max() for body in self.surface.bodies}
        floor = min((z for name, z in lowest.items() if self.motion.get(name, "free") != "fixed"), default=np.inf)
        slack = 0.01 * float(np.ptp(self.surface.points[:, 2]))  # a body at rest may overlap its floor by a little
        tops = [z for name, z in highest.items() if self.motion.get(name) == "fixed" and z <= floor + slack]
        return float(max(tops, default=min(lowest.values())))


def missing_graphics() -> list[str]:
    """Debian packages that off-screen pyvista needs and that are not there."""
    return [package for library, package in GRAPHICS_LIBRARIES.items() if find_library(library) is None]


def draw(path: Path, still: Still) -> str:
    """Draw into a PNG file; returns what drew it."""
    if find_spec("pyvista") is not None and not missing_graphics():
        from comotion.outputs.picture_pyvista import draw_shaded

        draw_shaded(path, still)
        return "pyvista"
    from comotion.outputs.picture_matplotlib import draw_plain

    draw_plain(path, still)
    return "matplotlib"
