"""Facets that say nothing: collapsed, doubled, or without area."""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


FACETS_AT_ONCE = 1 << 17
"""Facets per block: bounds the memory of measuring, whatever the size of the mesh."""


class FacetMeasures(NamedTuple):
    """Per facet, each of shape (m,): area [m2], shortest and longest edge [m], height over the longest edge [m]."""

    area: Floats
    shortest: Floats
    longest: Floats
    height: Floats


def drop_collapsed(triangles: Integers) -> Integers:
    """Without the facets that have a vertex twice."""
    a, b, c = triangles.T
    return np.asarray(triangles[(a != b) & (b != c) & (c != a)])


def drop_doubled(triangles: Integers) -> Integers:
    """With one facet, the first, for every set of three vertices, whichever way round it runs."""
    ordered = np.sort(triangles, axis=1)
    order = np.lexsort(ordered.T)  # stable: the first of equals stays
    ordered = ordered[order]
    repeated = np.concatenate(([False], (ordered[1:] == ordered[:-1]).all(axis=1)))
    if not repeated.any():
        return triangles
    return np.delete(triangles, order[repeated], axis=0)


def measure(points: Floats, triangles: Integers) -> FacetMeasures:
    """Area and edges of every facet."""
    blocks = np.split(triangles, range(FACETS_AT_ONCE, len(triangles), FACETS_AT_ONCE))
    return FacetMeasures(*map(np.concatenate, zip(*(_measure(points, block) for block in blocks), strict=True)))


def _measure(points: Floats, triangles: Integers) -> FacetMeasures:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    sides = [np.sqrt(np.einsum("ij,ij->i", d, d)) for d in (b - a, c - b, a - c)]
    normal = np.cross(b - a, c - a)
    doubled = np.sqrt(np.einsum("ij,ij->i", normal, normal))
    longest = np.maximum(np.maximum(sides[0], sides[1]), sides[2])
    shortest = np.minimum(np.minimum(sides[0], sides[1]), sides[2])
    height = np.divide(doubled, longest, out=np.zeros_like(doubled), where=longest > 0.0)
    return FacetMeasures(0.5 * doubled, shortest, longest, height)


def dissolve_flat(points: Floats, triangles: Integers, flat: Integers) -> Integers:
    """Take out facets whose three corners lie on a line, and keep the surface closed.

    A flat facet a b c, b between a and c, stands on its neighbour over the long edge a c. Both are replaced by the
    neighbour cut in two at b, which is the same surface. Of flat facets in a row the one with the longest edge stands
    on the sound neighbour, so it comes first. A flat facet without exactly one such neighbour is left out.

    Args:
        points: [m], shape (n, 3).
        triangles: vertex numbers, shape (m, 3).
        flat: numbers of the flat facets.
    """
    patch = _Patch(triangles, np.flatnonzero(np.isin(triangles, triangles[flat]).sum(axis=1) >= 2))
    for f in flat[np.argsort(-measure(points, triangles[flat]).longest, kind="stable")].tolist():
        corners = patch.remove(f)
        sides = [points[corners[k - 1]] - points[corners[k - 2]] for k in range(3)]  # side k faces corner k
        middle = corners[int(np.argmax([side @ side for side in sides]))]
        a, c = (corner for corner in corners if corner != middle)
        behind = patch.facets_on[frozenset((a, c))]
        if len(behind) == 1:
            (other,) = behind
            whole = patch.remove(other)
            patch.add(f, tuple(middle if corner == a else corner for corner in whole))
            patch.add(other, tuple(middle if corner == c else corner for corner in whole))
    result = triangles.copy()
    for f, corners in patch.facets.items():
        result[f] = corners
    return np.delete(result, [f for f in flat.tolist() if f not in patch.facets], axis=0)


class _Patch:
    """The few facets around the flat ones, with a look-up by edge."""

    def __init__(self, triangles: Integers, numbers: Integers) -> None:
        self.facets: dict[int, tuple[int, ...]] = {}
        self.facets_on: defaultdict[frozenset[int], set[int]] = defaultdict(set)
        for f in numbers.tolist():
            self.add(f, tuple(triangles[f].tolist()))

    def add(self, f: int, corners: tuple[int, ...]) -> None:
        self.facets[f] = corners
        for k in range(3):
            self.facets_on[frozenset((corners[k - 1], corners[k]))].add(f)

    def remove(self, f: int) -> tuple[int, ...]:
        corners = self.facets.pop(f)
        for k in range(3):
            self.facets_on[frozenset((corners[k - 1], corners[k]))].discard(f)
        return corners
