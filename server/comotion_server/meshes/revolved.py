"""Surfaces of revolution as triangles: the vertices that a client gets of a round shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.triangle_mesh import TriangleMesh

if TYPE_CHECKING:
    from collections.abc import Sequence

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def revolved(profiles: Sequence[Floats], segments: int, axis: int) -> TriangleMesh:
    """The surface that lines give as they turn about an axis of the body.

    Args:
        profiles: points (z, rho) [m] of each line, shape (k, 2), outside to the left as z grows; a line begins and ends
            on the axis, or where it began.
        segments: vertices around the axis; points on the axis are one vertex.
        axis: 0, 1 or 2.
    """
    vertices: list[Floats] = []
    triangles: list[Indices] = []
    angles = 2.0 * np.pi * np.arange(segments) / segments
    around = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    count = 0
    for line in profiles:
        rings: list[Indices] = []
        is_loop = bool((line[0] == line[-1]).all())
        for z, rho in line[:-1] if is_loop else line:
            ring = rho * around if rho > 0.0 else np.zeros((1, 2))
            vertices.append(np.column_stack((ring, np.full(len(ring), z))))
            rings.append(np.arange(count, count + len(ring)))
            count += len(ring)
        following = [*rings[1:], rings[0]] if is_loop else rings[1:]
        triangles += [_band(low, high) for low, high in zip(rings, following, strict=False)]
    turned = np.roll(np.vstack(vertices), axis - 2, axis=1)
    return TriangleMesh(turned, np.vstack(triangles).astype(np.uint32))


def _band(low: Indices, high: Indices) -> Indices:
    """Triangles between two rings of vertices, of which one may be a single vertex."""
    next_low, next_high = np.roll(low, -1), np.roll(high, -1)
    if len(low) == 1:
        return np.column_stack((np.full(len(high), low[0]), next_high, high))
    lower = np.column_stack((low, next_low, high if len(high) > 1 else np.full(len(low), high[0])))
    if len(high) == 1:
        return lower
    return np.vstack((lower, np.column_stack((next_low, next_high, high))))
