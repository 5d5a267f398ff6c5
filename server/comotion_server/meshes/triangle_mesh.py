"""The one mesh type: a numbered list of vertices and of triangular facets (P4)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mesh_errors import MeshError

LARGEST = 1e15  # [m] of a coordinate; fourth and sixth powers of lengths are formed


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A surface of triangles. Two meshes are equal only if they are the same object: bodies alike share one.

    Attributes:
        vertices: positions [m], shape (n, 3), float64, C order; for a body: about its centre of mass, body frame.
        triangles: indices into `vertices`, shape (m, 3), uint32, C order, counter-clockwise seen from outside.

    The arrays are shared and not to be written to. They keep numpy's write flag, because numba would otherwise
    compile every kernel twice: a read-only array is another type.
    """

    vertices: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.uint32]

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        triangles = np.asarray(self.triangles)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise MeshError(f"vertices must have shape (n, 3); got {vertices.shape}")
        if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
            raise MeshError(f"triangles must be integers of shape (m, 3); got {triangles.dtype} {triangles.shape}")
        if len(triangles) == 0:
            raise MeshError("a mesh needs at least one triangle; got none")
        if not np.isfinite(vertices).all():
            first = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])
            raise MeshError(f"vertices must be finite; vertex {first} is {vertices[first].tolist()}")
        if np.abs(vertices).max() > LARGEST:
            first = int(np.flatnonzero(np.abs(vertices).max(axis=1) > LARGEST)[0])
            raise MeshError(f"vertices must lie within {LARGEST:g} m; vertex {first} is {vertices[first].tolist()}")
        if triangles.min() < 0 or triangles.max() >= len(vertices):
            wrong = triangles.min() if triangles.min() < 0 else triangles.max()
            raise MeshError(f"triangles must refer to vertices 0 to {len(vertices) - 1}; got {wrong}")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", np.ascontiguousarray(triangles, dtype=np.uint32))

    @cached_property
    def size(self) -> float:
        """Diameter [m] of the smallest sphere about the origin that holds all vertices."""
        return 2.0 * float(np.sqrt(np.einsum("ij,ij->i", self.vertices, self.vertices).max()))
