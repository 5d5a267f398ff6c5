"""The tree of oriented boxes over the triangles of one mesh, built from the root down.

A node's triangles are divided by the binned surface-area heuristic (16 bins on 3 axes); afterwards a box is fitted to
each node along the principal axes of its surface, or along the body's axes where that box is smaller. On a smooth patch
of width h such a box is only O(h^2) thick, so distant or nearly touching surfaces are told apart after few nodes
(Gottschalk, Lin, Manocha 1996).
"""

from math import sqrt

import numpy as np

from comotion_server.kernels.jit import jit

LEAF_SIZE = 2  # triangles; more means fewer nodes and more triangle pairs
BINS = 16  # planes tried per axis
DEEPEST = 48  # below this depth nodes are halved by count, so that no tree is deeper than DEEPEST + log2(triangles)
STACK_SIZE = 256  # of every traversal: above twice the deepest tree
PADDING = 1e-15  # of a box's reach: what its extents may be wrong by


@jit
def _half_area(low, high):
    x, y, z = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    return x * y + y * z + z * x


@jit
def _triangle_bounds(vertices, triangles, low, high):
    """Axis-aligned bounds of every triangle, (t, 3) each."""
    for t in range(len(triangles)):
        for k in range(3):
            a, b, c = vertices[triangles[t, 0], k], vertices[triangles[t, 1], k], vertices[triangles[t, 2], k]
            low[t, k] = min(a, b, c)
            high[t, k] = max(a, b, c)


@jit
def _grow(low, high, box_low, box_high):
    for k in range(3):
        low[k] = min(low[k], box_low[k])
        high[k] = max(high[k], box_high[k])


@jit
def _best_plane(order, first, count, low, high, work):
    """(axis, bin, origin, bins per length) of the cheapest division of a node; axis -1 where all centres coincide."""
    bin_low, bin_high, bin_count, right_cost, span_low, span_high = work
    best_cost = np.inf
    best = (-1, 0, 0.0, 0.0)
    for axis in range(3):
        least, most = np.inf, -np.inf
        for i in range(first, first + count):
            centre = low[order[i], axis] + high[order[i], axis]
            least = min(least, centre)
            most = max(most, centre)
        per_length = BINS / (most - least) if most > least else 0.0
        if not 0.0 < per_length < np.inf:
            continue
        bin_low[:] = np.inf
        bin_high[:] = -np.inf
        bin_count[:] = 0
        for i in range(first, first + count):
            t = order[i]
            b = min(int((low[t, axis] + high[t, axis] - least) * per_length), BINS - 1)
            bin_count[b] += 1
            _grow(bin_low[b], bin_high[b], low[t], high[t])
        span_low[:] = np.inf
        span_high[:] = -np.inf
        total = 0
        for b in range(BINS - 1, 0, -1):
            total += bin_count[b]
            _grow(span_low, span_high, bin_low[b], bin_high[b])
            right_cost[b] = _half_area(span_low, span_high) * total if total else np.inf
        span_low[:] = np.inf
        span_high[:] = -np.inf
        total = 0
        for b in range(BINS - 1):
            total += bin_count[b]
            _grow(span_low, span_high, bin_low[b], bin_high[b])
            if total and total < count:
                cost = _half_area(span_low, span_high) * total + right_cost[b + 1]
                if cost < best_cost:
                    best_cost = cost
                    best = (axis, b, least, per_length)
    return best


@jit
def _divide(order, first, count, low, high, depth, work):
    """Reorder a node's entries into two parts; the size of the first part."""
    if depth >= DEEPEST:
        return count // 2
    axis, last_bin, least, per_length = _best_plane(order, first, count, low, high, work)
    if axis < 0:
        return count // 2
    i, j = first, first + count - 1
    while i <= j:
        t = order[i]
        if min(int((low[t, axis] + high[t, axis] - least) * per_length), BINS - 1) <= last_bin:
            i += 1
        else:
            order[i] = order[j]
            order[j] = t
            j -= 1
    return i - first


@jit
def _principal_axes(S, axes):
    """Eigenvectors of the symmetric S (3, 3), as rows of `axes`, by Jacobi rotations; S is used up."""
    axes[:] = 0.0
    for k in range(3):
        axes[k, k] = 1.0
    for _ in range(12):
        off = abs(S[0, 1]) + abs(S[0, 2]) + abs(S[1, 2])
        if off <= 1e-15 * (abs(S[0, 0]) + abs(S[1, 1]) + abs(S[2, 2])):
            return
        for p in range(2):
            for q in range(p + 1, 3):
                if S[p, q] == 0.0:
                    continue
                theta = (S[q, q] - S[p, p]) / (2.0 * S[p, q])
                t = (1.0 if theta >= 0.0 else -1.0) / (abs(theta) + sqrt(theta * theta + 1.0))
                c = 1.0 / sqrt(t * t + 1.0)
                s = t * c
                for k in range(3):
                    a, b = S[k, p], S[k, q]
                    S[k, p], S[k, q] = c * a - s * b, s * a + c * b
                for k in range(3):
                    a, b = S[p, k], S[q, k]
                    S[p, k], S[q, k] = c * a - s * b, s * a + c * b
                    a, b = axes[p, k], axes[q, k]
                    axes[p, k], axes[q, k] = c * a - s * b, s * a + c * b


@jit
def _surface_covariance(vertices, triangles, order, first, count, origin, S):
    """Second moments of a node's surface about its centre of area; False where it has no area."""
    total = 0.0
    mean = np.zeros(3)
    S[:] = 0.0
    corner = np.empty((4, 3))
    for i in range(first, first + count):
        t = order[i]
        for k in range(3):
            for c in range(3):
                corner[c, k] = vertices[triangles[t, c], k] - origin[k]
            corner[3, k] = corner[0, k] + corner[1, k] + corner[2, k]
        ux, uy, uz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
        vx, vy, vz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
        area = sqrt((uy * vz - uz * vy) ** 2 + (uz * vx - ux * vz) ** 2 + (ux * vy - uy * vx) ** 2)
        total += area
        for k in range(3):
            mean[k] += area * corner[3, k] / 3.0
            for m in range(k + 1):
                moment = corner[0, k] * corner[0, m] + corner[1, k] * corner[1, m] + corner[2, k] * corner[2, m]
                S[k, m] += area * (moment + corner[3, k] * corner[3, m]) / 12.0
    if not total > 0.0:
        return False
    for k in range(3):
        for m in range(k + 1):
            S[k, m] -= mean[k] * mean[m] / total
            S[m, k] = S[k, m]
    return True


@jit
def _extent_along(vertices, triangles, order, first, count, origin, axes, low, high):
    """Bounds of a node's vertices, relative to `origin`, along the rows of `axes`."""
    low[:] = np.inf
    high[:] = -np.inf
    for i in range(first, first + count):
        for c in range(3):
            v = triangles[order[i], c]
            x, y, z = vertices[v, 0] - origin[0], vertices[v, 1] - origin[1], vertices[v, 2] - origin[2]
            for k in range(3):
                s = axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z
                low[k] = min(low[k], s)
                high[k] = max(high[k], s)


@jit
def _fit_box(vertices, triangles, order, first, count, low, high, work, centre, axes, half):
    """The smaller of the boxes along the principal and along the body's axes."""
    S, fitted, box_low, box_high, fit_low, fit_high, origin = work
    box_low[:] = np.inf
    box_high[:] = -np.inf
    for i in range(first, first + count):
        _grow(box_low, box_high, low[order[i]], high[order[i]])
    for k in range(3):
        origin[k] = 0.5 * (box_low[k] + box_high[k])
        centre[k] = origin[k]
        half[k] = 0.5 * (box_high[k] - box_low[k])
        for m in range(3):
            axes[k, m] = 1.0 if k == m else 0.0
    if _surface_covariance(vertices, triangles, order, first, count, origin, S):
        _principal_axes(S, fitted)
        _extent_along(vertices, triangles, order, first, count, origin, fitted, fit_low, fit_high)
        if _half_area(fit_low, fit_high) < _half_area(box_low, box_high):
            for k in range(3):
                half[k] = 0.5 * (fit_high[k] - fit_low[k])
                for m in range(3):
                    axes[k, m] = fitted[k, m]
                    centre[m] += 0.5 * (fit_low[k] + fit_high[k]) * fitted[k, m]
    reach = abs(centre[0]) + abs(centre[1]) + abs(centre[2]) + half[0] + half[1] + half[2]
    for k in range(3):
        half[k] += PADDING * reach


@jit
def build_hierarchy(vertices, triangles, order, centre, axes, half, child, first, count):
    """Build the tree of one mesh; the number of nodes.

    vertices (v, 3) [m], triangles (t, 3) into them; out: order (t,) the triangles in the order of the leaves; centre
    (n, 3), axes (n, 3, 3) as rows, half (n, 3), child, first, count (n,) as in MeshArrays, with room for n = 2 t - 1.
    """
    low, high = np.empty(triangles.shape), np.empty(triangles.shape)
    _triangle_bounds(vertices, triangles, low, high)
    bins = (np.empty((BINS, 3)), np.empty((BINS, 3)), np.empty(BINS, np.int64), np.empty(BINS))
    spans = (np.empty(3), np.empty(3))
    boxes = (np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3))
    depth = np.zeros(len(child), np.int64)
    for i in range(len(triangles)):
        order[i] = i
    first[0], count[0] = 0, len(triangles)
    node, nodes = 0, 1
    while node < nodes:
        begin, size = first[node], count[node]
        _fit_box(vertices, triangles, order, begin, size, low, high, boxes, centre[node], axes[node], half[node])
        child[node] = -1
        if size > LEAF_SIZE:
            part = _divide(order, begin, size, low, high, depth[node], bins + spans)
            child[node] = nodes
            first[nodes], count[nodes] = begin, part
            first[nodes + 1], count[nodes + 1] = begin + part, size - part
            depth[nodes] = depth[nodes + 1] = depth[node] + 1
            nodes += 2
        node += 1
    return nodes
