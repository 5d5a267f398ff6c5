"""Shapes given by a few lengths whose surface is exactly a closed mesh, about their centre of mass."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mass import MassProperties
from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.triangle_mesh import TriangleMesh

# Corner i of a box lies at (x, y, z) = bits 0, 1, 2 of i; facets counter-clockwise from outside.
BOX_QUADS = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
# Corners 0, 1, 2 of a prism lie below, 3, 4, 5 above; 0-1 is the base, 2 the apex.
PRISM_TRIANGLES = ((0, 2, 1), (3, 4, 5), (0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4), (2, 0, 3), (2, 3, 5))


def box(size: npt.ArrayLike) -> TriangleMesh:
    """A box with edges [m], shape (3,), along x, y, z."""
    edges = _lengths("box size", size, 3)
    corners = np.array([[(i >> axis) & 1 for axis in range(3)] for i in range(8)])
    triangles = [facet for a, b, c, d in BOX_QUADS for facet in ((a, b, c), (a, c, d))]
    return TriangleMesh((corners - 0.5) * edges, np.array(triangles, dtype=np.uint32))


def prism(base: float, height: float, thickness: float) -> TriangleMesh:
    """An isosceles triangle in the x-y plane, base [m] along x, height [m] along y, with a thickness [m] along z."""
    base, height, thickness = _lengths("prism base, height, thickness", (base, height, thickness), 3)
    outline = np.array([[-base / 2, -height / 3], [base / 2, -height / 3], [0.0, 2 * height / 3]])
    vertices = [[x, y, z] for z in (-thickness / 2, thickness / 2) for x, y in outline]
    return TriangleMesh(np.array(vertices), np.array(PRISM_TRIANGLES, dtype=np.uint32))


def box_properties(size: npt.ArrayLike) -> MassProperties:
    """Closed forms for `box`: exact where the sum over facets leaves rounding in the products of inertia."""
    x, y, z = _lengths("box size", size, 3)
    volume = x * y * z
    return _about_axes(volume, (y * y + z * z) / 12, (z * z + x * x) / 12, (x * x + y * y) / 12)


def prism_properties(base: float, height: float, thickness: float) -> MassProperties:
    """Closed forms for `prism`: the isosceles triangle has b2/24 about its axis and h2/18 about the centroid."""
    b, h, t = _lengths("prism base, height, thickness", (base, height, thickness), 3)
    volume = 0.5 * b * h * t
    return _about_axes(volume, h * h / 18 + t * t / 12, b * b / 24 + t * t / 12, h * h / 18 + b * b / 24)


def _about_axes(volume: float, *squared_radii: float) -> MassProperties:
    return MassProperties(float(volume), np.zeros(3), volume * np.diag(squared_radii))


def _lengths(what: str, values: npt.ArrayLike, count: int) -> npt.NDArray[np.float64]:
    lengths = np.asarray(values, dtype=np.float64)
    if lengths.shape != (count,) or not (np.isfinite(lengths).all() and (lengths > 0.0).all()):
        raise MeshError(f"{what} must be {count} finite lengths greater than 0 m; got {lengths.tolist()}")
    return lengths
