"""Which way round facets run: the same way over every edge, and outward."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.welding import components

if TYPE_CHECKING:
    from comotion_server.meshes.edges import Edges

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class Turned(NamedTuple):
    """Facets after some were turned over, and the first proper edge that cannot be made consistent, if any."""

    triangles: Integers
    turned: int
    impossible: int | None


def shells_of(triangles: Integers, edges: Edges) -> Integers:
    """For every facet the smallest facet that it hangs together with over proper edges, shape (m,)."""
    return components(len(triangles), edges.pairs[:, 0], edges.pairs[:, 1])


def make_consistent(triangles: Integers, edges: Edges) -> Turned:
    """Turn facets over until neighbours run along their common edge in opposite directions; as few as possible.

    Every facet f has two nodes: f as it is and f turned over (f + m). Neighbours that agree join as they are, those
    that do not join crosswise. A shell can be oriented if and only if no facet hangs together with its own turned
    self; its two sheets are then its two orientations.
    """
    if not edges.mixed.any():
        return Turned(triangles, 0, None)
    count = len(triangles)
    a, b = edges.pairs.T
    crossed = np.where(edges.mixed, count, 0)
    sheet = components(2 * count, np.concatenate((a, a + count)), np.concatenate((b + crossed, b + count - crossed)))
    as_is, turned = sheet[:count], sheet[count:]
    both = as_is == turned
    if both.any():
        edge = int(edges.proper[np.flatnonzero(edges.mixed & both[a])[0]])
        return Turned(triangles, 0, edge)
    shell = np.minimum(as_is, turned)  # facets of one shell share it, on either sheet
    other = as_is > turned  # the facet lies on the sheet that does not hold the shell's first facet as it is
    share = np.bincount(shell[other], minlength=count) / np.maximum(np.bincount(shell, minlength=count), 1)
    flip = other ^ (share[shell] > 0.5)  # the smaller part is turned over
    return Turned(np.where(flip[:, None], triangles[:, ::-1], triangles), int(flip.sum()), None)


def make_outward(points: Floats, triangles: Integers, shell: Integers) -> tuple[Integers, int]:
    """Turn over the shells of a closed, consistent surface that enclose a negative volume.

    A negative shell within the bounds of a larger one is a cavity and stays. If the whole is negative, all is turned
    first.

    Returns:
        The triangles, and the number of shells that were turned.
    """
    names, number = np.unique(shell, return_inverse=True)
    corners = points[triangles] - points.mean(axis=0)
    volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    enclosed = np.bincount(number, weights=volumes)
    turned = np.full(len(names), enclosed.sum() < 0.0)
    enclosed = np.where(turned, -enclosed, enclosed)
    if (enclosed < 0.0).any():
        low, high = np.full((len(names), 3), np.inf), np.full((len(names), 3), -np.inf)
        np.minimum.at(low, number, corners.min(axis=1))
        np.maximum.at(high, number, corners.max(axis=1))
        for k in np.flatnonzero(enclosed < 0.0):
            around = (low <= low[k]).all(axis=1) & (high >= high[k]).all(axis=1) & (enclosed > -enclosed[k])
            turned[k] ^= not around.any()
    flip = turned[number]
    return np.where(flip[:, None], triangles[:, ::-1], triangles), int(turned.sum())
