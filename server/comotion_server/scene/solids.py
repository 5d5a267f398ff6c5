"""From the shape that a scene asks for to one ready for bodies, each made once however many bodies have it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mass import centred, mass_properties, surface_centre
from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.mesh_file import load_mesh
from comotion_server.meshes.repair import repair
from comotion_server.meshes.shapes import box, box_properties, prism, prism_properties
from comotion_server.meshes.triangle_mesh import TriangleMesh
from comotion_server.scene.curved_shapes import Capsule, Curved, Cylinder, Pipe, Sphere
from comotion_server.scene.model import Plane

if TYPE_CHECKING:
    from pathlib import Path

    from pydantic import BaseModel

    from comotion_server.meshes.mass import MassProperties
    from comotion_server.meshes.mesh_health import MeshHealth
    from comotion_server.scene.tables import PlaneTable, ShapeTable

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape ready for a body.

    Attributes:
        label: what the scene calls it, for messages and reports.
        shape: mesh, vertices [m] about the centre, axes of the shape; or a plane; or what is exactly round.
        centre: of mass, or of area where nothing is enclosed [m], shape (3,), in the coordinates of the file; for a
            plane its point.
        volume: [m3]; nan for a surface that encloses nothing.
        inertia: of density 1 about the centre [m5], shape (3, 3); nan likewise.
        health: of the mesh, if there is one.
    """

    label: str
    shape: TriangleMesh | Plane | Curved
    centre: Floats
    volume: float
    inertia: Floats
    health: MeshHealth | None

    @property
    def vertex_count(self) -> int:
        """Of the surface that a client may ask for; a plane has none."""
        if isinstance(self.shape, Plane):
            return 0
        return self.shape.vertex_count if isinstance(self.shape, Curved) else len(self.shape.vertices)

    @property
    def outline(self) -> Floats:
        """Points [m], shape (n, 3), that the shape reaches out to from its centre: where there is room for it."""
        if isinstance(self.shape, Plane):
            return np.empty((0, 3))
        return self.shape.outline if isinstance(self.shape, Curved) else self.shape.vertices

    @property
    def flaws(self) -> tuple[str, ...]:
        """Why the mesh is no closed surface; nothing if it is one, or if there is no mesh."""
        return () if self.health is None or self.health.closed else tuple(self.health.problems)


class Solids:
    """The solids of one scene: bodies with the same shape share the mesh object."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._made: dict[str, Solid | MeshError] = {}

    def of(self, shape: ShapeTable) -> Solid:
        """The solid of a shape.

        Raises:
            MeshError: the mesh file cannot be used; said again for every body that asks for it.
        """
        key = str((self.folder / shape.stl).resolve()) if shape.stl else repr(shape)
        if key not in self._made:
            try:
                self._made[key] = self._make(shape)
            except MeshError as error:
                self._made[key] = error
        made = self._made[key]
        if isinstance(made, MeshError):
            raise made
        return made

    def _make(self, shape: ShapeTable) -> Solid:
        if shape.stl is not None:
            return _from_file(shape.stl, self.folder / shape.stl)
        if shape.box is not None:
            size = " x ".join(f"{edge:g}" for edge in shape.box.size)
            return _exact(f"box {size} m", box(shape.box.size), box_properties(shape.box.size))
        if shape.prism is not None:
            lengths = (shape.prism.base, shape.prism.height, shape.prism.thickness)
            label = f"prism {lengths[0]:g} x {lengths[1]:g} x {lengths[2]:g} m"
            return _exact(label, prism(*lengths), prism_properties(*lengths))
        if shape.plane is not None:
            return _plane(shape.plane)
        for table, kind in (
            (shape.sphere, Sphere),
            (shape.capsule, Capsule),
            (shape.cylinder, Cylinder),
            (shape.pipe, Pipe),
        ):
            if table is not None:
                return _curved(kind(**(table.model_dump() | _axis_of(table))))
        raise MeshError("no shape")


def _plane(table: PlaneTable) -> Solid:
    normal = np.array(table.normal) / np.linalg.norm(table.normal)
    return Solid("plane", Plane(normal), np.array(table.point), np.nan, np.full((3, 3), np.nan), None)


def _axis_of(table: BaseModel) -> dict[str, int]:
    """The axis of a table, if it has one, as a number."""
    axis = getattr(table, "axis", None)
    return {} if axis is None else {"axis": "xyz".index(axis)}


def _curved(shape: Curved) -> Solid:
    return Solid(shape.label, shape, np.zeros(3), shape.volume, shape.inertia, None)


def _from_file(label: str, path: Path) -> Solid:
    mesh, health = load_mesh(path)
    if health.closed:
        mass = mass_properties(mesh.vertices, mesh.triangles)
        centre, volume, inertia = mass.centre, mass.volume, mass.inertia
    else:
        centre = surface_centre(mesh.vertices, mesh.triangles)
        volume, inertia = np.nan, np.full((3, 3), np.nan)
    about_centre = TriangleMesh(centred(mesh.vertices, centre), mesh.triangles)
    return Solid(label, about_centre, centre, volume, inertia, health)


def _exact(label: str, mesh: TriangleMesh, mass: MassProperties) -> Solid:
    health = repair(mesh.vertices, mesh.triangles.astype(np.int64)).health
    return Solid(label, mesh, mass.centre, mass.volume, mass.inertia, health)
