"""The tree of boxes regrouped for `lanes`: every node has up to eight children, side by side in one block.

Made from the binary tree of `hierarchy` such that the boxes with nodes below them have the least area in all (dynamic
programming from the leaves up; Ylitie, Karras, Laine 2017). A *slot* is one lane of one node, 8 node + lane; it holds a
box and either a node below it or one triangle. Node 0 of a mesh has a single slot: the box of the whole.
"""

import numpy as np

from comotion_server.kernels.box_fit import PADDING
from comotion_server.kernels.jit import jit
from comotion_server.kernels.lanes import AXES, CENTRE, CORNERS, HALF, LANES
from comotion_server.kernels.triangle_distance import triangle_normal
from comotion_server.kernels.vectors import cross, dot, row, sub, unit

SIZE = 15  # column of a slot's box: the sum of its half lengths, by which the larger of two is known


@jit
def _costs(child, entries, half, cost, left):
    """The least cost of each binary node as at most i = 1 ... 8 slots, cost (n, 9), and how it is reached.

    The cost of a slot is the area of its box if there is a node below it, which is how often a walk enters that, and
    nothing if it holds one triangle. left (n, 9): the slots that go to the first child; 0: the node is one slot.
    """
    for node in range(len(child) - 1, -1, -1):
        x, y, z = half[node, 0], half[node, 1], half[node, 2]
        area, one = x * y + y * z + z * x, child[node]
        for i in range(LANES + 1):
            cost[node, i], left[node, i] = 0.0, 0
        if one < 0:
            cost[node, 1] = area if entries[node] == 2 else 0.0
            continue
        for i in range(2, LANES + 1):
            cost[node, i] = np.inf
            for k in range(1, i):
                together = cost[one, k] + cost[one + 1, i - k]
                if together < cost[node, i]:
                    cost[node, i], left[node, i] = together, k
        cost[node, 1] = area + cost[node, LANES]


@jit
def _parts(child, first, entries, left, whole, parts, shares):
    """The parts, at most eight, of one binary node: nodes, or ~entry for single triangles; how many there are."""
    parts[0], shares[0], count, done = whole, LANES, 1, 0
    while done < count:
        node, share = parts[done], shares[done]
        if node < 0:
            done += 1
        elif child[node] < 0 and (share > 1 or entries[node] == 1):
            parts[done] = ~first[node]
            if entries[node] == 2:
                parts[count] = ~(first[node] + 1)
                count += 1
        elif child[node] >= 0 and share > 1:
            parts[done], shares[done] = child[node], left[node, share]
            parts[count], shares[count] = child[node] + 1, share - left[node, share]
            count += 1
        else:
            done += 1
    return count


@jit
def plan_lanes(child, first, entries, half, source, link, used):
    """Divide a binary tree into nodes of eight; how many.

    Out: source (n, 8) the binary node of each slot, or ~entry of its triangle; link (n, 8) its node, or ~entry; used
    (n,) slots per node. Room for n = t + 1 nodes suffices for t triangles. Leaves hold one or two triangles.
    """
    cost, left = np.empty((len(child), LANES + 1)), np.empty((len(child), LANES + 1), np.int64)
    parts, shares = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    _costs(child, entries, half, cost, left)
    source[0, 0], used[0] = 0, 1
    if child[0] < 0 and entries[0] == 1:
        source[0, 0] = ~first[0]
    node, nodes = 0, 1
    while node < nodes:
        for lane in range(used[node]):
            whole = source[node, lane]
            if whole < 0:
                link[node, lane] = whole
                continue
            link[node, lane] = nodes
            used[nodes] = _parts(child, first, entries, left, whole, parts, shares)
            for k in range(used[nodes]):
                source[nodes, k] = parts[k]
            nodes += 1
        node += 1
    return nodes


@jit
def _triangle_axes(a, b, c):
    """The longest edge, the direction across it and the normal: the axes of the smallest box of a triangle."""
    u, v, w = sub(b, a), sub(c, b), sub(a, c)
    longest = u
    if dot(v, v) > dot(longest, longest):
        longest = v
    if dot(w, w) > dot(longest, longest):
        longest = w
    x, z = unit(longest), unit(triangle_normal(u, v))
    if dot(x, x) == 0.0:
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    if dot(z, z) == 0.0:
        z = unit(cross(x, (1.0, 0.0, 0.0) if abs(x[0]) < 0.5 else (0.0, 1.0, 0.0)))
    y = unit(cross(z, x))
    return x, y, cross(x, y)


@jit
def _span(axis, b, c):
    """(middle, half) of what a triangle with the corners 0, b, c covers along an axis."""
    p, q = dot(axis, b), dot(axis, c)
    low, high = min(0.0, p, q), max(0.0, p, q)
    return 0.5 * (low + high), 0.5 * (high - low)


@jit
def _triangle_box(vertices, triangles, t, box, corners):
    """The box (16,) of one triangle, and its corners (9,)."""
    a, b, c = row(vertices, triangles[t, 0]), row(vertices, triangles[t, 1]), row(vertices, triangles[t, 2])
    x, y, z = _triangle_axes(a, b, c)
    b_a, c_a = sub(b, a), sub(c, a)
    (mx, hx), (my, hy), (mz, hz) = _span(x, b_a, c_a), _span(y, b_a, c_a), _span(z, b_a, c_a)
    reach = abs(a[0]) + abs(a[1]) + abs(a[2]) + 2.0 * (hx + hy + hz)
    for k in range(3):
        box[CENTRE + k] = a[k] + (mx * x[k] + my * y[k] + mz * z[k])
        box[AXES + k], box[AXES + 3 + k], box[AXES + 6 + k] = x[k], y[k], z[k]
        corners[k], corners[3 + k], corners[6 + k] = a[k], b[k], c[k]
    box[HALF], box[HALF + 1], box[HALF + 2] = hx + PADDING * reach, hy + PADDING * reach, hz + PADDING * reach


@jit
def fill_lanes(vertices, triangles, order, centre, axes, half, source, link, used, blocks, boxes):
    """Fill in the boxes of a tree that `plan_lanes` laid out, and turn its links ~entry into ~triangle.

    order (t,): the triangles in the order of the binary tree's leaves. Out: blocks (n, ROWS, 8) as in `lanes`; boxes
    (8 n, 16): the same boxes, one row per slot.
    """
    corners = np.zeros(9)
    blocks[:] = 0.0
    for node in range(len(used)):
        for lane in range(used[node]):
            box, whole = boxes[LANES * node + lane], source[node, lane]
            if whole < 0:
                t = order[~whole]
                link[node, lane] = ~t
                _triangle_box(vertices, triangles, t, box, corners)
                for k in range(9):
                    blocks[node, CORNERS + k, lane] = corners[k]
            else:
                for k in range(3):
                    box[CENTRE + k], box[HALF + k] = centre[whole, k], half[whole, k]
                    for i in range(3):
                        box[AXES + 3 * k + i] = axes[whole, k, i]
            box[SIZE] = box[HALF] + box[HALF + 1] + box[HALF + 2]
            for k in range(SIZE):
                blocks[node, k, lane] = box[k]
