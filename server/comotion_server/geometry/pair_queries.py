"""P6, P7, P8 for two meshes: distance, intersection, depth of an overlap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from comotion_server.geometry.pose import checked_direction, checked_pose
from comotion_server.geometry.prepared_pair import arrays_of
from comotion_server.kernels.mesh_pair import SLACK, closest_points_of_pairs
from comotion_server.kernels.penetration import overlap

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from comotion_server.geometry.pose import Pose
    from comotion_server.meshes import TriangleMesh


@dataclass(frozen=True, eq=False)
class Closest:
    """The closest points of two bodies.

    Attributes:
        distance: between the surfaces [m]; exactly 0 if and only if they meet, within 2e-15 of the sizes.
        point_a: on a, shape (3,) [m], world frame; where the surfaces meet, a point of both.
        point_b: on b, likewise.
        triangle_a: the triangle of a that holds point_a, index into a.triangles.
        triangle_b: the triangle of b that holds point_b.
        normal: unit vector (3,) from a to b, world frame; zero where the surfaces meet.
    """

    distance: float
    point_a: NDArray[np.float64]
    point_b: NDArray[np.float64]
    triangle_a: int
    triangle_b: int
    normal: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Overlap:
    """How deep two closed bodies overlap along a direction (P8).

    Attributes:
        depth: [m]; 0 if the surfaces do not meet.
        direction: unit vector (3,), world frame, from a towards b: moving b by about depth along it sets it free.
        point_a: on a, shape (3,) [m], world frame; if the surfaces do not meet, the closest point.
        point_b: on b, likewise.
    """

    depth: float
    direction: NDArray[np.float64]
    point_a: NDArray[np.float64]
    point_b: NDArray[np.float64]


def distance(
    a: TriangleMesh, pose_a: Pose, b: TriangleMesh, pose_b: Pose, *, start: tuple[int, int] | None = None
) -> Closest:
    """The distance of two meshes and their closest points, right to 1e-14 of the sizes (P6).

    start: a triangle of a and one of b to begin with, such as those of the last query: faster, and the same distance.
    """
    return _closest(a, pose_a, b, pose_b, np.inf, start)


def intersects(a: TriangleMesh, pose_a: Pose, b: TriangleMesh, pose_b: Pose) -> bool:
    """Whether the surfaces of two meshes meet (P7): exactly where their distance is 0.

    A body wholly inside another does not touch its surface, and does not count.
    """
    reach = 2.0 * SLACK * (a.size + b.size)
    return _closest(a, pose_a, b, pose_b, reach, None).distance == 0.0


def penetration(
    a: TriangleMesh,
    pose_a: Pose,
    b: TriangleMesh,
    pose_b: Pose,
    direction: ArrayLike | None = None,
    minimum: float = 0.0,
) -> Overlap:
    """How deep two closed meshes overlap (P8).

    direction: (3,), world, between the closest points from a to b when the bodies were last apart; without one, from
    the origin of a to that of b. minimum: the least depth [m] to report of surfaces that meet.
    """
    if not (np.isfinite(minimum) and minimum >= 0.0):
        raise ValueError(f"minimum must be a finite depth of at least 0 m; got {minimum!r}")
    closest = _closest(a, pose_a, b, pose_b, np.inf, None)
    if closest.distance > 0.0:
        return Overlap(0.0, closest.normal, closest.point_a, closest.point_b)
    (R_a, x_a), (R_b, x_b) = checked_pose("pose_a", pose_a), checked_pose("pose_b", pose_b)
    if direction is not None:
        towards = checked_direction(direction)
    else:
        towards = x_b - x_a if (x_a != x_b).any() else np.array([0.0, 0.0, 1.0])
    m, shape_b = arrays_of(a, b)
    points = np.empty((2, 3))
    depth = overlap(m, 0, shape_b, x_a, R_a, x_b, R_b, towards, points)
    if depth == 0.0:
        points[:] = closest.point_a
    return Overlap(max(float(depth), minimum), towards / np.linalg.norm(towards), points[0], points[1])


def _closest(
    a: TriangleMesh, pose_a: Pose, b: TriangleMesh, pose_b: Pose, reach: float, start: tuple[int, int] | None
) -> Closest:
    """The answer of `closest_points_of_pairs` for one pair."""
    poses = checked_pose("pose_a", pose_a), checked_pose("pose_b", pose_b)
    rotations, positions = np.stack([R for R, _ in poses]), np.stack([x for _, x in poses])
    m, shape_b = arrays_of(a, b)
    witness = np.array([(-1, -1) if start is None else _checked_start(a, b, start)], dtype=np.int64)
    found, p, q, n = np.empty(1), np.empty((1, 3)), np.empty((1, 3)), np.empty((1, 3))
    pair, shapes = np.array([[0, 1]]), np.array([0, shape_b])
    closest_points_of_pairs(m, shapes, positions, rotations, pair, np.array([reach]), witness, found, p, q, n)
    return Closest(float(found[0]), p[0], q[0], int(witness[0, 0]), int(witness[0, 1]), n[0])


def _checked_start(a: TriangleMesh, b: TriangleMesh, start: tuple[int, int]) -> tuple[int, int]:
    first, second = start
    if not (0 <= first < len(a.triangles) and 0 <= second < len(b.triangles)):
        counts = f"{len(a.triangles)} and {len(b.triangles)}"
        raise ValueError(f"start must be a triangle of each mesh, which have {counts}; got {start!r}")
    return first, second
