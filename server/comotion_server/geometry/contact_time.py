"""When two moving meshes touch: never late, never missed, with a proven bound (docs/time_of_impact.md)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from comotion_server.geometry.motion import Motion, MotionError, flights_of
from comotion_server.geometry.prepared_pair import arrays_of
from comotion_server.kernels.flight import ATTITUDE_TOLERANCE
from comotion_server.kernels.impact_query import (
    CLOSING,
    CONTACT_TIME,
    COUNTS,
    FINDINGS,
    GAP,
    NORMAL,
    POINT_A,
    POINT_B,
    ROUNDINGS,
    new_memory,
)
from comotion_server.kernels.pair_window import new_work
from comotion_server.kernels.time_of_impact import advance

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from comotion_server.meshes.triangle_mesh import TriangleMesh

    Array = NDArray[np.float64]

STATUSES = ("none", "hit", "touching", "overlapping", "later", "budget", "stalled")  # in the order of the kernel's
RELATIVE_TOLERANCE = 1e-9  # of the smaller body's diameter; larger: contacts come earlier, by tolerance / closing speed
NEAR_EDGE = 0.1  # of the median edge: the distance at which windows begin; larger: more triangles in a window
NEAR_SIZE = 0.003  # of the diameter, likewise
BUDGET = 100_000  # distance queries and steps of triangle pairs: seconds; an ordinary query takes about fifty


@dataclass(frozen=True)
class TimeOfImpact:
    """How a query ended; SI units, world frame.

    Attributes:
        status: "none": apart over the whole interval. "hit": in contact at `time`. "touching": the same, at time 0.
            "overlapping": the surfaces intersect at time 0. "budget": unknown after `safe_until`. "stalled": likewise,
            as numbers are too coarse to go on. Contact: the gap is within the tolerance and closes.
        time: of the contact [s]; None: none known.
        safe_until: proven: apart until this time [s].
        contact_time: when the gap would be zero if it went on closing as at `time` [s]: better than `time` by far where
            contact is not grazing; nan without contact.
        gap: at `time` [m], in (0, tolerance].
        closing_speed: of the closest points at `time` [m/s].
        point: half way between the closest points at `time` [m], shape (3,); None without contact.
        normal: unit, from a to b, shape (3,): the separating axis; None without contact.
        triangle_a, triangle_b: in contact; -1 without.
        cost: distance queries, windows, triangle pairs in reach of windows, their steps, most steps of one pair.
    """

    status: str
    time: float | None
    safe_until: float
    contact_time: float
    gap: float
    closing_speed: float
    point: Array | None
    normal: Array | None
    triangle_a: int
    triangle_b: int
    cost: tuple[int, ...]


_near: WeakKeyDictionary[TriangleMesh, float] = WeakKeyDictionary()


def near_distance(mesh: TriangleMesh) -> float:
    """The distance [m] from a mesh below which every pair of triangles gets a time of its own."""
    if mesh not in _near:
        corners = mesh.vertices[mesh.triangles]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        _near[mesh] = float(min(NEAR_EDGE * np.median(edges), NEAR_SIZE * mesh.size))
    return _near[mesh]


def default_tolerance(a: TriangleMesh, motion_a: Motion, b: TriangleMesh, motion_b: Motion, t_max: float) -> float:
    """The largest of what must not be undercut [m].

    1e-9 of the smaller diameter, 64 roundings of the coordinates (seen from the first body's origin), 64 roundings of
    the time times the speed, and 64 times what the attitude of a free top is known to, times its diameter.
    """
    attitude = 0.0
    offset = np.subtract(motion_b.pose[1], motion_a.pose[1])
    velocity = np.subtract(motion_b.velocity, motion_a.velocity)
    acceleration = np.subtract(motion_b.acceleration, motion_a.acceleration)
    speed = float(np.linalg.norm(velocity) + np.linalg.norm(acceleration) * t_max)
    largest = max(float(np.linalg.norm(offset)) + speed * t_max, a.size, b.size)
    for mesh, motion in ((a, motion_a), (b, motion_b)):
        speed += 0.5 * mesh.size * float(np.linalg.norm(np.asarray(motion.angular_velocity)))
        attitude = max(attitude, 0.0 if motion.inertia is None else ATTITUDE_TOLERANCE * mesh.size)
    return max(
        RELATIVE_TOLERANCE * min(a.size, b.size),
        ROUNDINGS * float(np.spacing(largest)),
        ROUNDINGS * speed * float(np.spacing(t_max)),
        ROUNDINGS * attitude,
    )


def time_of_impact(
    a: TriangleMesh,
    motion_a: Motion,
    b: TriangleMesh,
    motion_b: Motion,
    t_max: float,
    *,
    tolerance: float | None = None,
    budget: int = BUDGET,
) -> TimeOfImpact:
    """The first contact of two moving bodies from time 0 to `t_max` [s].

    Args:
        a: surface of the first body, about its origin.
        motion_a: its motion.
        b: surface of the second body, likewise.
        motion_b: its motion.
        t_max: end of the interval [s], included.
        tolerance: gap [m] that counts as contact; None: `default_tolerance`.
        budget: most distance queries and steps of triangle pairs.

    Returns:
        The contact, or that there is none, or how far it is proven that there is none.

    Raises:
        MotionError: where a number cannot be used.
    """
    if not (isfinite(t_max) and t_max > 0.0):
        raise MotionError(f"t_max must be a finite time greater than 0 s; got {t_max}")
    if tolerance is None:
        tolerance = default_tolerance(a, motion_a, b, motion_b, t_max)
    if not (isfinite(tolerance) and tolerance > 0.0):
        raise MotionError(f"tolerance must be a finite length greater than 0 m; got {tolerance}")
    if budget < 1:
        raise MotionError(f"budget must be at least 1; got {budget}")
    m, shape_b = arrays_of(a, b)
    flights, bodies = flights_of((motion_a, motion_b))
    (memory,), (witness,) = new_memory(1)
    findings, counts = np.full(FINDINGS, np.nan), np.zeros(COUNTS, np.int64)
    near = max(min(near_distance(a), near_distance(b)), 4.0 * tolerance)
    limits = (float(t_max), inf, float(tolerance), near, int(budget))
    code = advance(m, flights, bodies, 0, shape_b, 0, 1, *limits, memory, witness, findings, new_work(), counts)
    witness -= m.triangle_start[[0, shape_b]]
    return _answer(STATUSES[code], float(memory[0]), findings, witness, motion_a, counts)


def _answer(
    status: str,
    time: float,
    found: Array,
    witness: NDArray[np.int64],
    a: Motion,
    counts: NDArray[np.int64],
) -> TimeOfImpact:
    """The kernel's numbers in the world frame."""
    contact = status in {"hit", "touching"}
    origin = np.asarray(a.pose[1]) + time * (np.asarray(a.velocity) + 0.5 * time * np.asarray(a.acceleration))
    triangles = witness.tolist() if contact or status == "overlapping" else [-1, -1]
    return TimeOfImpact(
        status=status,
        time=time if contact or status == "overlapping" else None,
        safe_until=time,
        contact_time=float(found[CONTACT_TIME]),
        gap=float(found[GAP]),
        closing_speed=float(found[CLOSING]),
        point=origin + 0.5 * (found[POINT_A : POINT_A + 3] + found[POINT_B : POINT_B + 3]) if contact else None,
        normal=found[NORMAL : NORMAL + 3].copy() if contact else None,
        triangle_a=triangles[0],
        triangle_b=triangles[1],
        cost=tuple(counts.tolist()),
    )
