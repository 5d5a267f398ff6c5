"""Pictures by pyvista, off-screen: shaded bodies with feature edges, flat shadows, translucent water and frames.

Everything is a few meshes whose points move: the faces (corners of their own per triangle, so that normals can break at
edges), the edges, the shadows, the frames and their edges. A state costs one update of each, however many
bodies there are.
"""

import os
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from comotion.outputs.camera import VIEW_ANGLE, Camera
from comotion.outputs.overlay import draw_over
from comotion.outputs.picture import FRAME, SHADOW, SIZE, WATER, Mark, Still
from comotion.outputs.shading import Shading

# vtk tries an X server first and warns on standard error when there is none; the variable is read when it is imported.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

pv: Any = import_module("pyvista")

SUN = np.array([0.8, 0.25, -1.0])  # direction of its light; shadows are points moved along it onto one plane
LIFT = 4e-4  # part of the scene's size by which shadows lie above the water, or the two flicker
WATER_REACH = 6.0  # sizes of the scene by which the water goes on around it: beyond the picture's edges
PNG_EFFORT = 3  # of 9: how hard PNG files are pressed; more takes longer than drawing
GLASS = 60  # of 255: opacity of what has everything else inside
FRAME_OPACITY = (0.5, 0.4)  # of faces and edges
TINT = 0.035  # bodies of one colour differ by as much in brightness, so that neighbours are told apart


class ShadedPainter:
    """See `Painter`."""

    name = "pyvista"

    def __init__(self, still: Still) -> None:
        self._surface, self._frames = still.surface, still.frames
        self._camera = Camera.on(still.view)
        self._shading = Shading(still.surface.points, still.surface.triangles)
        size = float(np.linalg.norm(np.subtract(*still.box)))
        self._height = still.shadow_height + LIFT * size
        casts = np.array([still.moves(body.name) for body in still.surface.bodies], dtype=bool)
        self._casting = still.surface.triangles[casts[still.surface.body_of_triangle]]
        self._faces, self._edges, self._shadows = self._meshes(still)
        self._frame_meshes = self._frames_meshes()
        self._plotter = pv.Plotter(off_screen=True, window_size=list(SIZE), lighting="none")
        self._furnish(still)

    def paint(self, path: Path, marks: Sequence[Mark] = (), caption: str = "") -> None:
        """See `Painter`."""
        points = self._surface.points
        self._faces.points = points[self._surface.triangles.ravel()]
        self._faces.point_data["Normals"] = self._shading.normals(points).astype(np.float32)
        self._edges.points = points
        self._shadows.points = self._cast(points)
        self._shadows.faces = _as_cells(self._above(points), 3)
        if self._frames is not None:
            for mesh in self._frame_meshes:
                mesh.points = self._frames.points
        self._plotter.render()
        image = Image.fromarray(self._plotter.screenshot(return_img=True))
        draw_over(image, self._camera, marks, caption).save(path, compress_level=PNG_EFFORT)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._plotter.close()

    def _meshes(self, still: Still) -> tuple[Any, Any, Any]:
        points, triangles = still.surface.points, still.surface.triangles
        faces = pv.PolyData(points[triangles.ravel()], _as_cells(np.arange(triangles.size).reshape(-1, 3), 3))
        faces.point_data["Normals"] = self._shading.normals(points).astype(np.float32)
        faces.point_data.active_normals_name = "Normals"
        faces.cell_data["colour"] = _palette(still)[still.surface.body_of_triangle]
        edges = pv.PolyData(points, lines=_as_cells(self._shading.edges, 2))
        return faces, edges, pv.PolyData(self._cast(points), _as_cells(self._above(points), 3))

    def _frames_meshes(self) -> tuple[Any, ...]:
        """Faces and edges of the frames, if there are any."""
        if self._frames is None:
            return ()
        points, triangles = self._frames.points, self._frames.triangles
        edges = Shading(points, triangles).edges
        return pv.PolyData(points, _as_cells(triangles, 3)), pv.PolyData(points, lines=_as_cells(edges, 2))

    def _cast(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The points moved along the sun's light onto the plane of shadows; what lies below it, straight up."""
        drop = np.maximum(points[:, 2:] - self._height, 0.0)
        flat: NDArray[np.float64] = points - drop * SUN / SUN[2]
        flat[:, 2] = self._height
        return flat

    def _above(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """Triangles that cast a shadow: those that reach above the plane and face the sun, one layer of the two."""
        corners = points[self._casting]
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ SUN < 0.0
        above: NDArray[np.int64] = self._casting[facing & (corners[:, :, 2].max(axis=1) > self._height)]
        return above

    def _furnish(self, still: Still) -> None:
        plotter = self._plotter
        plotter.set_background("#e3eaf0", top="#b4c7d6")
        self._light()
        shine = {"ambient": 0.18, "specular": 0.15, "specular_power": 12}
        faces = plotter.add_mesh(self._faces, scalars="colour", rgb=True, smooth_shading=True, **shine)
        faces.mapper.resolve = "polygon_offset"  # behind the edges, which are in them
        if len(self._shading.edges):
            plotter.add_mesh(self._edges, color="#26323c", line_width=1.0, opacity=0.7, style="wireframe")
        if self._shadows.n_cells:
            plotter.add_mesh(self._shadows, color=SHADOW, opacity=0.3, lighting=False)
        if still.water_level is not None:
            self._add_water(still, still.water_level)
        # Only faces that look away from the camera: behind a body, so that it keeps its colour, and around it.
        for mesh, opacity in zip(self._frame_meshes, FRAME_OPACITY, strict=False):
            plotter.add_mesh(mesh, color=FRAME, opacity=opacity, culling="front", lighting=False, line_width=1.0)
        plotter.camera.view_angle = VIEW_ANGLE
        plotter.camera_position = [self._camera.eye, self._camera.middle, (0.0, 0.0, 1.0)]
        plotter.reset_camera_clipping_range()
        plotter.enable_anti_aliasing("ssaa")

    def _light(self) -> None:
        sun = pv.Light(light_type="scene light", intensity=0.64)
        elevation = np.degrees(np.arctan2(-SUN[2], np.hypot(*SUN[:2])))
        sun.set_direction_angle(elevation, np.degrees(np.arctan2(*-SUN[1::-1])))
        self._plotter.add_light(sun)
        self._plotter.add_light(pv.Light(light_type="headlight", intensity=0.6))

    def _add_water(self, still: Still, level: float) -> None:
        low, high = still.box
        edge = WATER_REACH * float(np.max(high - low))
        low = np.minimum(still.surface.points.min(axis=0), low) - edge
        high = np.maximum(still.surface.points.max(axis=0), high) + edge
        middle = (low + high) / 2
        plane = pv.Plane(center=(middle[0], middle[1], level), i_size=high[0] - low[0], j_size=high[1] - low[1])
        self._plotter.add_mesh(plane, color=WATER, opacity=0.45, specular=0.3, specular_power=30)


def _as_cells(rows: NDArray[np.int64], corners: int) -> NDArray[np.int64]:
    """Rows of points as VTK lists cells: each with its number of corners before it."""
    return np.column_stack([np.full(len(rows), corners), rows]).ravel()


def _palette(still: Still) -> NDArray[np.uint8]:
    """A colour per body, shape (bodies, 4): by the way it moves, in slightly different shades; glass if it encloses."""
    base = np.array([pv.Color(still.colour(body.name)).int_rgb for body in still.surface.bodies], dtype=float)
    step = np.arange(len(base)) * 0.618034 % 1.0  # the golden ratio: neighbours in the list lie far apart
    shades = np.clip(base * (1.0 - TINT * (0.5 + step))[:, None], 0, 255)
    opacity = [GLASS if still.encloses(body.name) else 255 for body in still.surface.bodies]
    colours: NDArray[np.uint8] = np.column_stack([shades, opacity]).astype(np.uint8)
    return colours
