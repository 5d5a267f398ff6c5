"""The camera of the pictures: looks at a box from as near as shows all eight corners."""

from dataclasses import dataclass
from itertools import product
from typing import Self

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.picture import SIZE, VIEW_FROM, Box

VIEW_ANGLE = 30.0  # [degrees], of the picture's height


@dataclass(frozen=True)
class Camera:
    """`eye` and `middle` [m], shape (3,); `right`, `up` and `away` are unit vectors of the picture and towards the eye."""

    eye: NDArray[np.float64]
    middle: NDArray[np.float64]
    right: NDArray[np.float64]
    up: NDArray[np.float64]
    away: NDArray[np.float64]

    @classmethod
    def on(cls, box: Box) -> Self:
        """The camera on a box, z up."""
        low, high = box
        middle = (low + high) / 2
        away = VIEW_FROM / np.linalg.norm(VIEW_FROM)
        right = np.cross([0.0, 0.0, 1.0], away)
        right /= np.linalg.norm(right)
        up = np.cross(away, right)
        corners = np.array(list(product(*zip(low - middle, high - middle, strict=True))))
        slope = np.tan(np.radians(VIEW_ANGLE / 2))
        heights = np.abs(corners @ up) / slope
        widths = np.abs(corners @ right) / (slope * SIZE[0] / SIZE[1])
        distance = np.max(np.maximum(heights, widths) + corners @ away)
        return cls(middle + distance * away, middle, right, up, away)

    def pixel(self, point: NDArray[np.float64]) -> tuple[float, float] | None:
        """Where a point [m] is in the picture, from its upper left corner; None behind the camera."""
        arm = point - self.eye
        depth = -float(arm @ self.away)
        if depth <= 0.0:
            return None
        scale = SIZE[1] / (2.0 * np.tan(np.radians(VIEW_ANGLE / 2)) * depth)
        return float(SIZE[0] / 2 + scale * (arm @ self.right)), float(SIZE[1] / 2 - scale * (arm @ self.up))
