"""Pairs that need not be asked for their distance: what was known of it, less what the bodies have moved since.

Seen from body a, no point of body b has moved farther than |t - t0| + r |Q - Q0| / sqrt 2, where (Q, t) is its pose
now, (Q0, t0) that when the pair was last asked, r the radius about its origin and |.| the Frobenius norm: two rotations
move a point apart by at most 2 sin(angle / 2) of its radius, which is that norm / sqrt 2. So bodies that drift together
spend nothing, and however they have moved, or been put somewhere else, the bound holds.
"""

from math import sqrt

import numpy as np

from comotion_server.kernels.jit import jit
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.vectors import length, rotated_back, row, sub

HALF_ROOT = sqrt(0.5)
ROUNDING = 1e-14  # of the lengths in the bound: what computing it may lose


@jit
def _moved(last_turn, last_offset, k, Q, t, radius):
    """How far a point of body b may have moved [m], seen from body a, since pair k was asked."""
    turned = 0.0
    for i in range(3):
        for j in range(3):
            turned += (Q[i, j] - last_turn[k, i, j]) ** 2
    return length(sub(t, row(last_offset, k))) + radius * HALF_ROOT * sqrt(turned)


@jit
def bounds_left(pairs, x, R, radius, last_bound, last_turn, last_offset, motion, left):
    """What is left of the distance bound of each pair, to left (k,) [m]; minus infinity where it was never asked.

    pairs (k, 2); x (n, 3), R (n, 3, 3) poses; radius (n,); last_bound (k,) [m] of the distance when the pair was asked
    last, not a number if never, with b's pose seen from a then: last_turn (k, 3, 3), last_offset (k, 3); motion (n,)
    [m] that the points of each body may still make from now on.
    """
    Q = np.empty((3, 3))
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        left[k] = -np.inf
        if last_bound[k] > motion[a] + motion[b]:
            relative_rotation(R[a], R[b], Q)
            t = rotated_back(R[a], sub(row(x, b), row(x, a)))
            rounding = ROUNDING * (last_bound[k] + length(t) + radius[a] + radius[b])
            moved = _moved(last_turn, last_offset, k, Q, t, radius[b]) + motion[a] + motion[b]
            left[k] = last_bound[k] - moved - rounding


@jit
def note_asked(rows, pairs, x, R, distance, last_bound, last_turn, last_offset):
    """Remember the distances (or bounds) and poses of the pairs that were asked: arguments as in `bounds_left`."""
    for i in range(len(rows)):
        k = rows[i]
        a, b = pairs[k, 0], pairs[k, 1]
        last_bound[k] = distance[k]
        relative_rotation(R[a], R[b], last_turn[k])
        t = rotated_back(R[a], sub(row(x, b), row(x, a)))
        last_offset[k, 0], last_offset[k, 1], last_offset[k, 2] = t
