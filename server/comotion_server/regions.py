"""Regions of geometry exchange (P17): the vertices of their bodies, one body after the other, as the CFD sees them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.place import place, place_velocities
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import quaternions_from_rotations
from comotion_server.scene import Body, Fixed, Scene
from comotion_server.world import State

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RegionBody:
    """A body's rows among the vertices of its region."""

    name: str
    first_vertex: int
    vertex_count: int


class Region:
    """The surface of one or many bodies as one block of vertices and triangles."""

    def __init__(self, name: str, members: tuple[Body, ...], row_of: dict[str, int]) -> None:
        self.name = name
        self._members = members
        self.rows = np.array([row_of[body.name] for body in members])
        self._still: Array | None = None
        self.moves = not all(isinstance(body.motion, Fixed) for body in members)

    @cached_property
    def _meshes(self) -> tuple[TriangleMesh, ...]:
        """Of the bodies; round shapes get theirs when vertices are first asked for, and forces may come as wrenches."""
        return tuple(body.surface for body in self._members)

    @cached_property
    def count(self) -> NDArray[np.int64]:
        """Vertices of each body."""
        return np.array([len(mesh.vertices) for mesh in self._meshes], dtype=np.int64)

    @cached_property
    def first(self) -> NDArray[np.int64]:
        """The first vertex of each body."""
        return np.concatenate([np.zeros(1, np.int64), np.cumsum(self.count)[:-1]])

    @property
    def vertex_count(self) -> int:
        """How many vertices its bodies have together."""
        return int(self.count.sum())

    @cached_property
    def bodies(self) -> tuple[RegionBody, ...]:
        """The bodies' shares of the vertices."""
        shares = zip(self._members, self.first.tolist(), self.count.tolist(), strict=True)
        return tuple(RegionBody(body.name, first, count) for body, first, count in shares)

    @cached_property
    def triangles(self) -> NDArray[np.uint32]:
        """Indices (m,3) into the vertices of the region."""
        parts = [mesh.triangles + np.uint32(first) for mesh, first in zip(self._meshes, self.first, strict=True)]
        return np.concatenate(parts)

    @property
    def triangle_count(self) -> int:
        """How many triangles its bodies have together."""
        return sum(len(mesh.triangles) for mesh in self._meshes)

    def vertices(self, state: State) -> Array:
        """World positions (n,3) [m] of the region's vertices; a region that never moves is placed once."""
        if not self.moves:
            if self._still is None:
                self._still = self._place(state)
            return self._still
        return self._place(state)

    def _place(self, state: State) -> Array:
        out = np.empty((self.vertex_count, 3))
        for row, first, count, mesh in zip(self.rows, self.first, self.count, self._meshes, strict=True):
            place(_scaled(mesh, state.scale[row]), state.rotation[row], state.position[row], out[first : first + count])
        return out

    def velocities(self, state: State) -> Array:
        """World velocities (n,3) [m/s] of the region's vertices."""
        out = np.empty((self.vertex_count, 3))
        for row, first, count, mesh in zip(self.rows, self.first, self.count, self._meshes, strict=True):
            rows = out[first : first + count]
            place_velocities(
                _scaled(mesh, state.scale[row]), state.rotation[row], state.velocity[row], state.spin[row], rows
            )
        return out


def _scaled(mesh: TriangleMesh, scale: float) -> Array:
    """Vertices (n,3) of a mesh [m], scaled about the centre of mass."""
    return mesh.vertices if scale == 1.0 else scale * mesh.vertices


@dataclass(frozen=True, slots=True)
class Sample:
    """Where the bodies are at a time: now, or at the predicted middle of the next step. World frame."""

    time: float  # [s]
    state: State  # of all bodies
    vertices: dict[str, Array]  # per region (n,3) [m]; empty unless asked for
    velocities: dict[str, Array]  # per region (n,3) [m/s]; empty unless asked for

    @property
    def poses(self) -> Array:
        """Centre of mass [m] and attitude per body, (bodies,7): x y z w qx qy qz."""
        return np.hstack([self.state.position, quaternions_from_rotations(self.state.rotation)])

    @property
    def twists(self) -> Array:
        """Velocity [m/s] and angular velocity [rad/s] per body, (bodies,6)."""
        return np.hstack([self.state.velocity, self.state.spin])

    @property
    def scales(self) -> Array:
        """Of the geometry, relative to the scene's, (bodies,): 1 unless healing scaled a body down (P16)."""
        return self.state.scale


def regions_of(scene: Scene) -> tuple[Region, ...]:
    """The regions of a scene in the order of their names."""
    row_of = {body.name: row for row, body in enumerate(scene.bodies)}
    return tuple(Region(name, members, row_of) for name, members in scene.regions.items())
