"""Unit quaternions (w, x, y, z), body to world, and rotation matrices; used at the door, not in loops."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation_from_quaternion(quaternion: Array) -> Array:
    """Rotation matrix (3,3), body to world, of a quaternion (4,) of any length but zero."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def quaternions_from_rotations(rotations: Array) -> Array:
    """Quaternions (n,4), w, x, y, z, of rotation matrices (n,3,3); the largest component is positive.

    Shepperd (1978): divide by the largest of the four components, so that no digit is lost.
    """
    trace = np.trace(rotations, axis1=1, axis2=2)
    diagonal = np.diagonal(rotations, axis1=1, axis2=2)
    squares = np.column_stack([1.0 + trace, 1.0 + 2.0 * diagonal - trace[:, None]])  # 4 w^2, 4 x^2, 4 y^2, 4 z^2
    differences = np.column_stack(
        [rotations[:, (i + 2) % 3, (i + 1) % 3] - rotations[:, (i + 1) % 3, (i + 2) % 3] for i in range(3)]
    )
    products = np.empty((len(rotations), 4, 4))  # four times the products of the components
    products[:, range(4), range(4)] = squares
    for i in range(3):
        products[:, 0, i + 1] = products[:, i + 1, 0] = differences[:, i]
        for j in range(i):
            products[:, i + 1, j + 1] = products[:, j + 1, i + 1] = rotations[:, i, j] + rotations[:, j, i]
    best: Array = products[np.arange(len(rotations)), np.argmax(squares, axis=1)]
    best /= np.linalg.norm(best, axis=1, keepdims=True)
    return best


def quaternion_product(p: Array, q: Array) -> Array:
    """Hamilton product of two quaternions (w, x, y, z): the turn q, then p."""
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *vector])


def quaternion_of(rotation: Array) -> Array:
    """Unit quaternion (w, x, y, z) of a rotation vector [rad], shape (3,)."""
    angle = float(np.linalg.norm(rotation))
    # sin(a/2)/a as numpy's sinc, which is exact at 0
    return np.array([np.cos(angle / 2), *(0.5 * np.sinc(angle / (2 * np.pi)) * rotation)])


def rotation_vector(quaternion: Array) -> Array:
    """Rotation vector [rad], shape (3,), of length at most pi, of a unit quaternion (w, x, y, z)."""
    if quaternion[0] < 0.0:
        quaternion = -quaternion
    sine = float(np.linalg.norm(quaternion[1:]))
    if sine == 0.0:
        return np.zeros(3)
    return np.asarray(2.0 * np.arctan2(sine, quaternion[0]) / sine * quaternion[1:])
