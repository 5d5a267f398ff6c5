"""Points that move with bodies, and what differences say of their distances."""

import numpy as np
from contact_forms import turn

# Central differences of eighth order.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


class Flight:
    """A body with constant acceleration and, to second order in time, constant angular acceleration."""

    def __init__(self, rng, away):
        self.x, self.v, self.a = rng.normal(size=3) + away, rng.normal(size=3), rng.normal(size=3)
        self.R, self.w, self.alpha = turn(rng.normal(size=3), rng.uniform(0, 3)), rng.normal(size=3), rng.normal(size=3)

    def point(self, body_point, t):
        turned = t * (self.w + 0.5 * t * self.alpha)
        R = (turn(turned, np.linalg.norm(turned)) if t else np.eye(3)) @ self.R
        return self.x + t * (self.v + 0.5 * t * self.a) + R @ body_point

    def body_point(self, world_point):
        return self.R.T @ (world_point - self.x)


def unit(a):
    return a / np.linalg.norm(a)


def line_gap(point, q0, q1):
    """Distance of a moving point from a moving line."""
    return lambda t: np.linalg.norm(np.cross(point(t) - q0(t), unit(q1(t) - q0(t))))
