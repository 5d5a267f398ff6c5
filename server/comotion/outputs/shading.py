"""How a surface of triangles is shaded: normals that are smooth within a body's faces and break at its edges.

What belongs to which is found once, on the surface as it is at first; bodies are rigid, so it holds from then on.
"""

import numpy as np
from numpy.typing import NDArray

CREASE = np.cos(np.radians(30.0))  # cosine of the angle between normals from which on an edge is seen as one

TINY = np.finfo(float).tiny  # in place of a length of zero: a degenerate triangle has no normal


class Shading:
    """Of `points` [m], shape (n, 3), and `triangles`, shape (m, 3), into them.

    `edges`, shape (k, 2): pairs of points between which an edge is drawn.
    """

    def __init__(self, points: NDArray[np.floating], triangles: NDArray[np.int64]) -> None:
        self._triangles = triangles
        area = face_normals(points, triangles)
        unit = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), TINY)
        self._faces, self._first = _level_faces(triangles, unit)
        self.edges = _sharp_edges(triangles, unit)

    def normals(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Unit normals at the corners of all triangles, shape (3 m, 3), with the points where they are now."""
        area = face_normals(points, self._triangles)
        if not len(area):
            return np.zeros((0, 3))
        summed = np.add.reduceat(area[self._faces], self._first, axis=0)
        unit: NDArray[np.float64] = summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), TINY)
        return unit


def face_normals(points: NDArray[np.floating], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Outward normals of the triangles, shape (m, 3), each as long as twice its area [m^2]."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a).astype(np.float64)


def _level_faces(
    triangles: NDArray[np.int64], unit: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Per corner of a triangle the faces around its point that are level with it, and where each corner's begin."""
    point = triangles.ravel()
    face = np.repeat(np.arange(len(triangles)), 3)
    by_point = np.argsort(point, kind="stable")
    count = np.bincount(point, minlength=int(point.max(initial=-1)) + 1)
    start = np.cumsum(count) - count
    around = count[point]  # faces around each corner's point, itself included
    corner = np.repeat(np.arange(len(point)), around)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(around) - around, around)
    other = face[by_point[start[point[corner]] + within]]
    level = np.einsum("ij,ij->i", unit[face[corner]], unit[other]) > CREASE
    level |= face[corner] == other
    kept = np.bincount(corner[level], minlength=len(point))
    return other[level], np.cumsum(kept) - kept


def _sharp_edges(triangles: NDArray[np.int64], unit: NDArray[np.float64]) -> NDArray[np.int64]:
    """Edges where two faces meet at an angle, and those without just two faces."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    face = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    pairs, first, count = np.unique(sides[order], axis=0, return_index=True, return_counts=True)
    sorted_face = face[order]
    two = count == 2
    one, other = sorted_face[first[two]], sorted_face[first[two] + 1]
    sharp = ~two
    sharp[two] = np.einsum("ij,ij->i", unit[one], unit[other]) < CREASE
    edges: NDArray[np.int64] = pairs[sharp]
    return edges
