"""The motion of a body over an interval of time: a flight, given by its state at the beginning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from comotion_server.geometry.pose import checked_pose
from comotion_server.kernels.flight import SPIN_FREE, SPIN_GIVEN, Bodies, Flights, begin

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from comotion_server.geometry.pose import Pose

    Array = NDArray[np.float64]

SYMMETRIC = 1e-6  # of the largest entry of an inertia: how far entries across the diagonal may differ


class MotionError(ValueError):
    """A motion, an interval or a tolerance that cannot be used; the message names it, what was expected and given."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A rigid body from time 0 on, all in SI units.

    Without `inertia` it turns at its angular velocity, which is held; with `inertia` it turns freely, as a top, under
    `torque`. Vertices X of its mesh are at R X + x.

    Attributes:
        pose: at time 0: rotation R (3, 3), body to world, and position x (3,) [m] of the body's origin, which is the
            centre of mass where the body turns freely.
        velocity: of the origin at time 0 [m/s], shape (3,), world frame.
        angular_velocity: at time 0 [rad/s], shape (3,), world frame.
        acceleration: of the origin, held [m/s2], shape (3,), world frame.
        inertia: about the origin [kg m2], shape (3, 3), body frame; None: the angular velocity is held.
        torque: held [N m], shape (3,), world frame; only with `inertia`.
    """

    pose: Pose
    velocity: ArrayLike = (0.0, 0.0, 0.0)
    angular_velocity: ArrayLike = (0.0, 0.0, 0.0)
    acceleration: ArrayLike = (0.0, 0.0, 0.0)
    inertia: ArrayLike | None = None
    torque: ArrayLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", checked_pose("pose", self.pose))
        for name in ("velocity", "angular_velocity", "acceleration", "torque"):
            object.__setattr__(self, name, _numbers(name, getattr(self, name), (3,)))
        if self.inertia is not None:
            object.__setattr__(self, "inertia", _inertia(self.inertia))
        elif np.any(self.torque):
            raise MotionError("torque needs an inertia; got none")


def _numbers(what: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    numbers = np.array(values, dtype=np.float64, order="C")
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise MotionError(f"{what} must be finite numbers of shape {shape}; got {np.asarray(values).tolist()}")
    return numbers


def _inertia(values: ArrayLike) -> Array:
    inertia = _numbers("inertia", values, (3, 3))
    moments = np.linalg.eigvalsh(inertia)
    if np.abs(inertia - inertia.T).max() > SYMMETRIC * np.abs(inertia).max() or not moments[0] > 0.0:
        raise MotionError(f"inertia must be symmetric and positive definite; got {inertia.tolist()}")
    return inertia


def flights_of(motions: tuple[Motion, Motion]) -> tuple[Flights, Bodies]:
    """The flights of two bodies as seen from the first one's origin, which moves but does not turn with it.

    Only their motion against each other counts, and told like this it keeps its digits wherever they are.
    """
    a = motions[0]
    count = len(motions)
    vectors = {name: np.zeros((count, 3)) for name in ("position", "velocity", "acceleration", "momentum", "axis")}
    flights = Flights(
        origin=np.zeros(count),
        rotation=np.zeros((count, 3, 3)),
        torque=np.array([motion.torque for motion in motions], dtype=np.float64),
        rate=np.zeros((count, 2)),
        kind=np.zeros(count, dtype=np.int64),
        **vectors,
    )
    spin = np.array([SPIN_GIVEN if motion.inertia is None else SPIN_FREE for motion in motions], dtype=np.int64)
    bodies = Bodies(
        moments=np.ones((count, 3)),
        principal=np.tile(np.eye(3), (count, 1, 1)),
        spin=spin,
        inverse_mass=np.ones((count, 3)),
        gravity=np.zeros((count, 3)),
        reacts=np.ones(count, dtype=np.bool_),
    )
    for i, motion in enumerate(motions):
        R, x = (np.array(part, dtype=np.float64) for part in motion.pose)
        w, L = np.array(motion.angular_velocity, dtype=np.float64), np.zeros(3)
        flights.acceleration[i] = np.subtract(motion.acceleration, a.acceleration)
        if motion.inertia is not None:
            moments, axes = np.linalg.eigh(np.asarray(motion.inertia))
            bodies.moments[i], bodies.principal[i] = moments, axes * np.array([np.sign(np.linalg.det(axes)), 1.0, 1.0])
            L = R @ (np.asarray(motion.inertia) @ (R.T @ w))
        begin(flights, bodies, i, 0.0, x - np.asarray(a.pose[1]), np.subtract(motion.velocity, a.velocity), R, L, w)
    return flights, bodies
