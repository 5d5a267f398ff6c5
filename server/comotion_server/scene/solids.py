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
from comotion_server.scene.model import Pipe, Plane, Sphere

if TYPE_CHECKING:
    from pathlib import Path

    from comotion_server.meshes.mass import MassProperties
    from comotion_server.meshes.mesh_health import MeshHealth
    from comotion_server.scene.tables import PipeTable, PlaneTable, ShapeTable

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape ready for a body.

    Attributes:
        label: what the scene calls it, for messages and reports.
        shape: mesh, vertices [m] about the centre, axes of the shape; or a plane.
        centre: of mass, or of area where nothing is enclosed [m], shape (3,), in the coordinates of the file; for a
            plane its point.
        volume: [m3]; nan for a surface that encloses nothing.
        inertia: of density 1 about the centre [m5], shape (3, 3); nan likewise.
        health: of the mesh, if there is one.
    """

    label: str
    shape: TriangleMesh | Plane | Sphere | Pipe
    centre: Floats
    volume: float
    inertia: Floats
    health: MeshHealth | None

    @property
    def vertices(self) -> Floats:
        """Of the mesh [m], shape (n, 3); a shape without a mesh has none."""
        return np.empty((0, 3)) if isinstance(self.shape, Plane | Sphere | Pipe) else self.shape.vertices

    @property
    def outline(self) -> Floats:
        """Points [m], shape (n, 3), that the shape reaches out to from its centre: where there is room for it."""
        if isinstance(self.shape, Sphere):
            return self.shape.radius * np.vstack([np.eye(3), -np.eye(3)])
        if isinstance(self.shape, Pipe):
            reach = np.full(3, self.shape.outer_radius)
            reach[self.shape.axis] = 0.5 * self.shape.length
            return np.vstack([reach, -reach])
        return self.vertices

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
        if shape.sphere is not None:
            return _sphere(shape.sphere.radius)
        if shape.pipe is not None:
            return _pipe(shape.pipe)
        raise MeshError("no shape")


def _plane(table: PlaneTable) -> Solid:
    normal = np.array(table.normal) / np.linalg.norm(table.normal)
    return Solid("plane", Plane(normal), np.array(table.point), np.nan, np.full((3, 3), np.nan), None)


def _sphere(r: float) -> Solid:
    volume = 4.0 / 3.0 * np.pi * r**3
    return Solid(f"sphere of radius {r:g} m", Sphere(r), np.zeros(3), volume, 0.4 * volume * r * r * np.eye(3), None)


def _pipe(table: PipeTable) -> Solid:
    inner, outer, length = table.inner_radius, table.outer_radius, table.length
    volume = np.pi * (outer**2 - inner**2) * length
    about, across = 0.5 * (outer**2 + inner**2), 0.25 * (outer**2 + inner**2) + length**2 / 12.0
    label = f"pipe of radii {inner:g} and {outer:g} m, length {length:g} m" + (", closed" if table.caps else "")
    axis = "xyz".index(table.axis)
    moments = np.where(np.arange(3) == axis, about, across)
    shape = Pipe(inner, outer, length, axis, table.caps)
    return Solid(label, shape, np.zeros(3), volume, volume * np.diag(moments), None)


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
