"""Hydrostatic pressure on the wetted facets, integrated exactly and lumped to the vertices.

The force on vertex i of a facet is -n times the integral of p N_i over its wetted part, p = rho g (level - z), N_i the
facet's linear shape function. The product of two linear functions over a triangle of area A is, exactly,

    integral f h dA = A / 12 (sum f sum h + sum f h)      (sums over the three corners; the mid-edge rule says the same)

(Zienkiewicz, Taylor, Zhu, *The Finite Element Method: Its Basis and Fundamentals*, integrals of area coordinates), so
force and moment of a closed body are those of Archimedes to rounding, whatever the water line cuts.
"""

from __future__ import annotations

import numpy as np

from comotion_mock_cfd.nodal import add_to_vertices
from comotion_mock_cfd.water_line import Floats, Indices, WetSurface, wet_surface


def hydrostatic_forces(vertices: Floats, triangles: Indices, density: float, gravity: float, level: float) -> Floats:
    """Nodal forces [N], shape (n, 3), world, of still water below z = level; vacuum above (P22).

    Args:
        vertices: positions [m], shape (n, 3), world, z up.
        triangles: vertex indices, shape (m, 3), counter-clockwise seen from outside.
        density: of the water [kg/m3].
        gravity: magnitude of gravity [m/s2], which acts along -z.
        level: height of the free surface [m].
    """
    nodal = np.zeros_like(vertices)
    add_hydrostatics(nodal, wet_surface(vertices, triangles, level), density * gravity)
    return nodal


def add_hydrostatics(nodal: Floats, wet: WetSurface, specific_weight: float) -> None:
    """Add the pressure forces [N] of water of the given specific weight [N/m3] to nodal forces (n, 3), in place."""
    # Depth, not height, is what enters: it was formed near the level and keeps its digits.
    pressure = specific_weight * wet.depth[wet.whole]
    weights = pressure + pressure.sum(axis=1, keepdims=True)
    add_to_vertices(nodal, wet.whole, weights[:, :, None] * (wet.whole_area / -12.0)[:, None, :])

    pressure = specific_weight * np.einsum("pci,pi->pc", wet.shape, wet.depth[wet.cut])
    weights = np.einsum("pc,pci->pi", pressure, wet.shape)
    weights += pressure.sum(axis=1, keepdims=True) * wet.shape.sum(axis=1)
    add_to_vertices(nodal, wet.cut, weights[:, :, None] * (wet.cut_area / -12.0)[:, None, :])
