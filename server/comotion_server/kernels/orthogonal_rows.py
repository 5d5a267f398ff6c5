"""A thin QR factorisation that gains and loses rows: A_active^T = Q R, with Q never formed from A A^T.

Gram-Schmidt done twice keeps Q orthonormal to rounding (Giraud, Langou, Rozloznik 2005, "The loss of orthogonality in
the Gram-Schmidt orthogonalization process"); Givens rotations take a row out (Daniel, Gragg, Kaufman, Stewart 1976).

Legend: a a row (n,), h = Q^T a its part in the span, z = a - Q h its part outside, u solutions with R or R^T.
"""

from math import hypot
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit


class Factors(NamedTuple):
    """Room for `room` active rows of n numbers."""

    basis: np.ndarray  # (room,n) orthonormal: column j of Q is row j here
    triangle: np.ndarray  # (room,room) upper triangular R
    rows: np.ndarray  # (room,) int64 the active rows, in the order they came


@jit
def new_factors(room, n):
    """An empty factorisation."""
    return Factors(np.empty((room, n)), np.zeros((room, room)), np.empty(room, np.int64))


@jit
def inner(a, b):
    """Scalar product of two vectors (n,)."""
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@jit
def advance(y, s, a):
    """Adds s a to y (n,)."""
    for k in range(len(y)):
        y[k] += s * a[k]


@jit
def split_row(factors, count, a, h, z):
    """Writes h (count,) and z (n,) of row a; returns z.z."""
    z[:] = a
    h[:count] = 0.0
    for _ in range(2):
        for j in range(count):
            s = inner(factors.basis[j], z)
            h[j] += s
            advance(z, -s, factors.basis[j])
    return inner(z, z)


@jit
def append_row(factors, count, row, h, z, size):
    """Takes in a row whose parts are h and z, |z| = size; returns the new count."""
    for j in range(count):
        factors.triangle[j, count] = h[j]
    factors.triangle[count, count] = size
    for k in range(len(z)):
        factors.basis[count, k] = z[k] / size
    factors.rows[count] = row
    return count + 1


@jit
def remove_row(factors, count, place):
    """Takes out the active row at `place`; returns the new count."""
    Q, R = factors.basis, factors.triangle
    for j in range(place, count - 1):
        factors.rows[j] = factors.rows[j + 1]
        for i in range(j + 2):
            R[i, j] = R[i, j + 1]
    for j in range(place, count - 1):
        r = hypot(R[j, j], R[j + 1, j])
        c, s = R[j, j] / r, R[j + 1, j] / r
        for i in range(j, count - 1):
            R[j, i], R[j + 1, i] = c * R[j, i] + s * R[j + 1, i], c * R[j + 1, i] - s * R[j, i]
        for k in range(Q.shape[1]):
            Q[j, k], Q[j + 1, k] = c * Q[j, k] + s * Q[j + 1, k], c * Q[j + 1, k] - s * Q[j, k]
    return count - 1


@jit
def solve_back(factors, count, u):
    """Solves R u = u in place, u (count,)."""
    for j in range(count - 1, -1, -1):
        u[j] /= factors.triangle[j, j]
        for i in range(j):
            u[i] -= u[j] * factors.triangle[i, j]


@jit
def solve_forward(factors, count, u):
    """Solves R^T u = u in place, u (count,)."""
    for j in range(count):
        for i in range(j):
            u[j] -= u[i] * factors.triangle[i, j]
        u[j] /= factors.triangle[j, j]
