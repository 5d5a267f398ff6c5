"""What was found in a mesh file, what was repaired, and what cannot be."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

Point = tuple[float, float, float]


@dataclass(frozen=True)
class MeshHealth:
    """Figures of a mesh after repair; lengths in the units of the file, taken as metres.

    Attributes:
        corners_read: vertices in the file (three per facet in an STL file).
        facets_read: facets in the file.
        vertices: distinct vertices that facets use.
        triangles: facets kept.
        shells: parts that hang together over edges.
        volume: enclosed [m3]; nan for a surface that is not closed.
        area: [m2].
        extent: edges of the bounding box [m].
        smallest_edge: [m].
        worst_aspect: longest edge over the height on it, the largest of all facets; 1.15 is equilateral.
        cracks: vertices on open edges that were joined with a neighbour next to them.
        zero_area: facets without area that were taken out.
        doubled: facets on the same three vertices as another that were taken out.
        turned_facets: facets turned over to agree with their neighbours.
        turned_shells: shells turned over because they enclosed a negative volume.
        open_edges: edges with one facet.
        non_manifold_edges: edges with more than two facets.
        unorientable: whether facets run both ways round and turning them over cannot help.
        first_bad_edge: both ends [m] of the first edge to blame, in the file's coordinates.
    """

    corners_read: int
    facets_read: int
    vertices: int
    triangles: int
    shells: int
    volume: float
    area: float
    extent: Point
    smallest_edge: float
    worst_aspect: float
    cracks: int = 0
    zero_area: int = 0
    doubled: int = 0
    turned_facets: int = 0
    turned_shells: int = 0
    open_edges: int = 0
    non_manifold_edges: int = 0
    unorientable: bool = False
    first_bad_edge: tuple[Point, Point] | None = None

    @property
    def closed(self) -> bool:
        """Whether the surface bounds a solid."""
        return not self.problems

    @property
    def problems(self) -> tuple[str, ...]:
        """What keeps the surface from bounding a solid, in words; empty for a sound one."""
        found = []
        if self.open_edges:
            found.append(_count(self.open_edges, "open edge"))
        if self.non_manifold_edges:
            found.append(_count(self.non_manifold_edges, "edge") + " with more than two facets")
        if self.unorientable:
            found.append("a one-sided surface")
        if found and self.first_bad_edge is not None:
            a, b = (", ".join(f"{x:.9g}" for x in end) for end in self.first_bad_edge)
            found[0] += f" (the first from ({a}) to ({b}))"
        if not found and not self.volume > 0.0:
            found.append("no volume")
        return tuple(found)

    @property
    def repairs(self) -> tuple[str, ...]:
        """What was mended, in words."""
        figures = (
            (self.cracks, "vertex", "joined across cracks"),
            (self.zero_area, "facet", "without area taken out"),
            (self.doubled, "facet", "on the same vertices as another taken out"),
            (self.turned_facets, "facet", "turned over to agree with the neighbours"),
            (self.turned_shells, "shell", "turned inside out: the volume was negative"),
        )
        return tuple(f"{_count(count, what)} {how}" for count, what, how in figures if count)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON; a volume that does not exist is None."""
        data = asdict(self)
        data["volume"] = self.volume if self.volume == self.volume else None
        return data | {"closed": self.closed, "problems": list(self.problems), "repairs": list(self.repairs)}

    def table(self) -> str:
        """The figures as aligned text, one a line."""
        rows = (
            ("vertices", f"{self.vertices} (from {self.corners_read} corners)"),
            ("triangles", f"{self.triangles} (from {self.facets_read})"),
            ("shells", str(self.shells)),
            ("volume", f"{self.volume:.9g} m3"),
            ("area", f"{self.area:.9g} m2"),
            ("extent", " x ".join(f"{x:.6g}" for x in self.extent) + " m"),
            ("smallest edge", f"{self.smallest_edge:.6g} m"),
            ("worst aspect", f"{self.worst_aspect:.4g}"),
            *(("repaired", line) for line in self.repairs),
            *(("problem", line) for line in self.problems),
        )
        return "\n".join(f"{name:<14}{value}" for name, value in rows)


def _count(count: int, noun: str) -> str:
    plural = {"vertex": "vertices"}.get(noun, noun + "s")
    return f"{count} {noun if count == 1 else plural}"
