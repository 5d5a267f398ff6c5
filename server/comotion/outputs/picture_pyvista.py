"""The picture by pyvista, off-screen: shaded bodies with feature edges, flat shadows, translucent water."""

import os
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from comotion.outputs.picture import SHADOW, SIZE, VIEW_FROM, WATER, Still

# vtk tries an X server first and warns on standard error when there is none; the variable is read when it is imported.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

pv: Any = import_module("pyvista")

VIEW_ANGLE = 30.0  # [degrees], of the picture's height
FEATURE_ANGLE = 30.0  # [degrees]: edges sharper than this are drawn
SUN = np.array([0.8, 0.25, -1.0])  # direction of its light; shadows are points moved along it onto one plane
LIFT = 1e-4  # part of the scene's size by which shadows lie above the water, or the two flicker


def draw_shaded(path: Path, still: Still) -> None:
    """Draw into a PNG file."""
    plotter = pv.Plotter(off_screen=True, window_size=list(SIZE), lighting="none")
    try:
        plotter.set_background("#f7f9fb", top="#c9d8e4")
        _add_lights(plotter)
        _add_bodies(plotter, still)
        if still.water_level is not None:
            _add_water(plotter, still, still.water_level)
        _look(plotter, still)
        plotter.enable_anti_aliasing("ssaa")
        plotter.render()
        plotter.screenshot(str(path))
    finally:
        plotter.close()


def _add_lights(plotter: Any) -> None:
    sun = pv.Light(light_type="scene light", intensity=0.6)
    sun.set_direction_angle(np.degrees(np.arctan2(-SUN[2], np.hypot(*SUN[:2]))), np.degrees(np.arctan2(*-SUN[1::-1])))
    plotter.add_light(sun)
    plotter.add_light(pv.Light(light_type="headlight", intensity=0.6))


def _add_bodies(plotter: Any, still: Still) -> None:
    low, high = still.box
    height = still.shadow_height + LIFT * float(np.linalg.norm(high - low))
    for index, body in enumerate(still.surface.bodies):
        mesh = pv.PolyData.from_regular_faces(still.surface.points_of(body), still.surface.triangles_of(index))
        plotter.add_mesh(
            mesh, color=still.colour(body.name), smooth_shading=False, ambient=0.15, specular=0.2, specular_power=12
        )
        edges = mesh.extract_feature_edges(FEATURE_ANGLE, non_manifold_edges=False, manifold_edges=False)
        if edges.n_cells:
            plotter.add_mesh(edges, color="#26323c", line_width=1.0, opacity=0.7)
        if still.motion.get(body.name, "free") != "fixed":
            _add_shadow(plotter, mesh, height)


def _add_shadow(plotter: Any, mesh: Any, height: float) -> None:
    """Flatten what lies above the plane z = height [m] onto it along the sun's direction."""
    above = mesh.clip("z", origin=(0.0, 0.0, height), invert=False)
    if above.n_cells == 0:
        return
    above.points -= (above.points[:, 2:] - height) * SUN / SUN[2]
    plotter.add_mesh(above, color=SHADOW, opacity=0.3, lighting=False, culling="back")  # one layer of two


def _add_water(plotter: Any, still: Still, level: float) -> None:
    low, high = still.box
    edge = 1.5 * float(np.max(high - low))
    low = np.minimum(still.surface.points.min(axis=0), low) - edge
    high = np.maximum(still.surface.points.max(axis=0), high) + edge
    middle = (low + high) / 2
    plane = pv.Plane(center=(middle[0], middle[1], level), i_size=high[0] - low[0], j_size=high[1] - low[1])
    plotter.add_mesh(plane, color=WATER, opacity=0.45, specular=0.3, specular_power=30)


def _look(plotter: Any, still: Still) -> None:
    """Look at the box of what moves from as near as shows all eight corners."""
    low, high = still.box
    middle = (low + high) / 2
    away = VIEW_FROM / np.linalg.norm(VIEW_FROM)
    right = np.cross([0.0, 0.0, 1.0], away)
    right /= np.linalg.norm(right)
    corners = np.array(list(product(*zip(low - middle, high - middle, strict=True))))
    slope = np.tan(np.radians(VIEW_ANGLE / 2))
    heights = np.abs(corners @ np.cross(away, right)) / slope
    widths = np.abs(corners @ right) / (slope * SIZE[0] / SIZE[1])
    distance = np.max(np.maximum(heights, widths) + corners @ away)
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.camera_position = [middle + distance * away, middle, (0.0, 0.0, 1.0)]
    plotter.reset_camera_clipping_range()
