"""The surfaces of all regions as one list of points and triangles: what the series and the picture draw."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from comotion_protocol.messages import Region


@dataclass(frozen=True)
class BodyPoints:
    """Where the points of one body lie in the list of all points."""

    name: str
    first: int
    count: int


class Surface:
    """Points of all regions in the order of the regions, with the triangles between them.

    `points` [m], shape (n, 3), world frame, is replaced as vertices arrive; `triangles`, shape (m, 3), and
    `body_of_triangle`, shape (m,), and `body_of_point`, shape (n,), indices into `bodies` (which are in the order of
    their names), stay.
    """

    def __init__(
        self,
        regions: Iterable["Region"],
        vertices: Mapping[str, NDArray[np.float64]],
        triangles: Mapping[str, NDArray[np.uint32]],
    ) -> None:
        first = 0
        self._places: dict[str, slice] = {}
        bodies: list[BodyPoints] = []
        lists: list[NDArray[np.int64]] = [np.empty((0, 3), dtype=np.int64)]
        for region in regions:
            self._places[region.name] = slice(first, first + region.vertex_count)
            bodies += [BodyPoints(body.name, first + body.first_vertex, body.vertex_count) for body in region.bodies]
            lists.append(triangles[region.name].astype(np.int64) + first)
            first += region.vertex_count
        self.bodies = tuple(sorted(bodies, key=lambda body: body.name))
        self.triangles = np.concatenate(lists)
        self.points = np.zeros((first, 3))
        self.body_of_point = np.empty(first, dtype=np.int64)
        for row, body in enumerate(self.bodies):
            self.body_of_point[body.first : body.first + body.count] = row
        self.body_of_triangle = self.body_of_point[self.triangles[:, 0]]
        self.update(vertices)

    def update(self, vertices: Mapping[str, NDArray[np.float64]]) -> None:
        """Take the vertices [m], shape (n, 3), world frame, of the regions given; the others stay where they were."""
        for region, values in vertices.items():
            self.points[self._places[region]] = values

    def points_of(self, body: BodyPoints) -> NDArray[np.float64]:
        """Points of one body [m], shape (count, 3), world frame."""
        return self.points[body.first : body.first + body.count]

    def scales(self, poses: NDArray[np.float64], before: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sizes of the bodies at poses (bodies, 7), relative to `before` (of `sizes`); shape (bodies,), to rounding."""
        return np.divide(self.sizes(poses), before, out=np.ones_like(before), where=before > 0.0)

    def sizes(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Root of the summed squares of each body's arms [m] about its centre of mass, shape (bodies,)."""
        arms = self.points - poses[self.body_of_point, :3]
        return np.sqrt(np.bincount(self.body_of_point, np.einsum("ij,ij->i", arms, arms), len(self.bodies)))

    def triangles_of(self, body: int) -> NDArray[np.int64]:
        """Triangles of one body, shape (m, 3), into its own points."""
        own: NDArray[np.int64] = self.triangles[self.body_of_triangle == body]
        return own - self.bodies[body].first
