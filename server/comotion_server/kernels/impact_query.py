"""The query for the contact time of two bodies: how it ends, what it remembers, what it finds and what it cost."""

from math import sqrt

import numpy as np

from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.vectors import ZERO, along, dot, length, row, sub

NONE, MEETS, TOUCHES, OVERLAPS, LATER, SPENT, STALLS = 0, 1, 2, 3, 4, 5, 6  # how a query ends

TIME, TARGET, WIDTH = 0, 1, 2  # of `memory`: proven time [s], target gap [m] (0: not known yet), reach of a window
KNOWN, OFFSET, TURNED = 3, 4, 7  # distance found last [m] (0: none), and the pose of b seen from a then
MET, MEMORY = 16, 17  # 1: the proven time is the contact's, in closed form
CONTACT_TIME, GAP, CLOSING, POINT_A, POINT_B, NORMAL, FINDINGS = 0, 1, 2, 3, 6, 9, 12  # of `findings`
QUERIES, WINDOWS, PAIRS, STEPS, LONGEST, COUNTS = 0, 1, 2, 3, 4, 5  # of `counts`: what a query cost

ROUNDINGS = 64.0  # of a coordinate that a tolerance is at least; below about 8 no step towards a contact is safe
FIRST_WIDTH = 2.0  # times `near`: the reach of a query's first window
STILL = 1e-13  # of the bodies' speeds: what rounding may make of a gap that does not change


@jit
def new_memory(count):
    """Nothing known of `count` pairs: `memory` (count, MEMORY) and `witness` (count, 2)."""
    memory = np.zeros((count, MEMORY))
    memory[:, WIDTH] = FIRST_WIDTH
    return memory, np.full((count, 2), -1, np.int64)


@lean_jit
def forget_flight(memory, time):
    """One of the bodies took off anew at `time` [s], where they are apart: the gap that is aimed at is open again."""
    memory[TIME], memory[TARGET], memory[WIDTH], memory[MET] = time, 0.0, FIRST_WIDTH, 0.0


@lean_jit
def note_distance(memory, distance, offset, R):
    """Remember the distance [m] of bodies at a pose, as seen from a: offset, R as `relate` gives them."""
    memory[KNOWN] = distance
    memory[OFFSET : OFFSET + 3] = offset
    for i in range(3):
        for k in range(3):
            memory[TURNED + 3 * i + k] = R[i, k]


@lean_jit
def distance_left(memory, offset, R, radius_a, radius_b):
    """What is proven of the distance [m] by the last one known, less what the bodies have moved since.

    Points of b have moved by no more than |t - t0| + r |Q - Q0| / sqrt 2 as seen from a, with the Frobenius norm (see
    `motion_budget`), and likewise those of a as seen from b: the smaller counts.
    """
    turned, before, after = 0.0, ZERO, ZERO
    t0 = (memory[OFFSET], memory[OFFSET + 1], memory[OFFSET + 2])
    for i in range(3):
        q = (memory[TURNED + 3 * i], memory[TURNED + 3 * i + 1], memory[TURNED + 3 * i + 2])
        d = sub(row(R, i), q)
        turned += dot(d, d)
        before, after = along(before, t0[i], q), along(after, offset[i], row(R, i))
    turned = sqrt(0.5 * turned)
    from_a = length(sub(offset, t0)) + radius_b * turned
    from_b = length(sub(after, before)) + radius_a * turned
    return memory[KNOWN] - min(from_a, from_b)
