"""The most energy that tangential impulses within discs |l_t| <= mu l_n can take, contact after contact.

Legend: T (2f,n) tangent rows, two per contact; g (2f,) slip before; l_t impulses; d = T^T l_t; B = T T^T of one contact.
The function |d|^2 / 2 + g.l_t is convex, zero at rest, and every move lowers it.
"""

from math import atan2, cos, hypot, sin, sqrt

import numpy as np

from comotion_server.kernels.jit import jit
from comotion_server.kernels.orthogonal_rows import advance, inner

SETTLED = 1e-14  # relative motion of a sweep that ends the descent
MOST_SWEEPS = 1000  # over the contacts; stopping early is safe
NEWTON_STEPS = 30  # for the multiplier of a disc
FLAT = 1e-14  # of the larger eigenvalue: a direction that nothing can give way to


@jit
def principal_axes(B):
    """Eigenvalues (low, high) of a symmetric (2,2) and the cosine and sine of the axis of the first."""
    half, mean = 0.5 * (B[0, 0] - B[1, 1]), 0.5 * (B[0, 0] + B[1, 1])
    spread = hypot(half, B[0, 1])
    angle = 0.5 * atan2(-B[0, 1], -half)
    return max(mean - spread, 0.0), mean + spread, cos(angle), sin(angle)


@jit
def least_in_disc(B, h0, h1, radius):
    """The l with the least l.B l / 2 + h.l in the disc |l| <= radius."""
    low, high, c, s = principal_axes(B)
    u, t = c * h0 + s * h1, c * h1 - s * h0
    pull = hypot(u, t)
    if pull == 0.0 or radius == 0.0:
        return 0.0, 0.0
    shift = max(0.0, pull / radius - high)
    if shift == 0.0 and low <= FLAT * high:
        shift = FLAT * (high + pull / radius)
    for _ in range(NEWTON_STEPS):  # Newton for 1/|l(shift)| = 1/radius, concave: from below it never overshoots
        p, q = u / (low + shift), t / (high + shift)
        size = hypot(p, q)
        if size <= radius * (1.0 + 1e-15):
            break
        slope = (p * p / (low + shift) + q * q / (high + shift)) / (size * size)
        shift += (size / radius - 1.0) / slope
    p, q = -u / (low + shift), -t / (high + shift)
    size = hypot(p, q)
    if size > radius:
        p, q = p * radius / size, q * radius / size
    return c * p - s * q, s * p + c * q


@jit
def descend(T, g, radius, rubbing, d):
    """Contact after contact takes what energy it can: changes rubbing (2f,) and d (n,) = T^T rubbing."""
    d[:] = 0.0
    for i in range(len(radius)):
        size = hypot(rubbing[2 * i], rubbing[2 * i + 1])
        fit = radius[i] / size if size > radius[i] else 1.0
        for k in range(2 * i, 2 * i + 2):
            rubbing[k] *= fit
            advance(d, rubbing[k], T[k])
    B = np.empty((2, 2))
    for _ in range(MOST_SWEEPS):
        moved = total = 0.0
        for i in range(len(radius)):
            t, s = T[2 * i], T[2 * i + 1]
            B[0, 0], B[0, 1], B[1, 0], B[1, 1] = inner(t, t), inner(t, s), inner(t, s), inner(s, s)
            p, q = rubbing[2 * i], rubbing[2 * i + 1]
            h0 = g[2 * i] + inner(t, d) - B[0, 0] * p - B[0, 1] * q
            h1 = g[2 * i + 1] + inner(s, d) - B[1, 0] * p - B[1, 1] * q
            rubbing[2 * i], rubbing[2 * i + 1] = least_in_disc(B, h0, h1, radius[i])
            advance(d, rubbing[2 * i] - p, t)
            advance(d, rubbing[2 * i + 1] - q, s)
            moved += hypot(rubbing[2 * i] - p, rubbing[2 * i + 1] - q) * sqrt(B[0, 0] + B[1, 1])
            total += hypot(rubbing[2 * i], rubbing[2 * i + 1]) * sqrt(B[0, 0] + B[1, 1])
        if moved <= SETTLED * total:
            break
