"""Poses and directions as they come from outside, checked once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    Pose = Sequence[ArrayLike]

ORTHONORMAL = 1e-9  # what the entries of R^T R may differ from 1 and 0; more would be a stretched body
FARTHEST = 1e15  # [m] of a position, as of a mesh's vertices


class PoseError(ValueError):
    """A pose or a direction that is none; the message says which and why."""


def checked_pose(name: str, pose: Pose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(R (3, 3), x (3,)) of the pose called `name`, in arrays for the kernels."""
    try:
        rotation, position = pose
    except (TypeError, ValueError):
        raise PoseError(f"{name} must be (R, x), a rotation (3, 3) and a position (3,); got {pose!r}") from None
    R, x = _numbers(f"the rotation of {name}", rotation, (3, 3)), _numbers(f"the position of {name}", position, (3,))
    off = float(np.abs(R.T @ R - np.eye(3)).max())
    if off > ORTHONORMAL:
        raise PoseError(f"the rotation of {name} must be orthonormal; R^T R is {off:.3g} off the identity")
    if np.linalg.det(R) < 0.0:
        raise PoseError(f"the rotation of {name} must not mirror; its determinant is -1")
    if np.abs(x).max() > FARTHEST:
        raise PoseError(f"the position of {name} must lie within {FARTHEST:g} m; got {x.tolist()}")
    return R, x


def checked_direction(direction: ArrayLike) -> NDArray[np.float64]:
    """A direction (3,), world, of any length but zero."""
    d = _numbers("the direction", direction, (3,))
    size = float(np.abs(d).max())
    if size == 0.0:
        raise PoseError("the direction must not be zero; leave it out if there is none")
    return d / size


def _numbers(what: str, value: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    try:
        numbers = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise PoseError(f"{what} must be numbers of shape {shape}; got {value!r}") from None
    if numbers.shape != shape:
        raise PoseError(f"{what} must have shape {shape}; got {numbers.shape}")
    if not np.isfinite(numbers).all():
        raise PoseError(f"{what} must be finite; got {numbers.tolist()}")
    return numbers
