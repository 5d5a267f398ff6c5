"""Rotations as 3x3 matrices, body to world, changed in place.

Legend: R rotation (3,3); w rotation vector [rad], its length the angle.
"""

from math import cos, sin, sqrt

from comotion_server.kernels.jit import lean_jit

SMALL_ANGLE = 1e-4  # [rad] below it sin(a)/a and (1 - cos(a))/a^2 come from their series, right to rounding


@lean_jit
def rotate_left(R, wx, wy, wz):
    """R <- exp(w^) R (Rodrigues): turn the body about a world axis through its centre."""
    square = wx * wx + wy * wy + wz * wz
    if square == 0.0:
        return
    angle = sqrt(square)
    if angle < SMALL_ANGLE:
        s = 1.0 - square / 6.0
        c = 0.5 - square / 24.0
    else:
        half = sin(0.5 * angle)
        s = sin(angle) / angle
        c = 2.0 * half * half / square
    e00, e11, e22 = 1.0 - c * (wy * wy + wz * wz), 1.0 - c * (wx * wx + wz * wz), 1.0 - c * (wx * wx + wy * wy)
    e01, e10 = c * wx * wy - s * wz, c * wx * wy + s * wz
    e02, e20 = c * wx * wz + s * wy, c * wx * wz - s * wy
    e12, e21 = c * wy * wz - s * wx, c * wy * wz + s * wx
    for k in range(3):
        a, b, d = R[0, k], R[1, k], R[2, k]
        R[0, k] = e00 * a + e01 * b + e02 * d
        R[1, k] = e10 * a + e11 * b + e12 * d
        R[2, k] = e20 * a + e21 * b + e22 * d


@lean_jit
def rotate_about_column(R, axis, angle):
    """R <- R exp(angle e_axis^): turn the body about its own axis number `axis` (0, 1, 2)."""
    c, s = cos(angle), sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    for k in range(3):
        a, b = R[k, i], R[k, j]
        R[k, i] = c * a + s * b
        R[k, j] = c * b - s * a


@lean_jit
def orthonormalise(R):
    """One Newton step R <- R + R (I - R^T R) / 2: removes the rounding that products gather, quadratically.

    As a sum, whose small term keeps what rounding 3 I - R^T R would lose: long columns would be cut, short ones stay.
    """
    s0 = 0.5 * (1.0 - (R[0, 0] * R[0, 0] + R[1, 0] * R[1, 0] + R[2, 0] * R[2, 0]))
    s1 = 0.5 * (1.0 - (R[0, 1] * R[0, 1] + R[1, 1] * R[1, 1] + R[2, 1] * R[2, 1]))
    s2 = 0.5 * (1.0 - (R[0, 2] * R[0, 2] + R[1, 2] * R[1, 2] + R[2, 2] * R[2, 2]))
    s01 = 0.5 * (R[0, 0] * R[0, 1] + R[1, 0] * R[1, 1] + R[2, 0] * R[2, 1])
    s02 = 0.5 * (R[0, 0] * R[0, 2] + R[1, 0] * R[1, 2] + R[2, 0] * R[2, 2])
    s12 = 0.5 * (R[0, 1] * R[0, 2] + R[1, 1] * R[1, 2] + R[2, 1] * R[2, 2])
    for k in range(3):
        a, b, c = R[k, 0], R[k, 1], R[k, 2]
        R[k, 0] = a + (a * s0 - b * s01 - c * s02)
        R[k, 1] = b + (b * s1 - a * s01 - c * s12)
        R[k, 2] = c + (c * s2 - a * s02 - b * s12)


@lean_jit
def product(A, B, out):
    """The product A B (3,3) in `out`; numba's own operator would need scipy's BLAS."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@lean_jit
def relative_rotation(rotation_a, rotation_b, R):
    """R = rotation_a^T rotation_b: from body b's frame to body a's."""
    for i in range(3):
        for j in range(3):
            R[i, j] = (
                rotation_a[0, i] * rotation_b[0, j]
                + rotation_a[1, i] * rotation_b[1, j]
                + rotation_a[2, i] * rotation_b[2, j]
            )
