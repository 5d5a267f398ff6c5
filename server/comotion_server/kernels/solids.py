"""What every body is made of: its shape among all shapes of the scene."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.mesh_arrays import MeshArrays

MESH, PLANE, SPHERE, CAPSULE, CYLINDER, PIPE = 0, 1, 2, 3, 4, 5  # kinds of shapes

# of `size`: of a sphere, capsule or cylinder its radius, of these two half their length; of a pipe both radii, half its
# length, and whether its ends are closed
RADIUS, HALF_LENGTH = 0, 1
INNER, OUTER, HALF, CAPS = 0, 1, 2, 3


class Solids(NamedTuple):
    """The shapes of all bodies, n rows. What is None in a scene is not compiled for it (`by_shapes`)."""

    meshes: MeshArrays | None  # None: no body is one
    curves: np.ndarray | None  # int64 rows of bodies whose contact times have no closed form; None: there are none
    kind: np.ndarray  # (n,) int64
    shape: np.ndarray  # (n,) int64 of the mesh among all; -1 for what is none
    normal: np.ndarray  # (n,3) PLANE: unit, body frame, away from the solid side; the plane holds the body's origin
    radius: np.ndarray  # (n,) of the sphere about the body's origin that holds it [m]; inf for a plane
    near: np.ndarray  # (n,) distance from which pairs of triangles get times of their own [m]; inf for what is no mesh
    size: np.ndarray  # (n,4) lengths of a curved shape [m]
    axis: np.ndarray  # (n,3) of a capsule, cylinder or pipe: unit, body frame


@lean_jit
def are_flat(solids, a, b):
    """Whether two bodies are meshes and planes."""
    return solids.kind[a] <= PLANE and solids.kind[b] <= PLANE
