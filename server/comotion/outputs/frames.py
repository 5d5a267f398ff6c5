"""Frames (P17) as pictures show them: closed surfaces that move with their bodies."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.body_shapes import rotation


@dataclass(frozen=True)
class Frames:
    """`points` [m], shape (n, 3), world frame, are where `place` puts them; `triangles`, shape (m, 3), into them.

    `own` are the points about each body's centre of mass, body frame; `spans` the bodies that have frames: their row
    among all bodies with a surface, and which points are theirs.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    own: NDArray[np.float64]
    spans: Sequence[tuple[int, slice]]

    @classmethod
    def of_scene(cls, scene: Path, names: Sequence[str]) -> Self | None:
        """The frames of the bodies in a scene file, whose rows are those of `names`; None where none has one."""
        from comotion_server.scene import load_scene

        rows = {name: row for row, name in enumerate(names)}
        found = [(rows[body.name], body.frame) for body in load_scene(scene).bodies if body.frame is not None]
        if not found:
            return None
        ends = np.cumsum([0, *(len(mesh.vertices) for _, mesh in found)]).tolist()
        own = np.concatenate([mesh.vertices for _, mesh in found])
        triangles = [mesh.triangles.astype(np.int64) + end for (_, mesh), end in zip(found, ends, strict=False)]
        spans = [(row, slice(ends[i], ends[i + 1])) for i, (row, _) in enumerate(found)]
        return cls(own.copy(), np.concatenate(triangles), own, spans)

    def place(self, poses: NDArray[np.float64], scales: NDArray[np.float64]) -> None:
        """Move the points to poses (bodies, 7), x y z [m], w qx qy qz, with scales (bodies,)."""
        for row, part in self.spans:
            self.points[part] = scales[row] * self.own[part] @ rotation(poses[row, 3:]).T + poses[row, :3]
