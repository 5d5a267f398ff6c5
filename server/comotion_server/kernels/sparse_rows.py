"""Rows of length one over the unknowns of many bodies, each over those of two at most, and the matrix I + A^T W A.

Only unknowns that some row has count: three of the six of a body where motion is plane.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.block_cholesky import PLANE, SPACE, add_outer, factorise
from comotion_server.kernels.jit import jit, lean_jit


class Part(NamedTuple):
    """m rows over k bodies, d unknowns each, bodies in the order of elimination."""

    link: np.ndarray  # (m,2) int64 places, or -1
    part: np.ndarray  # (m,2,d)
    bound: np.ndarray  # (m,)
    equal: np.ndarray  # (m,) bool


@jit
def unknowns_of(rows):
    """Three of the six unknowns of a body, ascending, where rows (m,2,6) have no others; else all."""
    has = np.zeros(SPACE, np.bool_)
    for i in range(len(rows)):
        for side in range(2):
            for k in range(SPACE):
                has[k] |= rows[i, side, k] != 0.0
    if has.sum() > PLANE:
        return np.arange(SPACE)
    for k in range(SPACE):
        has[k] |= has.sum() < PLANE
    return np.flatnonzero(has)


@jit
def part_of(link, rows, size, bound, equal, unknowns, order):
    """Rows (m,2,6) of norms size (m,) that join bodies link (m,2), over some unknowns (d,), bodies in `order` (k,)."""
    m, d, place = len(link), len(unknowns), np.empty(len(order), np.int64)
    for p in range(len(order)):
        place[order[p]] = p
    part = Part(np.full((m, 2), -1), np.empty((m, 2, d)), bound / size, equal)
    for i in range(m):
        for side in range(2):
            if link[i, side] >= 0:
                part.link[i, side] = place[link[i, side]]
            for n in range(d):
                part.part[i, side, n] = rows[i, side, unknowns[n]] / size[i]
    return part


@lean_jit
def times(part, y, out):
    """Product A y, out (m,)."""
    d = y.shape[1]
    for i in range(len(out)):
        out[i] = 0.0
        for side in range(2):
            j = part.link[i, side]
            if j >= 0:
                for k in range(d):
                    out[i] += part.part[i, side, k] * y[j, k]


@lean_jit
def add_transposed(part, l, y):
    """Adds A^T l to y (k,d)."""
    d = y.shape[1]
    for i in range(len(l)):
        if l[i] != 0.0:
            for side in range(2):
                j = part.link[i, side]
                if j >= 0:
                    for k in range(d):
                        y[j, k] += l[i] * part.part[i, side, k]


@lean_jit
def product(u, w):
    """Scalar product of u and w (k,d)."""
    total = 0.0
    for j in range(u.shape[0]):
        for k in range(u.shape[1]):
            total += u[j, k] * w[j, k]
    return total


@lean_jit
def norm(u):
    """Euclidean norm of u (k,d)."""
    return sqrt(product(u, u))


@lean_jit
def build(part, pattern, weight, factor):
    """The factor of I + A^T W A with weight (m,) >= 0."""
    D, B, d = factor.diagonal, factor.below, factor.diagonal.shape[1]
    D[:], B[:] = 0.0, 0.0
    for j in range(len(D)):
        for k in range(d):
            D[j, k, k] = 1.0
    for i in range(len(weight)):
        if weight[i] > 0.0:
            a, b = part.link[i]
            for side in range(2):
                if part.link[i, side] >= 0:
                    add_outer(part.part[i, side], part.part[i, side], weight[i], D[part.link[i, side]])
            if a > b >= 0:
                add_outer(part.part[i, 0], part.part[i, 1], weight[i], B[pattern.at[a, b]])
            elif b > a >= 0:
                add_outer(part.part[i, 1], part.part[i, 0], weight[i], B[pattern.at[b, a]])
    factorise(pattern, factor)
