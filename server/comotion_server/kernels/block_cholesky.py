"""Sparse Cholesky factorisation of matrices I + A^T W A over a graph of contacts, in blocks of 3 or 6 unknowns a body.

The order is that of least degree, which keeps the fill of plane packings low. The pattern is found once; blocks change.

Legend: k bodies in the order of elimination; D diagonal blocks; B blocks below the diagonal, B[at[q, p]] for q > p.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit, lean_jit

EMPTY = -1
PLANE, SPACE = 3, 6  # unknowns of a body: how large blocks may be


class Pattern(NamedTuple):
    """Which blocks a factor has."""

    order: np.ndarray  # (k,) int64 body that is eliminated at each place
    at: np.ndarray  # (k,k) int32 block of places (q, p), q > p, or EMPTY
    later: np.ndarray  # int64 places q of the blocks of each column p, column after column
    first: np.ndarray  # (k + 1,) int64 where a column begins in `later`


class Factor(NamedTuple):
    """A matrix, and after `factorise` its factor."""

    diagonal: np.ndarray  # (k,d,d)
    below: np.ndarray  # (blocks,d,d)


@jit
def pattern_of(link, k):
    """The pattern for pairs link (m,2) of k bodies; -1 in a pair: nobody."""
    joined = np.zeros((k, k), np.bool_)
    for i in range(len(link)):
        a, b = link[i]
        if a >= 0 and b >= 0 and a != b:
            joined[a, b] = joined[b, a] = True
    degree, gone = joined.sum(axis=1), np.zeros(k, np.bool_)
    order, place, first = np.empty(k, np.int64), np.empty(k, np.int64), np.zeros(k + 1, np.int64)
    later, near = np.empty(k * (k + 1) // 2, np.int64), np.empty(k, np.int64)
    for p in range(k):
        chosen = -1
        for j in range(k):
            if not gone[j] and (chosen < 0 or degree[j] < degree[chosen]):
                chosen = j
        count = 0
        for j in range(k):
            if joined[chosen, j] and not gone[j]:
                near[count] = j
                count += 1
        for r in range(count):
            a = near[r]
            for s in range(r):
                if not joined[a, near[s]]:
                    joined[a, near[s]] = joined[near[s], a] = True
                    degree[a] += 1
                    degree[near[s]] += 1
            degree[a] -= 1
            later[first[p] + r] = a
        gone[chosen], order[p], place[chosen], first[p + 1] = True, chosen, p, first[p] + count
    later, at = later[: first[k]].copy(), np.full((k, k), EMPTY, np.int32)
    for p in range(k):
        for s in range(first[p], first[p + 1]):
            later[s] = place[later[s]]
            at[later[s], p] = s
    return Pattern(order, at, later, first)


@jit
def new_factor(pattern, d):
    """Room for a factor with d unknowns a body."""
    return Factor(np.empty((len(pattern.order), d, d)), np.empty((len(pattern.later), d, d)))


@lean_jit
def add_outer(a, b, s, block):
    """Adds s a b^T to a block (d,d)."""
    for i in range(len(a)):
        for j in range(len(a)):
            block[i, j] += s * a[i] * b[j]


@lean_jit
def subtract_blocks(B, s, r, C, t, d):
    """Subtracts the product B[s] B[r]^T of blocks (d,d) from C[t]."""
    for i in range(d):
        for j in range(d):
            total = C[t, i, j]
            for m in range(d):
                total -= B[s, i, m] * B[r, j, m]
            C[t, i, j] = total


@lean_jit
def subtract_product(B, s, r, C, t):
    """As `subtract_blocks`, for the sizes there are: loops of known length are unrolled."""
    if B.shape[1] == PLANE:
        subtract_blocks(B, s, r, C, t, PLANE)
    else:
        subtract_blocks(B, s, r, C, t, SPACE)


@lean_jit
def cholesky(block):
    """The lower factor of a positive block (d,d), in place."""
    d = len(block)
    for j in range(d):
        for m in range(j):
            block[j, j] -= block[j, m] ** 2
        block[j, j] = sqrt(block[j, j])
        for i in range(j + 1, d):
            for m in range(j):
                block[i, j] -= block[i, m] * block[j, m]
            block[i, j] /= block[j, j]


@lean_jit
def factorise(pattern, factor):
    """Turns the matrix into its factor; right-looking, column after column."""
    D, B, first, d = factor.diagonal, factor.below, pattern.first, factor.diagonal.shape[1]
    for p in range(len(D)):
        cholesky(D[p])
        for s in range(first[p], first[p + 1]):
            for i in range(d):
                for j in range(d):
                    for m in range(j):
                        B[s, i, j] -= B[s, i, m] * D[p, j, m]
                    B[s, i, j] /= D[p, j, j]
        for s in range(first[p], first[p + 1]):
            q = pattern.later[s]
            subtract_product(B, s, s, D, q)
            for r in range(first[p], s):
                o = pattern.later[r]
                if q > o:
                    subtract_product(B, s, r, B, pattern.at[q, o])
                else:
                    subtract_product(B, r, s, B, pattern.at[o, q])


@lean_jit
def solve(pattern, factor, u):
    """Solves with the factor in place, u (k,d) in the order of elimination."""
    D, B, first, d = factor.diagonal, factor.below, pattern.first, factor.diagonal.shape[1]
    for p in range(len(D)):
        for i in range(d):
            for j in range(i):
                u[p, i] -= D[p, i, j] * u[p, j]
            u[p, i] /= D[p, i, i]
        for s in range(first[p], first[p + 1]):
            for i in range(d):
                for j in range(d):
                    u[pattern.later[s], i] -= B[s, i, j] * u[p, j]
    for p in range(len(D) - 1, -1, -1):
        for s in range(first[p], first[p + 1]):
            for i in range(d):
                for j in range(d):
                    u[p, j] -= B[s, i, j] * u[pattern.later[s], i]
        for i in range(d - 1, -1, -1):
            for j in range(i + 1, d):
                u[p, i] -= D[p, j, i] * u[p, j]
            u[p, i] /= D[p, i, i]
