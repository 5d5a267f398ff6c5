"""The box of a node of a tree: along the principal axes of its surface, or along the body's where that is smaller."""

from math import sqrt

import numpy as np

from comotion_server.kernels.jit import jit

PADDING = 1e-15  # of a box's reach: what its extents may be wrong by
ALIGNED = 1e-9  # of the moments: principal axes are turned no further; the box is a box whatever its axes


@jit
def half_area(x, y, z):
    """Half the surface of a box with these edges."""
    return x * y + y * z + z * x


@jit
def triangle_moments(corners, first, moments):
    """Area, first (3) and second moments (xx, xy, yy, xz, yz, zz) of a triangle, about the body's origin.

    corners (c, 3): rows first, first + 1, first + 2; out: moments (10,).
    """
    ax, ay, az = corners[first, 0], corners[first, 1], corners[first, 2]
    bx, by, bz = corners[first + 1, 0], corners[first + 1, 1], corners[first + 1, 2]
    cx, cy, cz = corners[first + 2, 0], corners[first + 2, 1], corners[first + 2, 2]
    ux, uy, uz, vx, vy, vz = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
    area = sqrt((uy * vz - uz * vy) ** 2 + (uz * vx - ux * vz) ** 2 + (ux * vy - uy * vx) ** 2)
    sx, sy, sz = ax + bx + cx, ay + by + cy, az + bz + cz
    part = area / 12.0
    moments[0] = area
    moments[1], moments[2], moments[3] = area * sx / 3.0, area * sy / 3.0, area * sz / 3.0
    moments[4] = part * (ax * ax + bx * bx + cx * cx + sx * sx)
    moments[5] = part * (ax * ay + bx * by + cx * cy + sx * sy)
    moments[6] = part * (ay * ay + by * by + cy * cy + sy * sy)
    moments[7] = part * (ax * az + bx * bz + cx * cz + sx * sz)
    moments[8] = part * (ay * az + by * bz + cy * cz + sy * sz)
    moments[9] = part * (az * az + bz * bz + cz * cz + sz * sz)


@jit
def _covariance(moments, node, S):
    """Second moments (3, 3) of a node's surface about its centre of area; False where it has no area."""
    area = moments[node, 0]
    if not area > 0.0:
        return False
    entry = 4
    for k in range(3):
        for m in range(k + 1):
            S[k, m] = S[m, k] = moments[node, entry] - moments[node, 1 + k] * moments[node, 1 + m] / area
            entry += 1
    return True


@jit
def _principal_axes(S, axes):
    """Eigenvectors of the symmetric S (3, 3), as rows of `axes`, by Jacobi rotations; S is used up."""
    for k in range(3):
        for m in range(3):
            axes[k, m] = 1.0 if k == m else 0.0
    for _ in range(12):
        off = abs(S[0, 1]) + abs(S[0, 2]) + abs(S[1, 2])
        if off <= ALIGNED * (abs(S[0, 0]) + abs(S[1, 1]) + abs(S[2, 2])):
            return
        for p in range(2):
            for q in range(p + 1, 3):
                if S[p, q] == 0.0:
                    continue
                theta = (S[q, q] - S[p, p]) / (2.0 * S[p, q])
                t = (1.0 if theta >= 0.0 else -1.0) / (abs(theta) + sqrt(theta * theta + 1.0))
                c = 1.0 / sqrt(t * t + 1.0)
                s = t * c
                for k in range(3):
                    a, b = S[k, p], S[k, q]
                    S[k, p], S[k, q] = c * a - s * b, s * a + c * b
                for k in range(3):
                    a, b = S[p, k], S[q, k]
                    S[p, k], S[q, k] = c * a - s * b, s * a + c * b
                    a, b = axes[p, k], axes[q, k]
                    axes[p, k], axes[q, k] = c * a - s * b, s * a + c * b


@jit
def _extent(corners, begin, end, x, y, z, u, v, w):
    """(least, greatest) of the corners in rows `begin` to `end`, relative to (x, y, z), along the axis (u, v, w)."""
    low, high = np.inf, -np.inf
    for i in range(begin, end):
        s = (corners[i, 0] - x) * u + (corners[i, 1] - y) * v + (corners[i, 2] - z) * w
        low, high = min(low, s), max(high, s)
    return low, high


@jit
def fit_box(corners, begin, end, spans, moments, node, room, centre, axes, half):
    """The smaller of the boxes along the principal and along the body's axes, to row `node` of centre, axes, half.

    corners (c, 3): those of the node's triangles are the rows `begin` to `end`; spans (n, 6): its axis-aligned bounds;
    moments (n, 10): of its surface; room: two arrays (3, 3) to work in.
    """
    S, fitted = room
    for k in range(3):
        centre[node, k] = 0.5 * (spans[node, k] + spans[node, 3 + k])
        half[node, k] = 0.5 * (spans[node, 3 + k] - spans[node, k])
        for m in range(3):
            axes[node, k, m] = 1.0 if k == m else 0.0
    x, y, z = centre[node, 0], centre[node, 1], centre[node, 2]
    if _covariance(moments, node, S):
        _principal_axes(S, fitted)
        l0, h0 = _extent(corners, begin, end, x, y, z, fitted[0, 0], fitted[0, 1], fitted[0, 2])
        l1, h1 = _extent(corners, begin, end, x, y, z, fitted[1, 0], fitted[1, 1], fitted[1, 2])
        l2, h2 = _extent(corners, begin, end, x, y, z, fitted[2, 0], fitted[2, 1], fitted[2, 2])
        own = 4.0 * half_area(half[node, 0], half[node, 1], half[node, 2])
        if half_area(h0 - l0, h1 - l1, h2 - l2) < own:
            half[node, 0], half[node, 1], half[node, 2] = 0.5 * (h0 - l0), 0.5 * (h1 - l1), 0.5 * (h2 - l2)
            for m in range(3):
                axes[node, 0, m], axes[node, 1, m], axes[node, 2, m] = fitted[0, m], fitted[1, m], fitted[2, m]
                centre[node, m] += 0.5 * (
                    (l0 + h0) * fitted[0, m] + (l1 + h1) * fitted[1, m] + (l2 + h2) * fitted[2, m]
                )
    reach = half[node, 0] + half[node, 1] + half[node, 2]
    reach += abs(centre[node, 0]) + abs(centre[node, 1]) + abs(centre[node, 2])
    for k in range(3):
        half[node, k] += PADDING * reach
