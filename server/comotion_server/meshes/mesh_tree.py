"""The trees of boxes over one mesh, in arrays of the right size."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from comotion_server.kernels.hierarchy import build_hierarchy
from comotion_server.kernels.lane_tree import fill_lanes, plan_lanes
from comotion_server.kernels.lanes import LANES, ROWS

if TYPE_CHECKING:
    from numpy.typing import NDArray


class BinaryTree(NamedTuple):
    """Nodes of two, as in MeshArrays."""

    centre: NDArray[np.float64]
    axes: NDArray[np.float64]
    half: NDArray[np.float64]
    child: NDArray[np.int64]
    first: NDArray[np.int64]
    entries: NDArray[np.int64]
    leaf_triangles: NDArray[np.int64]


class LaneTree(NamedTuple):
    """Nodes of eight, as in MeshArrays."""

    used: NDArray[np.int64]
    link: NDArray[np.int64]
    box: NDArray[np.float64]
    block: NDArray[np.float64]


def binary_tree(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> BinaryTree:
    """The tree of a mesh, vertices (v, 3) [m] and triangles (t, 3), down to one or two triangles."""
    room = 2 * len(triangles) - 1
    centre, axes, half = np.empty((room, 3)), np.empty((room, 3, 3)), np.empty((room, 3))
    child, first, entries = np.empty(room, np.int64), np.empty(room, np.int64), np.empty(room, np.int64)
    order = np.empty(len(triangles), np.int64)
    n = build_hierarchy(vertices, triangles, order, centre, axes, half, child, first, entries)
    return BinaryTree(centre[:n], axes[:n], half[:n], child[:n], first[:n], entries[:n], order)


def lane_tree(vertices: NDArray[np.float64], triangles: NDArray[np.int64], binary: BinaryTree) -> LaneTree:
    """The binary tree of a mesh regrouped into nodes of eight."""
    room = len(triangles) + 1
    source, link = np.zeros((room, LANES), np.int64), np.zeros((room, LANES), np.int64)
    used = np.empty(room, np.int64)
    nodes = plan_lanes(binary.child, binary.first, binary.entries, binary.half, source, link, used)
    link, used = link[:nodes], used[:nodes].copy()
    block, box = np.empty((nodes, ROWS, LANES)), np.zeros((LANES * nodes, 16))
    boxes = binary.centre, binary.axes, binary.half
    fill_lanes(vertices, triangles, binary.leaf_triangles, *boxes, source[:nodes], link, used, block, box)
    return LaneTree(used, link.ravel().copy(), box, block)
