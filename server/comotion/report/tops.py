"""Free triaxial tops: integrators that comotion does not ship, to compare its own with, and a truth by Taylor series.

The unknown is the attitude R, body to world; the world angular momentum L is constant and w = I^-1 R^T L in the body
frame: R' = R w^. Steps are equal. Sources: Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 2000
(RKMK4; Lie-Euler); Celledoni, Marthinsen, Owren, Commutator-free Lie group methods, 2003 (CF4); Touma and Wisdom 1994,
Dullweber, Leimkuhler, McLachlan 1997 (splitting in three rotations).
"""

import numba
import numpy as np


@numba.njit
def product(A, B):
    """A B, (3,3)."""
    C = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]
    return C


@numba.njit
def rotation(u):
    """exp(u^) by Rodrigues' formula."""
    square = u[0] ** 2 + u[1] ** 2 + u[2] ** 2
    angle = np.sqrt(square)
    if angle < 1e-4:
        a, b = 1 - square / 6 + square**2 / 120, 0.5 - square / 24 + square**2 / 720
    else:
        a, b = np.sin(angle) / angle, 2 * np.sin(0.5 * angle) ** 2 / square
    x, y, z = u
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + a * K + b * product(K, K)


@numba.njit
def spin(R, L, I):
    """W = I^-1 R^T L."""
    w = np.empty(3)
    for k in range(3):
        w[k] = (R[0, k] * L[0] + R[1, k] * L[1] + R[2, k] * L[2]) / I[k]
    return w


@numba.njit
def cross(a, b):
    """A x b."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@numba.njit
def matrix_slope(R, L, I):
    """R w^."""
    x, y, z = spin(R, L, I)
    return product(R, np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))


@numba.njit
def matrix_rk4(R, L, I, h, n):
    """The classical Runge-Kutta method on the nine numbers of R."""
    for _ in range(n):
        k1 = matrix_slope(R, L, I)
        k2 = matrix_slope(R + 0.5 * h * k1, L, I)
        k3 = matrix_slope(R + 0.5 * h * k2, L, I)
        k4 = matrix_slope(R + h * k3, L, I)
        R = R + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return R


@numba.njit
def lie_euler(R, L, I, h, n):
    """R exp(h w^), order 1."""
    for _ in range(n):
        R = product(R, rotation(h * spin(R, L, I)))
    return R


@numba.njit
def lie_midpoint(R, L, I, h, n):
    """R exp(h w^) with w of the explicit midpoint, order 2."""
    for _ in range(n):
        middle = product(R, rotation(0.5 * h * spin(R, L, I)))
        R = product(R, rotation(h * spin(middle, L, I)))
    return R


@numba.njit
def rate_of_logarithm(u, w):
    """U' of R = R0 exp(u^), to the order that four stages need: w + u x w / 2 + u x (u x w) / 12."""
    first = cross(u, w)
    return w + 0.5 * first + cross(u, first) / 12


@numba.njit
def rkmk4(R, L, I, h, n):
    """Runge-Kutta, Munthe-Kaas, order 4."""
    for _ in range(n):
        k1 = spin(R, L, I)
        u = 0.5 * h * k1
        k2 = rate_of_logarithm(u, spin(product(R, rotation(u)), L, I))
        u = 0.5 * h * k2
        k3 = rate_of_logarithm(u, spin(product(R, rotation(u)), L, I))
        u = h * k3
        k4 = rate_of_logarithm(u, spin(product(R, rotation(u)), L, I))
        R = product(R, rotation(h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)))
    return R


@numba.njit
def commutator_free4(R, L, I, h, n):
    """CF4: products of exponentials of the stages, order 4."""
    for _ in range(n):
        k1 = spin(R, L, I)
        half = product(R, rotation(0.5 * h * k1))
        k2 = spin(half, L, I)
        k3 = spin(product(R, rotation(0.5 * h * k2)), L, I)
        k4 = spin(product(half, rotation(h * (k3 - 0.5 * k1))), L, I)
        R = product(R, rotation(h / 12 * (3 * k1 + 2 * k2 + 2 * k3 - k4)))
        R = product(R, rotation(h / 12 * (-k1 + 2 * k2 + 2 * k3 + 3 * k4)))
    return R


@numba.njit
def three_rotations(R, L, I, h, n):
    """Splitting: turns about the principal axes one after the other, there and back, order 2."""
    for _ in range(n):
        for k in (0, 1, 2, 1, 0):
            turn = np.zeros(3)
            turn[k] = (h if k == 2 else 0.5 * h) * spin(R, L, I)[k]
            R = product(R, rotation(turn))
    return R


OTHERS = {
    "RK4 on the matrix": matrix_rk4,
    "Lie-Euler": lie_euler,
    "Lie midpoint": lie_midpoint,
    "RKMK4": rkmk4,
    "CF4": commutator_free4,
    "three rotations": three_rotations,
}

TERMS = 24


def taylor(R: np.ndarray, L: np.ndarray, I: np.ndarray, duration: float, steps: int) -> np.ndarray:
    """R by its Taylor series in extended precision: l' = l x I^-1 l of the body's momentum, R' = R (I^-1 l)^."""
    wide = np.longdouble
    R, I, h = R.astype(wide), I.astype(wide), wide(duration) / steps
    L = L.astype(wide)
    for _ in range(steps):
        l, Q = [R.T @ L], [R]
        for n in range(TERMS):
            w = [part / I for part in l]
            l.append(sum(np.cross(l[i], w[n - i]) for i in range(n + 1)) / wide(n + 1))
            Q.append(sum(Q[i] @ _hat(w[n - i]) for i in range(n + 1)) / wide(n + 1))
        total = Q[-1]
        for term in Q[-2::-1]:
            total = term + h * total
        R = total
    return R


def _hat(w: np.ndarray) -> np.ndarray:
    x, y, z = w
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=np.longdouble)
