"""Frames (P17): what a body collides with in place of its own surface, a little larger or simpler.

A frame is a closed surface that the body lies strictly inside of. Frames that never meet keep the bodies in them apart
by twice the clearance, so that bodies of one region of geometry exchange never intersect.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.edges import edges_of
from comotion_server.meshes.mass import centred
from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.mesh_file import load_mesh
from comotion_server.meshes.offset import moved_out
from comotion_server.meshes.orientation import shells_of
from comotion_server.meshes.triangle_mesh import TriangleMesh

if TYPE_CHECKING:
    from pathlib import Path

    from comotion_server.scene.solids import Solid
    from comotion_server.scene.tables import FrameTable

Floats = npt.NDArray[np.float64]

HERE = np.eye(3), np.zeros(3)
EXPECTED = "the body must lie strictly inside"


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame ready for a body.

    Attributes:
        label: what the scene calls it, for messages and reports.
        mesh: vertices [m] about the body's centre of mass, body frame.
        clearance: least distance [m] between the body's surface and the frame's.
    """

    label: str
    mesh: TriangleMesh
    clearance: float


class Frames:
    """The frames of one scene: bodies with the same shape and the same frame share the mesh object."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._made: dict[tuple[int, str], tuple[Solid, Frame | MeshError]] = {}  # the solid keeps its id its own

    def of(self, table: FrameTable, solid: Solid) -> Frame:
        """The frame of a solid, made and checked once.

        Raises:
            MeshError: there is no such frame, or the body does not lie inside; said again for every body with it.
        """
        key = id(solid), repr(table)
        if key not in self._made:
            try:
                self._made[key] = solid, self._make(table, solid)
            except MeshError as error:
                self._made[key] = solid, error
        made = self._made[key][1]
        if isinstance(made, MeshError):
            raise made
        return made

    def _make(self, table: FrameTable, solid: Solid) -> Frame:
        if not isinstance(solid.shape, TriangleMesh):
            raise MeshError(f"a {solid.label} has no frame")
        if table.stl is not None:
            label, mesh = table.stl, self._from_file(table.stl, solid)
        elif solid.flaws:
            raise MeshError(f"{solid.label}: {', '.join(solid.flaws)}: a frame needs a closed surface")
        elif table.scale is not None:
            label = f"scale {table.scale:g}"
            mesh = TriangleMesh(table.scale * solid.shape.vertices, solid.shape.triangles)
        elif table.offset is not None:
            label, mesh = f"offset {table.offset:g} m", moved_out(solid.shape, table.offset)
        else:
            raise MeshError("no frame")
        return Frame(label, mesh, clearance(solid.shape, mesh))

    def _from_file(self, name: str, solid: Solid) -> TriangleMesh:
        mesh, health = load_mesh(self.folder / name)
        if not health.closed:
            raise MeshError(f"{', '.join(health.problems)}: a frame needs a closed surface")
        return TriangleMesh(centred(mesh.vertices, solid.centre), mesh.triangles)


def clearance(body: TriangleMesh, frame: TriangleMesh) -> float:
    """Least distance [m] between the surfaces of a body and of its frame, in the same coordinates.

    Where the surfaces do not meet, a whole part of the body's is inside if one corner of it is; and the frame is
    hollow nowhere in the body if no part of its surface is inside the body.

    Raises:
        MeshError: the body does not lie strictly inside.
    """
    from comotion_server.geometry import distance

    closest = distance(body, HERE, frame, HERE)
    if closest.distance == 0.0:
        raise MeshError(f"the surface of the body meets its frame's at {_shown(closest.point_a)}; {EXPECTED}")
    for point in _corner_of_each_shell(body):
        if _winding(point, frame) < 0.5:
            raise MeshError(f"the corner of the body at {_shown(point)} lies outside of its frame; {EXPECTED}")
    for point in _corner_of_each_shell(frame):
        if _winding(point, body) > 0.5:
            raise MeshError(f"the corner of the frame at {_shown(point)} lies inside of the body; {EXPECTED}")
    return closest.distance


def _corner_of_each_shell(mesh: TriangleMesh) -> Floats:
    """One corner [m] of every part of a surface that hangs together over edges, (k, 3)."""
    triangles = mesh.triangles.astype(np.int64)
    first = np.unique(shells_of(triangles, edges_of(triangles)))
    return np.asarray(mesh.vertices[triangles[first, 0]])


def _winding(point: Floats, mesh: TriangleMesh) -> float:
    """How often a surface goes round a point (3,): 1 inside, 0 outside (van Oosterom and Strackee 1983)."""
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", *sides) for sides in ((a, b), (b, c), (c, a)))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    return float(np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb).sum() / (2.0 * np.pi))


def _shown(point: Floats) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"
