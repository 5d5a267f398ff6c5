"""Edges of a triangle mesh and the facets that share them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Edges:
    """Every edge once, ordered by its vertices, with the facets on it.

    Attributes:
        ends: the edge's vertices, the smaller number first, shape (edges, 2).
        counts: number of facets on the edge, shape (edges,): 1 open, 2 proper, more is non-manifold.
        pairs: the two facets of each proper edge, shape (proper, 2).
        mixed: whether those two run along the edge in the same direction, shape (proper,): one is turned over.
        proper: the number of each proper edge, shape (proper,).
    """

    ends: Integers
    counts: Integers
    pairs: Integers
    mixed: npt.NDArray[np.bool_]
    proper: Integers

    @property
    def open(self) -> Integers:
        """Numbers of the edges with one facet."""
        return np.flatnonzero(self.counts == 1)

    @property
    def non_manifold(self) -> Integers:
        """Numbers of the edges with more than two facets."""
        return np.flatnonzero(self.counts > 2)


def edges_of(triangles: Integers) -> Edges:
    """The edges of triangles given as vertex numbers, shape (m, 3)."""
    count, base = len(triangles), np.uint64(int(triangles.max()) + 1)
    starts = triangles.T.reshape(-1)  # half edge k * m + f: side k of facet f
    stops = np.roll(triangles, -1, axis=1).T.reshape(-1)
    keys = np.minimum(starts, stops).astype(np.uint64) * base + np.maximum(starts, stops).astype(np.uint64)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    first = np.flatnonzero(np.concatenate(([True], keys[1:] != keys[:-1])))
    counts = np.diff(np.append(first, len(keys)))
    ends = np.stack(np.divmod(keys[first], base), axis=1).astype(np.int64)
    proper = np.flatnonzero(counts == 2)
    halves = np.stack((order[first[proper]], order[first[proper] + 1]), axis=1)
    forward = starts[halves] < stops[halves]
    return Edges(ends, counts, halves % count, forward[:, 0] == forward[:, 1], proper)
