"""Points of contact seen along their common normal: each place once, then the corners of their convex hull.

Rows with one normal at points of a convex hull follow from those at its corners, for velocities, impulses and
accelerations alike; so the corners are all that a law has to know of a patch. What has to keep a distance asks for
points inside as well, where they lie lower than all corners: a slightly bent edge touches a face in its middle.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.contacts import FEATURES, FULL
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.mesh_room import PatchPoints
from comotion_server.kernels.vectors import along, cross, dot, sub, unit

POINTS_AT_FIRST = 4096
NONE = np.int64(-1)  # in the place of a feature; a plain -1 is a type of its own, for which all would be compiled anew

Vector = tuple[float, float, float]


class View(NamedTuple):
    """How a patch is looked at."""

    n: Vector  # the normal, from a to b
    across: Vector  # two directions in the plane of contact, right-handed with n
    up: Vector
    limit: float  # largest gap [m]
    merge: float  # points nearer than this are one [m]


@jit
def new_points():
    """Room for the points of a patch."""
    return PatchPoints(
        np.empty(POINTS_AT_FIRST, np.int64),
        np.empty((POINTS_AT_FIRST, FEATURES), np.int64),
        np.empty((POINTS_AT_FIRST, 3)),
        np.empty((POINTS_AT_FIRST, 3)),
        np.empty(POINTS_AT_FIRST),
        np.empty((POINTS_AT_FIRST, 2)),
        np.empty(3 * POINTS_AT_FIRST, np.int64),
    )


@lean_jit
def view_along(n, limit, merge):
    """`View` along n. Its axes are oblique to whatever is likely in a scene, so that hardly two points are level."""
    oblique = (0.4472, 0.6325, 0.6324) if abs(n[0]) < 0.4 or n[0] * n[1] < 0.0 else (0.6325, -0.4472, 0.6324)
    across = unit(along(oblique, -dot(oblique, n), n))
    return View(n, across, cross(n, across), limit, merge)


@lean_jit
def _comes_first(kind, feature, points, k):
    """Whether a point of this kind and with these features is to be kept rather than point k."""
    if kind != points.kind[k]:
        return kind < points.kind[k]
    for f in range(FEATURES):
        if feature[f] != points.feature[k, f]:
            return feature[f] < points.feature[k, f]
    return False


@lean_jit
def add_point(points, count, view, kind, f0, f1, f2, f3, f4, p, q):
    """Put the point p on a, q on b among those of a patch; how many there are, or FULL.

    kind and features f0 ... f4 as in `Contacts`, NONE where there is none. Of points at one place the first in the
    order of kinds and features stays, whatever came first.
    """
    feature, gap = (f0, f1, f2, f3, f4), dot(view.n, sub(q, p))
    if count == FULL or not -view.limit <= gap <= view.limit:
        return count
    x, y, place = dot(view.across, p), dot(view.up, p), count
    for k in range(count):
        if abs(points.place[k, 0] - x) <= view.merge and abs(points.place[k, 1] - y) <= view.merge:
            if not _comes_first(kind, feature, points, k):
                return count
            place = k
            break
    if place == len(points.gap):
        return FULL
    points.kind[place], points.gap[place] = kind, gap
    points.place[place, 0], points.place[place, 1] = x, y
    for f in range(FEATURES):
        points.feature[place, f] = feature[f]
    for k in range(3):
        points.point_a[place, k], points.point_b[place, k] = p[k], q[k]
    return max(count, place + 1)


@lean_jit
def _sorted(points, count):
    """The points in the order of their places, from left to right: the first `count` of `order`."""
    place, order = points.place, points.order
    for i in range(count):
        k = i
        while k > 0 and (place[order[k - 1], 0], place[order[k - 1], 1]) > (place[i, 0], place[i, 1]):
            order[k] = order[k - 1]
            k -= 1
        order[k] = i


@lean_jit
def _turns(place, i, j, k, line):
    """Whether the way i, j, k turns to the left in j, and j is no point of the line from i to k."""
    ux, uy = place[k, 0] - place[i, 0], place[k, 1] - place[i, 1]
    vx, vy = place[j, 0] - place[i, 0], place[j, 1] - place[i, 1]
    area = vx * uy - vy * ux
    return area > 0.0 and area * area > line * line * (ux * ux + uy * uy)


@lean_jit
def hull(points, count, line):
    """How many corners the convex hull has: rows `order[count :]`, counter-clockwise from the leftmost (Andrew)."""
    _sorted(points, count)
    place, order = points.place, points.order
    corners = order[count:]
    size, least = 0, 2
    for step in range(2 * count - 1):
        if step == count:  # back from the last one
            least = size + 1
        k = order[step] if step < count else order[2 * count - 2 - step]
        while size >= least and not _turns(place, corners[size - 2], corners[size - 1], k, line):
            size -= 1
        corners[size] = k
        size += 1
    return max(size - 1, 1)


@lean_jit
def lower_points(points, count, corners, sag):
    """Append to the corners in `order` the points whose gap is by `sag` [m] less than that of all; how many rows then.

    `count` and `corners` as `hull` took and gave them.
    """
    order, gap = points.order, points.gap
    least, rows = inf, corners
    for c in range(corners):
        least = min(least, gap[order[count + c]])
    for k in range(count):
        if gap[order[k]] < least - sag:
            order[count + rows] = order[k]
            rows += 1
    return rows
