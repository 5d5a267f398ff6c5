"""All forces of the fluid on one region's surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.drag import add_drag
from comotion_mock_cfd.hydrostatics import add_hydrostatics
from comotion_mock_cfd.water_line import Floats, Indices, wet_surface

if TYPE_CHECKING:
    from comotion_mock_cfd.fluid import FluidScene


def fluid_forces(scene: FluidScene, vertices: Floats, velocities: Floats, triangles: Indices) -> Floats:
    """Pressure and drag [N], shape (n, 3), world, on a surface; added mass is not among them.

    Args:
        scene: fluid and gravity; vacuum gives zeros.
        vertices: positions [m], shape (n, 3), world.
        velocities: of the vertices [m/s], shape (n, 3), world.
        triangles: vertex indices, shape (m, 3), counter-clockwise seen from outside.
    """
    nodal = np.zeros_like(vertices)
    fluid = scene.fluid
    if fluid is None:
        return nodal
    wet = wet_surface(vertices, triangles, fluid.level)
    add_hydrostatics(nodal, wet, fluid.density * scene.gravity)
    if fluid.drag.form > 0.0 or fluid.drag.friction > 0.0:
        add_drag(nodal, wet, velocities - fluid.current, fluid.density, fluid.drag.form, fluid.drag.friction)
    return nodal
