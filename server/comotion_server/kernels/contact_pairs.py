"""All pairs of triangles of two meshes within a distance, with their closest points: a walk down both trees."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.boxes import box_gap, divides_a
from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.jit import jit
from comotion_server.kernels.mesh_pair import corners, corners_moved
from comotion_server.kernels.triangle_distance import closer_points

MOST_PAIRS = 32768
FULL = -1  # in the place of a number: there are more than there is room for


class NearPairs(NamedTuple):
    """Pairs of triangles; points and directions in the axes of body a, from its centre."""

    triangles: np.ndarray  # (p,2) int64 of a, of b, over all shapes
    distance: np.ndarray  # (p,) [m]
    point_a: np.ndarray  # (p,3) [m]
    point_b: np.ndarray  # (p,3)
    direction: np.ndarray  # (p,3) unit, from a to b
    nodes: np.ndarray  # (STACK_SIZE,2) int64, of the walk


@jit
def new_near_pairs():
    """Room for the pairs of any two meshes."""
    return NearPairs(
        np.empty((MOST_PAIRS, 2), np.int64),
        np.empty(MOST_PAIRS),
        np.empty((MOST_PAIRS, 3)),
        np.empty((MOST_PAIRS, 3)),
        np.empty((MOST_PAIRS, 3)),
        np.empty((STACK_SIZE, 2), np.int64),
    )


@jit
def _compare(m, i, j, R, t, limit, near, count):
    """One pair of triangles; the new number of pairs, or FULL."""
    a0, a1, a2 = corners(m, i)
    b0, b1, b2 = corners_moved(m, j, R, t)
    distance, p, q, n = closer_points(limit, a0, a1, a2, b0, b1, b2)
    if distance > limit:
        return count
    if count == MOST_PAIRS:
        return FULL
    near.triangles[count, 0], near.triangles[count, 1], near.distance[count] = i, j, distance
    for k in range(3):
        near.point_a[count, k], near.point_b[count, k], near.direction[count, k] = p[k], q[k], n[k]
    return count + 1


@jit
def near_pairs(m, shape_a, shape_b, R, t, limit, near):
    """How many pairs of triangles are not farther apart than `limit` [m]; they are written to `near`; or FULL.

    R (3, 3) and t turn points y of body b's frame into body a's: R y + t.
    """
    nodes, top, count = near.nodes, 1, 0
    nodes[0, 0], nodes[0, 1] = m.root[shape_a], m.root[shape_b]
    while top > 0:
        top -= 1
        node_a, node_b = nodes[top, 0], nodes[top, 1]
        if box_gap(m, node_a, node_b, R, t, limit) > limit:
            continue
        if m.child[node_a] < 0 and m.child[node_b] < 0:
            for k in range(m.first[node_a], m.first[node_a] + m.entries[node_a]):
                for l in range(m.first[node_b], m.first[node_b] + m.entries[node_b]):
                    count = _compare(m, m.leaf_triangles[k], m.leaf_triangles[l], R, t, limit, near, count)
                    if count == FULL:
                        return FULL
        elif divides_a(m, node_a, node_b):
            nodes[top, 0], nodes[top, 1] = m.child[node_a], node_b
            nodes[top + 1, 0], nodes[top + 1, 1] = m.child[node_a] + 1, node_b
            top += 2
        else:
            nodes[top, 0], nodes[top, 1] = node_a, m.child[node_b]
            nodes[top + 1, 0], nodes[top + 1, 1] = node_a, m.child[node_b] + 1
            top += 2
    return count
