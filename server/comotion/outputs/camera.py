"""The camera of the pictures: looks at points from as near as shows them all."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.picture import SIZE, VIEW_FROM

VIEW_ANGLE = 30.0  # [degrees], of the picture's height
MARGIN = 0.92  # part of the picture, from its middle, in which the points are
CENTRING = 8  # rounds of moving the points to the middle of the picture and coming nearer


@dataclass(frozen=True)
class Camera:
    """`eye` and `middle` [m], shape (3,); unit vectors `right` and `up` of the picture, and `away` towards the eye."""

    eye: NDArray[np.float64]
    middle: NDArray[np.float64]
    right: NDArray[np.float64]
    up: NDArray[np.float64]
    away: NDArray[np.float64]

    @classmethod
    def on(cls, points: NDArray[np.float64]) -> Self:
        """The camera on points [m], shape (n, 3), z up."""
        away = VIEW_FROM / np.linalg.norm(VIEW_FROM)
        right = np.cross([0.0, 0.0, 1.0], away)
        right /= np.linalg.norm(right)
        up = np.cross(away, right)
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        slope = np.tan(np.radians(VIEW_ANGLE / 2))
        slopes = np.array([slope * SIZE[0] / SIZE[1], slope])
        for _ in range(CENTRING):
            arms = points - middle
            across = np.stack([arms @ right, arms @ up], axis=1)
            depth = arms @ away
            distance = float(np.max(np.abs(across) / (MARGIN * slopes) + depth[:, None]))
            seen = across / (distance - depth)[:, None]
            shift = (seen.min(axis=0) + seen.max(axis=0)) / 2 * distance
            middle = middle + shift[0] * right + shift[1] * up
        return cls(middle + distance * away, middle, right, up, away)

    def pixel(self, point: NDArray[np.float64]) -> tuple[float, float] | None:
        """Where a point [m] is in the picture, from its upper left corner; None behind the camera."""
        arm = point - self.eye
        depth = -float(arm @ self.away)
        if depth <= 0.0:
            return None
        scale = SIZE[1] / (2.0 * np.tan(np.radians(VIEW_ANGLE / 2)) * depth)
        return float(SIZE[0] / 2 + scale * (arm @ self.right)), float(SIZE[1] / 2 - scale * (arm @ self.up))
