"""The picture by matplotlib's 3-D axes, where pyvista cannot draw: faces shaded by their angle to the light."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]
from numpy.typing import NDArray

from comotion.outputs.picture import FRAME, MARK, SIZE, VIEW_FROM, WATER, Mark, Still

DPI = 100
LIGHT = np.array([-0.4, -0.5, 1.0]) / np.linalg.norm([-0.4, -0.5, 1.0])
FRAME_OPACITY = 0.12
AMBIENT = 0.55  # share of the light that reaches faces turned away


class PlainPainter:
    """See `Painter`."""

    name = "matplotlib"

    def __init__(self, still: Still) -> None:
        self._still = still

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def paint(self, path: Path, marks: Sequence[Mark] = (), caption: str = "") -> None:
        """See `Painter`."""
        still = self._still
        figure = Figure(figsize=(SIZE[0] / DPI, SIZE[1] / DPI), dpi=DPI)
        FigureCanvasAgg(figure)
        axes: Any = figure.add_axes((0, 0, 1, 1), projection="3d")
        low, high = still.box
        if still.water_level is not None:
            _add_water(axes, low, high, still.water_level)
        _add_faces(axes, still)
        if still.frames is not None:
            sheet = still.frames.points[still.frames.triangles]
            axes.add_collection3d(Poly3DCollection(sheet, facecolors=FRAME, alpha=FRAME_OPACITY, clip_on=False))
        for mark in marks:
            size = 30 + 300 * mark.size
            axes.scatter(*mark.point, s=size, facecolors="none", edgecolors=MARK, alpha=1 - mark.age, depthshade=False)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect(high - low, zoom=1.3)
        across = np.linalg.norm(VIEW_FROM[:2])
        axes.view_init(
            elev=np.degrees(np.arctan2(VIEW_FROM[2], across)), azim=np.degrees(np.arctan2(*VIEW_FROM[1::-1]))
        )
        axes.set_axis_off()
        figure.text(0.02, 0.95, caption, fontsize=14, color="#26323c")
        figure.savefig(path)


def _add_faces(axes: Any, still: Still) -> None:
    """Only faces that look at the camera: matplotlib sorts by a face's middle, so hidden ones would shine through."""
    corners = still.surface.points[still.surface.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0.0, lengths, 1.0)
    palette = np.array([to_rgb(still.colour(body.name)) for body in still.surface.bodies])
    shade = AMBIENT + (1 - AMBIENT) * np.clip(normals @ LIGHT, 0.0, 1.0)
    colours = palette[still.surface.body_of_triangle] * shade[:, None]
    seen = normals @ VIEW_FROM > 0.0
    axes.add_collection3d(Poly3DCollection(corners[seen], facecolors=colours[seen], clip_on=False))


def _add_water(axes: Any, low: NDArray[np.float64], high: NDArray[np.float64], level: float) -> None:
    sheet = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]
    corners = [[*corner, level] for corner in sheet]
    axes.add_collection3d(Poly3DCollection([corners], facecolors=WATER, alpha=0.3, clip_on=False))
