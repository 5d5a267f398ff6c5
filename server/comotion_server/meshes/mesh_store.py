"""All distinct meshes of a scene, flattened once into the arrays that the kernels walk through."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from comotion_server.kernels.lanes import LANES
from comotion_server.kernels.mesh_arrays import MeshArrays
from comotion_server.kernels.topology import build_normals, build_sharp, build_stars
from comotion_server.meshes.mesh_tree import binary_tree, lane_tree

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy.typing as npt

    from comotion_server.meshes.triangle_mesh import TriangleMesh


@dataclass(frozen=True)
class MeshStore:
    """The shapes of a scene with their trees, normals and neighbours.

    Attributes:
        arrays: what the mesh kernels take as their first argument.
        shape_of_mesh: the shape of each mesh given to `build`, shape (meshes,); the same object has one shape.
    """

    arrays: MeshArrays
    shape_of_mesh: npt.NDArray[np.int64]

    @property
    def size(self) -> npt.NDArray[np.float64]:
        """Diameters [m] of the shapes' bounding spheres about the body's origin, shape (shapes,)."""
        return self.arrays.size

    @classmethod
    def build(cls, meshes: Sequence[TriangleMesh]) -> MeshStore:
        """Flatten the meshes of all bodies; a mesh that several bodies share is stored and prepared once."""
        shapes: dict[int, int] = {}
        distinct: list[TriangleMesh] = []
        for mesh in meshes:
            if id(mesh) not in shapes:
                shapes[id(mesh)] = len(distinct)
                distinct.append(mesh)
        shape_of_mesh = np.array([shapes[id(mesh)] for mesh in meshes], dtype=np.int64)
        return cls(joined([prepared(mesh) for mesh in distinct]), shape_of_mesh)


def prepared(mesh: TriangleMesh) -> MeshArrays:
    """The arrays of one mesh alone."""
    vertices = np.array(mesh.vertices, dtype=np.float64, order="C")
    triangles = np.array(mesh.triangles, dtype=np.int64, order="C")
    count = len(triangles)
    normals, sharp = np.empty((count, 3)), np.empty((count, 3), np.uint8)
    star_start, star = np.empty(len(vertices) + 1, np.int64), np.empty(3 * count, np.int64)
    build_normals(vertices, triangles, normals)
    build_stars(triangles, star_start, star)
    build_sharp(triangles, normals, star_start, star, sharp)
    binary = binary_tree(vertices, triangles)
    lanes = lane_tree(vertices, triangles, binary)
    return MeshArrays(
        vertices=vertices,
        triangles=triangles,
        normals=normals,
        sharp=sharp,
        star_start=star_start,
        star=star,
        vertex_start=np.array([0, len(vertices)], dtype=np.int64),
        triangle_start=np.array([0, count], dtype=np.int64),
        root=np.zeros(1, np.int64),
        **binary._asdict(),
        top=np.zeros(1, np.int64),
        **lanes._asdict(),
        size=np.array([mesh.size]),
    )


def _starts(counts: Sequence[int]) -> npt.NDArray[np.int64]:
    """Where each part begins, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def joined(parts: Sequence[MeshArrays]) -> MeshArrays:
    """One bundle from the bundles of single shapes, their indices shifted to count over all shapes."""
    vertex_start = _starts([len(part.vertices) for part in parts])
    triangle_start = _starts([len(part.triangles) for part in parts])
    node_start = _starts([len(part.child) for part in parts])

    def stacked(name: str) -> npt.NDArray[np.float64]:
        return np.ascontiguousarray(np.concatenate([getattr(part, name) for part in parts]))

    def shifted(name: str, start: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        return np.concatenate([getattr(part, name) + shift for part, shift in zip(parts, start[:-1], strict=True)])

    child = shifted("child", node_start)
    child[np.concatenate([part.child for part in parts]) < 0] = -1
    lane_start = _starts([len(part.used) for part in parts])
    link = [
        np.where(part.link < 0, part.link - triangle, part.link + node)  # ~(t + n) is ~t - n
        for part, triangle, node in zip(parts, triangle_start[:-1], lane_start[:-1], strict=True)
    ]
    star_start = [part.star_start[:-1] + 3 * shift for part, shift in zip(parts, triangle_start[:-1], strict=True)]
    return MeshArrays(
        vertices=stacked("vertices"),
        triangles=shifted("triangles", vertex_start),
        normals=stacked("normals"),
        sharp=np.concatenate([part.sharp for part in parts]),
        star_start=np.concatenate([*star_start, [3 * triangle_start[-1]]]).astype(np.int64),
        star=shifted("star", triangle_start),
        vertex_start=vertex_start,
        triangle_start=triangle_start,
        root=node_start[:-1].copy(),
        centre=stacked("centre"),
        axes=stacked("axes"),
        half=stacked("half"),
        child=child,
        first=shifted("first", triangle_start),
        entries=np.concatenate([part.entries for part in parts]),
        leaf_triangles=shifted("leaf_triangles", triangle_start),
        top=LANES * lane_start[:-1],
        used=np.concatenate([part.used for part in parts]),
        link=np.concatenate(link),
        box=stacked("box"),
        block=stacked("block"),
        size=stacked("size"),
    )
