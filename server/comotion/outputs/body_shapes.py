"""Each body's surface in its own frame, cut into corners with normals: what a player moves by poses alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.shading import Shading
from comotion.outputs.surface import Surface


@dataclass(frozen=True)
class BodyShape:
    """One body: `corners` [m] and `normals`, shape (3 m, 3), three to a triangle; ends of `edges` [m] (2 k, 3)."""

    name: str
    corners: NDArray[np.float32]
    normals: NDArray[np.float32]
    edges: NDArray[np.float32]


def body_shapes(
    surface: Surface, poses: NDArray[np.float64], scales: NDArray[np.float64] | None = None
) -> list[BodyShape]:
    """The shapes of a surface whose bodies are at poses (bodies, 7), x y z [m], w qx qy qz, without their `scales`."""
    shapes = []
    for row, (body, pose) in enumerate(zip(surface.bodies, poses, strict=True)):
        own = (surface.points_of(body) - pose[:3]) @ rotation(pose[3:])  # R^T of each arm
        if scales is not None:
            own /= scales[row, 0]
        triangles = surface.triangles_of(row)
        shading = Shading(own, triangles)
        shapes.append(
            BodyShape(
                body.name,
                own[triangles.ravel()].astype(np.float32),
                shading.normals(own).astype(np.float32),
                own[shading.edges.ravel()].astype(np.float32),
            )
        )
    return shapes


def rotation(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrix (3, 3), body to world, of a unit quaternion w x y z."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
