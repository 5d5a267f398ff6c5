"""The camera of the pictures: looks at a box from as near as shows all eight corners."""

from dataclasses import dataclass
from itertools import product
from typing import Self

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.picture import SIZE, VIEW_FROM, Box

VIEW_ANGLE = 30.0  # [degrees], of the picture's height
CENTRING = 8  # rounds of moving the box to the middle of the picture and coming nearer


@dataclass(frozen=True)
class Camera:
    """`eye` and `middle` [m], shape (3,); unit vectors `right` and `up` of the picture, and `away` towards the eye."""

    eye: NDArray[np.float64]
    middle: NDArray[np.float64]
    right: NDArray[np.float64]
    up: NDArray[np.float64]
    away: NDArray[np.float64]

    @classmethod
    def on(cls, box: Box) -> Self:
        """The camera on a box, z up."""
        low, high = box
        away = VIEW_FROM / np.linalg.norm(VIEW_FROM)
        right = np.cross([0.0, 0.0, 1.0], away)
        right /= np.linalg.norm(right)
        up = np.cross(away, right)
        corners = np.array(list(product(*zip(low, high, strict=True))))
        middle = (low + high) / 2
        slope = np.tan(np.radians(VIEW_ANGLE / 2))
        slopes = np.array([slope * SIZE[0] / SIZE[1], slope])
        for _ in range(CENTRING):
            arms = corners - middle
            across = np.stack([arms @ right, arms @ up], axis=1)
            depth = arms @ away
            distance = float(np.max(np.abs(across) / slopes + depth[:, None]))
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
