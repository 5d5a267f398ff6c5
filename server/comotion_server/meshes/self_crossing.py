"""Whether a closed surface crosses or touches itself: facets that share no corner meet, or neighbours fold over."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Iterator

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

PAIRS_AT_ONCE = 1 << 21
"""Pairs of facets per block: bounds the memory."""

SIDE = 1e-12
"""Of the cube of the extent: volumes below are those of corners in one plane."""

FOLDED = 1e-9
"""How near to -1 the product of two neighbours' normals may come."""


def first_crossing(points: Floats, facets: Integers) -> tuple[int, int] | None:
    """Two facets that meet elsewhere than in the corners they share, or None.

    Args:
        points: [m], shape (n, 3).
        facets: vertex numbers, shape (m, 3), none without area.
    """
    from comotion_server.kernels.triangle_intersection import triangles_intersect

    corners = points[facets]
    for i, j in _near(corners.min(axis=1), corners.max(axis=1)):
        shared = (facets[i][:, :, None] == facets[j][:, None, :]).sum(axis=(1, 2))
        apart = shared == 0
        for f, g in zip(i[apart].tolist(), j[apart].tolist(), strict=True):
            if triangles_intersect(*map(tuple, corners[f].tolist()), *map(tuple, corners[g].tolist())):
                return min(f, g), max(f, g)
        for wrong, pairs in ((_cross_at_corner, shared == 1), (_fold, shared == 2)):
            found = np.flatnonzero(wrong(points, facets[i[pairs]], facets[j[pairs]]))
            if len(found):
                f, g = int(i[pairs][found[0]]), int(j[pairs][found[0]])
                return min(f, g), max(f, g)
    return None


def _near(low: Floats, high: Floats) -> Iterator[tuple[Integers, Integers]]:
    """Blocks of pairs of facets whose bounds [m], (m, 3), overlap: a sweep along the longest axis."""
    axis = int(np.argmax(np.ptp(low, axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    ends = np.searchsorted(low[:, axis], high[:, axis], side="right")
    counts = ends - np.arange(len(low)) - 1
    total = np.concatenate([[0], np.cumsum(counts)])
    start = 0
    while start < len(low):
        stop = max(start + 1, int(np.searchsorted(total, total[start] + PAIRS_AT_ONCE, side="right")) - 1)
        i = np.repeat(np.arange(start, stop), counts[start:stop])
        j = i + 1 + np.arange(len(i)) - np.repeat(total[start:stop] - total[start], counts[start:stop])
        overlap = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
        yield order[i[overlap]], order[j[overlap]]
        start = stop


def _cross_at_corner(points: Floats, one: Integers, other: Integers) -> npt.NDArray[np.bool_]:
    """Whether facets (k, 3) with one corner in common meet elsewhere: the side opposite to it pierces the other one."""
    same = one[:, :, None] == other[:, None, :]
    turned = []
    for facets, at in ((one, same.any(axis=2).argmax(axis=1)), (other, same.any(axis=1).argmax(axis=1))):
        turned.append([points[np.take_along_axis(facets, (at[:, None] + k) % 3, axis=1)[:, 0]] for k in range(3)])
    (v, a, b), (_, c, d) = turned
    extent = np.abs(np.stack([a - v, b - v, c - v, d - v])).max(axis=(0, 2), initial=0.0)
    least = SIDE * extent**3
    return _pierces(a - v, b - v, c - v, d - v, least) | _pierces(c - v, d - v, a - v, b - v, least)


def _pierces(p: Floats, q: Floats, c: Floats, d: Floats, least: Floats) -> npt.NDArray[np.bool_]:
    """Whether segments p q cross the triangles 0 c d; all (k, 3), volumes up to `least` (k,) count as none."""
    low, high = _volume(c, d, p), _volume(c, d, q)
    sides = np.stack([_volume(p, q, c), _volume(q - p, c - p, d - p), -_volume(p, q, d)])
    through = (sides >= -least).all(axis=0) | (sides <= least).all(axis=0)
    return np.asarray(through & (np.minimum(low, high) < -least) & (np.maximum(low, high) > least))


def _volume(a: Floats, b: Floats, c: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)))


def _fold(points: Floats, one: Integers, other: Integers) -> npt.NDArray[np.bool_]:
    """Whether facets (k, 3) with a side in common lie on each other."""
    normals = []
    for facets in (one, other):
        a, b, c = (points[facets[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normals.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
    return np.asarray(np.einsum("ij,ij->i", *normals) < FOLDED - 1.0)
