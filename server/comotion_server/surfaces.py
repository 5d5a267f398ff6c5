"""The surfaces of a run as one client sees them: welded, or with three vertices of its own per facet (SPEC M5)."""

import hashlib
from collections.abc import Mapping, Sequence

import numpy as np

from comotion_protocol.messages import FloatArray, IndexArray, Region, RegionBody
from comotion_server.engine import EngineRegion


def surface_digest(regions: Sequence[EngineRegion], vertices: Mapping[str, FloatArray]) -> str:
    """SHA-256 over the names, the welded vertices at the start of the run and the triangles (SPEC M7)."""
    digest = hashlib.sha256()
    for region in regions:
        digest.update(region.name.encode() + b"\0")
        digest.update(np.ascontiguousarray(vertices[region.name], "<f8").data)
        digest.update(np.ascontiguousarray(region.triangles, "<u4").data)
    return digest.hexdigest()


class Surface:
    """One region, welded: what is sent is what the simulation has."""

    def __init__(self, region: EngineRegion) -> None:
        self._region = region
        self.moves = region.moves
        self.triangles: IndexArray = np.ascontiguousarray(region.triangles, "<u4")
        self.vertex_count = region.vertex_count

    def describe(self) -> Region:
        """The region's entry in the open reply."""
        return Region(
            name=self._region.name,
            vertex_count=self.vertex_count,
            triangle_count=len(self.triangles),
            moves=self.moves,
            bodies=tuple(self._share(body.name, body.first_vertex, body.vertex_count) for body in self._region.bodies),
        )

    def send(self, vertices: FloatArray) -> FloatArray:
        """Welded rows to rows as sent."""
        return np.ascontiguousarray(vertices, "<f8")

    def receive(self, forces: FloatArray) -> FloatArray:
        """Forces as received [N] to forces on welded vertices."""
        return forces

    def _share(self, name: str, first: int, count: int) -> RegionBody:
        return RegionBody(name=name, first_vertex=first, vertex_count=count)


class FacetSurface(Surface):
    """One region with three vertices of its own per facet, in the order of the triangles."""

    def __init__(self, region: EngineRegion) -> None:
        super().__init__(region)
        self._welded = self.triangles.ravel().astype(np.intp)
        self._welded_count = region.vertex_count
        self.vertex_count = len(self._welded)
        self.triangles = np.arange(self.vertex_count, dtype="<u4").reshape(-1, 3)

    def send(self, vertices: FloatArray) -> FloatArray:
        """Welded rows to rows as sent."""
        return np.ascontiguousarray(vertices[self._welded], "<f8")

    def receive(self, forces: FloatArray) -> FloatArray:
        """Forces as received [N], added up per welded vertex in the order of the rows."""
        columns = [np.bincount(self._welded, forces[:, axis], self._welded_count) for axis in range(3)]
        return np.column_stack(columns)

    def _share(self, name: str, first: int, count: int) -> RegionBody:
        mine = np.flatnonzero((self._welded >= first) & (self._welded < first + count))
        return RegionBody(name=name, first_vertex=int(mine[0]) if len(mine) else 0, vertex_count=len(mine))


def surfaces_of(regions: Sequence[EngineRegion], indexing: str) -> dict[str, Surface]:
    """The surfaces by region, as the client wants them."""
    kind = FacetSurface if indexing == "facets" else Surface
    return {region.name: kind(region) for region in regions}
