"""What every body is made of: its shape among all shapes of the scene."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.curved_kinds import (
    CAPS,
    CAPSULE,
    CYLINDER,
    HALF,
    HALF_LENGTH,
    INNER,
    MESH,
    OUTER,
    PIPE,
    PLANE,
    RADIUS,
    SPHERE,
)
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.mesh_arrays import MeshArrays

__all__ = [
    "CAPS",
    "CAPSULE",
    "CYLINDER",
    "HALF",
    "HALF_LENGTH",
    "INNER",
    "MESH",
    "OUTER",
    "PIPE",
    "PLANE",
    "RADIUS",
    "SPHERE",
    "Solids",
    "are_flat",
]


class Solids(NamedTuple):
    """The shapes of all bodies, n rows. What is None in a scene is not compiled for it (`by_shapes`)."""

    meshes: MeshArrays | None  # None: no body is one
    kind: np.ndarray  # (n,) int64
    shape: np.ndarray  # (n,) int64 of the mesh among all; -1 for what is none
    normal: np.ndarray  # (n,3) PLANE: unit, body frame, away from the solid side; the plane holds the body's origin
    radius: np.ndarray  # (n,) of the sphere about the body's origin that holds it [m]; inf for a plane
    near: np.ndarray  # (n,) distance from which pairs of triangles get times of their own [m]; inf for what is no mesh
    size: np.ndarray  # (n,4) lengths of a curved shape [m]
    axis: np.ndarray  # (n,3) of a capsule, cylinder or pipe: unit, body frame
    core: np.ndarray | None = None  # (n,) radius about the centre of what a round shape is without its own radius [m]
    has_cylinders: np.ndarray | None = None  # (1,) true; None: no body is one


@lean_jit
def are_flat(solids, a, b):
    """Whether both bodies are meshes or planes."""
    return (solids.kind[a] == MESH or solids.kind[a] == PLANE) and (solids.kind[b] == MESH or solids.kind[b] == PLANE)
