"""Which pairs of bodies may come close at all: a grid per size class, linear in the number of bodies.

A class holds the bodies whose spheres (radius and reach) are alike within a factor of two, and has a grid of cells as
wide as its largest sphere; so spheres of one class that meet lie in neighbouring cells, and so do those of a finer
class with those of this one. Cells are numbered along x, then y, then z, and bodies sorted by their cells: the three
cells beside each other in a row are then one stretch of the sorted list, and its ends move on only forwards as the
bodies are gone through in order. Where there are not too many cells a table of their beginnings is quicker; otherwise
none is needed, so bodies may lie as far apart as they like. A class of few bodies (a hull, the banks) is compared with
all finer ones directly. A body's name is its index, or ~index if it does not react.
"""

from math import frexp

import numpy as np

from comotion_server.kernels.jit import jit
from comotion_server.kernels.radix_sort import sort_by_key

FORWARD, BOTH_WAYS = True, False
CLASSES = 2200  # binary exponents of a double and some
MOST_CELLS = 1 << 20  # along an axis, so that a cell's number has 62 bits
LOOSE = 1.0 + 1e-9  # of a cell's width: what rounding may move a body across its border
TABLE = 8  # cells per body up to which a table of cells is made
FEW = 8  # bodies of a class that are compared with all finer ones directly


@jit
def _classes(radius, reach, order, begin):
    """Sort bodies by size class, coarse ones last: order (n,), and begin (k + 1,) of each class; returns k."""
    count = np.zeros(CLASSES, np.int64)
    for i in range(len(radius)):
        size = max(radius[i] + reach[i], 1e-300)
        count[1050 + frexp(size)[1]] += 1
    classes, total = 0, 0
    for c in range(CLASSES):
        if count[c] > 0:
            begin[classes], classes = total, classes + 1
            total, count[c] = total + count[c], total
    begin[classes] = total
    for i in range(len(radius)):
        c = 1050 + frexp(max(radius[i] + reach[i], 1e-300))[1]
        order[count[c]] = i
        count[c] += 1
    return classes


@jit
def _grid(spheres, low, high, dims):
    """Width [m] of the cells for some spheres (k, 4), and how many there are along each axis, to dims (3,)."""
    widest = 0.0
    for i in range(len(spheres)):
        widest = max(widest, spheres[i, 3])
    width = 2.0 * widest * LOOSE
    for k in range(3):
        width = max(width, (high[k] - low[k]) / MOST_CELLS)
    if not width > 0.0:
        width = 1.0
    for k in range(3):
        dims[k] = int((high[k] - low[k]) / width) + 3  # and an empty one at either end, so that rows do not run on
    return width


@jit
def _by_table(keys, cells, start, who, sorted_keys):
    """Sort by cell: start (cells + 1,) where each begins, who (k,) and the keys in order."""
    start[:] = 0
    for i in range(len(keys)):
        start[keys[i] + 1] += 1
    for cell in range(cells):
        start[cell + 1] += start[cell]
    for i in range(len(keys)):
        place = start[keys[i]]
        who[place], sorted_keys[place] = i, keys[i]
        start[keys[i]] += 1
    for cell in range(cells, 0, -1):
        start[cell] = start[cell - 1]
    start[0] = 0


@jit
def _by_cell(spheres, names, low, width, dims):
    """(keys, spheres, names) sorted by their cells, and where each cell begins: nothing if they are too many."""
    keys, who = np.empty(len(names), np.int64), np.empty(len(names), np.int64)
    for i in range(len(names)):
        x = int((spheres[i, 0] - low[0]) / width) + 1
        y = int((spheres[i, 1] - low[1]) / width) + 1
        z = int((spheres[i, 2] - low[2]) / width) + 1
        keys[i] = (z * dims[1] + y) * dims[0] + x
    cells = dims[0] * dims[1] * dims[2]
    start = np.empty(cells + 1 if cells <= TABLE * len(names) else 0, np.int32)
    if len(start) > 0:
        sorted_keys = np.empty(len(names), np.int64)
        _by_table(keys, cells, start, who, sorted_keys)
        keys = sorted_keys
    else:
        for i in range(len(names)):
            who[i] = i
        sort_by_key(keys, who, cells)
    placed, placed_names = np.empty((len(names), 4)), np.empty(len(names), np.int64)
    for i in range(len(names)):
        placed_names[i] = names[who[i]]
        for k in range(4):
            placed[i, k] = spheres[who[i], k]
    return keys, placed, placed_names, start


@jit
def _compare(sphere_a, name_a, sphere_b, name_b, pairs, count):
    """Note a pair of spheres, if they meet and one of them reacts; how many there are now. Without branches."""
    x, y, z = sphere_a[0] - sphere_b[0], sphere_a[1] - sphere_b[1], sphere_a[2] - sphere_b[2]
    far = sphere_a[3] + sphere_b[3]
    meets = (x * x + y * y + z * z <= far * far) & ((name_a >= 0) | (name_b >= 0))
    place = min(count, len(pairs) - 1)
    pairs[place, 0], pairs[place, 1] = name_a, name_b
    return count + (1 if meets else 0)


@jit
def _sphere(spheres, i):
    return spheres[i, 0], spheres[i, 1], spheres[i, 2], spheres[i, 3]


@jit
def _rows(keys, spheres, names, other_keys, others, other_names, start, shifts, forward, pairs, count):
    """Pairs of spheres with those of the three cells around key + shift, for all shifts; how many there are now.

    forward: both lists are the same, the first shift is 0, and there only what comes later in the list is looked at.
    """
    begin, end = np.zeros(len(shifts), np.int64), np.zeros(len(shifts), np.int64)
    for i in range(len(keys)):
        sphere = _sphere(spheres, i)
        for s in range(len(shifts)):
            cell = keys[i] + shifts[s]
            if len(start) > 0:
                one, two = start[cell - 1], start[cell + 2]
            else:
                one, two = begin[s], end[s]
                while one < len(other_keys) and other_keys[one] < cell - 1:
                    one += 1
                while two < len(other_keys) and other_keys[two] <= cell + 1:
                    two += 1
                begin[s], end[s] = one, two
            if forward and s == 0:
                one = i + 1
            for j in range(one, two):
                count = _compare(sphere, names[i], _sphere(others, j), other_names[j], pairs, count)
    return count


@jit
def _within(spheres, names, low, high, pairs, count):
    """Pairs within one class."""
    dims = np.empty(3, np.int64)
    width = _grid(spheres, low, high, dims)
    row, layer = dims[0], dims[0] * dims[1]
    keys, spheres, names, start = _by_cell(spheres, names, low, width, dims)
    shifts = np.array([0, row, layer - row, layer, layer + row])
    return _rows(keys, spheres, names, keys, spheres, names, start, shifts, FORWARD, pairs, count)


@jit
def _across(fine, fine_names, spheres, names, low, high, pairs, count):
    """Pairs of one class with all finer ones."""
    dims = np.empty(3, np.int64)
    width = _grid(spheres, low, high, dims)
    row, layer = dims[0], dims[0] * dims[1]
    keys, spheres, names, start = _by_cell(spheres, names, low, width, dims)
    fine_keys, fine, fine_names, _ = _by_cell(fine, fine_names, low, width, dims)
    shifts = np.array([-layer - row, -layer, -layer + row, -row, 0, row, layer - row, layer, layer + row])
    return _rows(fine_keys, fine, fine_names, keys, spheres, names, start, shifts, BOTH_WAYS, pairs, count)


@jit
def _directly(fine, fine_names, spheres, names, pairs, count):
    """Pairs of a class of few with all finer ones."""
    for i in range(len(names)):
        sphere = _sphere(spheres, i)
        for j in range(len(fine)):
            count = _compare(sphere, names[i], _sphere(fine, j), fine_names[j], pairs, count)
    return count


@jit
def _in_order(pairs, bodies):
    """Sort pairs (k, 2) of names by their bodies."""
    keys, order = np.empty(len(pairs), np.int64), np.empty(len(pairs), np.int64)
    for i in range(len(pairs)):
        a, b = pairs[i, 0], pairs[i, 1]
        a, b = a if a >= 0 else ~a, b if b >= 0 else ~b
        keys[i], order[i] = min(a, b) * bodies + max(a, b), i
    sort_by_key(keys, order, bodies * bodies)
    for i in range(len(pairs)):
        pairs[i, 0], pairs[i, 1] = keys[i] // bodies, keys[i] % bodies


@jit
def pairs_in_reach(x, radius, reach, reacts, pairs):
    """Pairs of bodies whose bounding spheres may meet, in order, to `pairs` (k,2); returns how many there are.

    x (n,3) [m] centres; radius (n,) of the spheres; `reach` (n,) is how far each body's points may move. A pair of
    which neither body reacts (n,) is none. When `pairs` is too small, what is in it means nothing.
    """
    n, count = len(radius), 0
    if n == 0:
        return 0
    order, begin = np.empty(n, np.int64), np.empty(CLASSES, np.int64)
    spheres, low, high = np.empty((n, 4)), np.full(3, np.inf), np.full(3, -np.inf)
    classes = _classes(radius, reach, order, begin)
    for i in range(n):
        body = order[i]
        for k in range(3):
            spheres[i, k] = x[body, k]
            low[k], high[k] = min(low[k], x[body, k]), max(high[k], x[body, k])
        spheres[i, 3] = radius[body] + reach[body]
        order[i] = body if reacts[body] else ~body
    room = pairs if len(pairs) > 0 else np.empty((1, 2), np.int64)
    for c in range(classes):
        one, end = begin[c], begin[c + 1]
        fine, fine_names, own, names = spheres[:one], order[:one], spheres[one:end], order[one:end]
        count = _within(own, names, low, high, room, count)
        if end - one <= FEW:
            count = _directly(fine, fine_names, own, names, room, count)
        elif one > 0:
            count = _across(fine, fine_names, own, names, low, high, room, count)
    if count <= len(pairs):
        _in_order(pairs[:count], n)
    return count
