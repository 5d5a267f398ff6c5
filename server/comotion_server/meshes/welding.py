"""One number per point of space: corners that are the same point become the same vertex."""

from __future__ import annotations

from itertools import product

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


def weld(points: Floats) -> tuple[Floats, Integers]:
    """Join points that are equal bit for bit (0.0 and -0.0 are equal).

    Args:
        points: [m], shape (n, 3).

    Returns:
        The distinct points in the order of their first appearance, shape (k, 3), and for every point its number (n,).
    """
    order = np.lexsort(points.T)  # stable: the first of a group is its first appearance
    starts = np.ones(len(points), dtype=bool)
    starts[1:] = False
    for axis in range(3):
        column = points[order, axis]
        starts[1:] |= column[1:] != column[:-1]
    firsts = order[starts]
    appearance = np.argsort(firsts)
    rank = np.empty(len(firsts), dtype=np.int64)
    rank[appearance] = np.arange(len(firsts))
    numbers = np.empty(len(points), dtype=np.int64)
    numbers[order] = rank[np.cumsum(starts) - 1]
    return points[firsts[appearance]], numbers


def join_near(points: Floats, candidates: Integers, tolerance: float) -> Integers:
    """Join those of a few points that lie within a tolerance of each other.

    Cells of twice the tolerance are laid in the eight ways that are shifted by half a cell: two points within the
    tolerance share a cell in at least one of them, and points in one cell are at most 2 sqrt(3) tolerances apart.

    Args:
        points: [m], shape (n, 3).
        candidates: numbers of the points that may be joined.
        tolerance: [m], greater than 0.

    Returns:
        For every point the number of the point that stands for it, shape (n,).
    """
    local = points[candidates] - points[candidates].min(axis=0)
    pairs = []
    for shift in product((0.0, 0.5), repeat=3):
        cells = np.floor(local / (2.0 * tolerance) + shift)
        first, numbers = weld(cells)
        leader = np.full(len(first), len(cells), dtype=np.int64)
        np.minimum.at(leader, numbers, np.arange(len(cells)))
        pairs.append((np.arange(len(cells)), leader[numbers]))
    joined = components(len(candidates), np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs]))
    numbers = np.arange(len(points))
    numbers[candidates] = candidates[joined]
    return numbers


def components(count: int, a: Integers, b: Integers) -> Integers:
    """Connected components of a graph with nodes 0 to `count` - 1 and edges a[i] - b[i].

    Returns:
        For every node the smallest node of its component, shape (count,).
    """
    label = np.arange(count)
    while True:
        roots_a, roots_b = label[a], label[b]
        apart = roots_a != roots_b
        if not apart.any():
            return label
        a, b = a[apart], b[apart]
        np.minimum.at(label, np.maximum(roots_a, roots_b)[apart], np.minimum(roots_a, roots_b)[apart])
        while (label != (shorter := label[label])).any():
            label = shorter


def drop_unused(points: Floats, triangles: Integers) -> tuple[Floats, Integers]:
    """The vertices that triangles refer to, in their order, and the triangles renumbered."""
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    if used.all():
        return points, triangles
    return points[used], (np.cumsum(used) - 1)[triangles]
