"""All shapes of a scene in one bundle of flat arrays: what every mesh kernel takes as its first argument."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class MeshArrays(NamedTuple):
    """Shapes one behind the other; indices inside an array count over all shapes, those in a result within one shape.

    Everything is in the body frame [m], C-contiguous, float64 or int64 (flags uint8). Shape s owns vertices
    `vertex_start[s] : vertex_start[s + 1]`, likewise triangles; its tree's root is node `root[s]`.
    """

    vertices: NDArray[np.float64]  # (v, 3)
    triangles: NDArray[np.int64]  # (t, 3) into vertices, counter-clockwise seen from outside
    normals: NDArray[np.float64]  # (t, 3) unit, outward; zero for a triangle without area
    sharp: NDArray[np.uint8]  # (t, 3) whether the edge from corner k to k + 1 is a crease or a border
    star_start: NDArray[np.int64]  # (v + 1,) into star
    star: NDArray[np.int64]  # (3 t,) the triangles around each vertex
    vertex_start: NDArray[np.int64]  # (shapes + 1,)
    triangle_start: NDArray[np.int64]  # (shapes + 1,)
    root: NDArray[np.int64]  # (shapes,)
    centre: NDArray[np.float64]  # (n, 3) centres of the nodes' boxes
    axes: NDArray[np.float64]  # (n, 3, 3) their axes, as rows
    half: NDArray[np.float64]  # (n, 3) their half lengths along the axes
    child: NDArray[np.int64]  # (n,) first of the two children, which lie side by side; -1: a leaf
    first: NDArray[np.int64]  # (n,) first entry of the node in leaf_triangles
    entries: NDArray[np.int64]  # (n,) how many entries: the node's triangles
    leaf_triangles: NDArray[np.int64]  # (t,) triangles in the order of the leaves
    top: NDArray[np.int64]  # (shapes,) the slot that holds the whole shape: see `lane_tree`
    used: NDArray[np.int64]  # (l,) slots in use of each node of eight
    link: NDArray[np.int64]  # (8 l,) of each slot: the node of eight below it, or ~triangle
    box: NDArray[np.float64]  # (8 l, 16) of each slot: centre, axes, half, and the sum of half
    block: NDArray[np.float64]  # (l, 24, 8) of each node of eight: its boxes and triangles, side by side
    size: NDArray[np.float64]  # (shapes,) diameter of the sphere about the body's origin
