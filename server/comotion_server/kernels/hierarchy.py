"""The tree of boxes over the triangles of one mesh: divided from the root down, fitted with boxes from the leaves up.

A node's triangles are divided by the binned surface-area heuristic (at most 16 bins on 3 axes); afterwards each node
gets an oriented box (`box_fit`). On a smooth patch of width h such a box is only O(h^2) thick, so distant or nearly
touching surfaces are told apart after few nodes (Gottschalk, Lin, Manocha 1996).
"""

import numpy as np

from comotion_server.kernels.box_fit import fit_box, half_area, triangle_moments
from comotion_server.kernels.jit import jit

LEAF_SIZE = 2  # triangles; more means fewer nodes and more triangle pairs
BINS = 16  # planes tried per axis, at most as many as triangles
LEAST_BINS = 4
DEEPEST = 48  # below this depth nodes are halved by count, so that no tree is deeper than DEEPEST + log2(triangles)
STACK_SIZE = 256  # of every traversal: above twice the deepest tree


@jit
def _triangle_bounds(vertices, triangles, bounds):
    """Axis-aligned bounds of every triangle, (t, 6): the least x, y, z, then the greatest."""
    for t in range(len(triangles)):
        for k in range(3):
            a, b, c = vertices[triangles[t, 0], k], vertices[triangles[t, 1], k], vertices[triangles[t, 2], k]
            bounds[t, k] = min(a, b, c)
            bounds[t, 3 + k] = max(a, b, c)


@jit
def _grow(spans, i, others, j):
    """Extend the bounds in row i of `spans` by those in row j of `others`."""
    for k in range(3):
        spans[i, k] = min(spans[i, k], others[j, k])
        spans[i, 3 + k] = max(spans[i, 3 + k], others[j, 3 + k])


@jit
def _clear(spans, begin, end):
    """Bounds of nothing in some rows."""
    for i in range(begin, end):
        for k in range(3):
            spans[i, k], spans[i, 3 + k] = np.inf, -np.inf


@jit
def _area(spans, i):
    return half_area(spans[i, 3] - spans[i, 0], spans[i, 4] - spans[i, 1], spans[i, 5] - spans[i, 2])


@jit
def _fill_bins(bounds, first, count, bins, scale, spans, numbers):
    """Sort a node's entries into bins on all three axes at once; axis k has the rows from k BINS on.

    scale (3, 2): least centre (twice), and bins per length or 0 for an axis that cannot divide.
    """
    for k in range(3):
        least, most = np.inf, -np.inf
        for i in range(first, first + count):
            centre = bounds[i, k] + bounds[i, 3 + k]
            least, most = min(least, centre), max(most, centre)
        per_length = bins / (most - least) if most > least else 0.0
        scale[k, 0], scale[k, 1] = least, per_length if per_length < np.inf else 0.0
        _clear(spans, k * BINS, k * BINS + bins)
        for b in range(k * BINS, k * BINS + bins):
            numbers[b] = 0
    for i in range(first, first + count):
        for k in range(3):
            b = k * BINS + min(int((bounds[i, k] + bounds[i, 3 + k] - scale[k, 0]) * scale[k, 1]), bins - 1)
            numbers[b] += 1
            _grow(spans, b, bounds, i)


@jit
def _best_plane(bounds, first, count, bins, scale, spans, numbers, costs):
    """(axis, bin) of the cheapest division of a node; axis -1 where all centres coincide."""
    _fill_bins(bounds, first, count, bins, scale, spans, numbers)
    spare, best_cost, best_axis, best_bin = 3 * BINS, np.inf, -1, 0
    for axis in range(3):
        if scale[axis, 1] == 0.0:
            continue
        row, total = axis * BINS, 0
        _clear(spans, spare, spare + 1)
        for b in range(bins - 1, 0, -1):
            total += numbers[row + b]
            _grow(spans, spare, spans, row + b)
            costs[b] = _area(spans, spare) * total if total else np.inf
        total = 0
        _clear(spans, spare, spare + 1)
        for b in range(bins - 1):
            total += numbers[row + b]
            _grow(spans, spare, spans, row + b)
            if total and total < count:
                cost = _area(spans, spare) * total + costs[b + 1]
                if cost < best_cost:
                    best_cost, best_axis, best_bin = cost, axis, b
    return best_axis, best_bin


@jit
def _swap(order, bounds, i, j):
    order[i], order[j] = order[j], order[i]
    for k in range(6):
        bounds[i, k], bounds[j, k] = bounds[j, k], bounds[i, k]


@jit
def _divide(order, bounds, first, count, depth, scale, spans, numbers, costs):
    """Reorder a node's entries into two parts; the size of the first part."""
    if depth >= DEEPEST:
        return count // 2
    bins = min(BINS, max(LEAST_BINS, count))
    axis, last_bin = _best_plane(bounds, first, count, bins, scale, spans, numbers, costs)
    if axis < 0:
        return count // 2
    least, per_length = scale[axis, 0], scale[axis, 1]
    i, j = first, first + count - 1
    while i <= j:
        if min(int((bounds[i, axis] + bounds[i, 3 + axis] - least) * per_length), bins - 1) <= last_bin:
            i += 1
        else:
            _swap(order, bounds, i, j)
            j -= 1
    return i - first


@jit
def _divide_all(order, bounds, child, first, count):
    """Lay out all nodes from the root down; how many there are."""
    scale, costs = np.empty((3, 2)), np.empty(BINS)
    spans, numbers = np.empty((3 * BINS + 1, 6)), np.empty(3 * BINS, np.int64)
    depth = np.zeros(len(child), np.int64)
    first[0], count[0] = 0, len(order)
    node, nodes = 0, 1
    while node < nodes:
        child[node] = -1
        if count[node] > LEAF_SIZE:
            part = _divide(order, bounds, first[node], count[node], depth[node], scale, spans, numbers, costs)
            child[node] = nodes
            first[nodes], count[nodes] = first[node], part
            first[nodes + 1], count[nodes + 1] = first[node] + part, count[node] - part
            depth[nodes] = depth[nodes + 1] = depth[node] + 1
            nodes += 2
        node += 1
    return nodes


@jit
def _fit_all(corners, bounds, child, first, count, centre, axes, half):
    """Fit the boxes of all nodes from the leaves up, so that bounds and moments are added up and not found again."""
    spans, moments, one = np.empty((len(child), 6)), np.zeros((len(child), 10)), np.empty(10)
    room = (np.empty((3, 3)), np.empty((3, 3)))
    _clear(spans, 0, len(child))
    for node in range(len(child) - 1, -1, -1):
        if child[node] < 0:
            for i in range(first[node], first[node] + count[node]):
                _grow(spans, node, bounds, i)
                triangle_moments(corners, 3 * i, one)
                for k in range(10):
                    moments[node, k] += one[k]
        else:
            for part in range(child[node], child[node] + 2):
                _grow(spans, node, spans, part)
                for k in range(10):
                    moments[node, k] += moments[part, k]
        begin, end = 3 * first[node], 3 * (first[node] + count[node])
        fit_box(corners, begin, end, spans, moments, node, room, centre, axes, half)


@jit
def build_hierarchy(vertices, triangles, order, centre, axes, half, child, first, count):
    """Build the tree of one mesh; the number of nodes.

    vertices (v, 3) [m], triangles (t, 3) into them; out: order (t,) the triangles in the order of the leaves; centre
    (n, 3), axes (n, 3, 3) as rows, half (n, 3), child, first, count (n,) as in MeshArrays, with room for n = 2 t - 1.
    """
    bounds = np.empty((len(triangles), 6))
    _triangle_bounds(vertices, triangles, bounds)
    for i in range(len(triangles)):
        order[i] = i
    nodes = _divide_all(order, bounds, child, first, count)
    corners = np.empty((3 * len(order), 3))
    for i in range(len(order)):
        for c in range(3):
            for k in range(3):
                corners[3 * i + c, k] = vertices[triangles[order[i], c], k]
    _fit_all(corners, bounds, child[:nodes], first, count, centre, axes, half)
    return nodes
