"""What every body is made of: its shape among all shapes of the scene."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.mesh_arrays import MeshArrays

MESH, PLANE = 0, 1  # kinds of shapes


class Solids(NamedTuple):
    """The shapes of all bodies, n rows."""

    meshes: MeshArrays
    kind: np.ndarray  # (n,) int64
    shape: np.ndarray  # (n,) int64 of the mesh among all; -1 for a plane
    normal: np.ndarray  # (n,3) PLANE: unit, body frame, away from the solid side; the plane holds the body's origin
    radius: np.ndarray  # (n,) of the sphere about the body's origin that holds it [m]; inf for a plane
    near: np.ndarray  # (n,) distance from which pairs of triangles get times of their own [m]; inf for a plane
