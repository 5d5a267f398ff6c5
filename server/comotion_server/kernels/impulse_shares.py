"""The shares of contacts in a push that several of them could give: the ones of least sum of squares.

Where rows depend on each other (a box on four corners) the motion is unique and the multipliers are not. Those of least
norm among lambda >= 0 with A^T lambda = push are unique, symmetric, and independent of the numbering of contacts. They are
themselves the nearest point of a polyhedron to zero, so the same solver finds them.
"""

import numpy as np

from comotion_server.kernels.dual_active_set import SOLVED, project
from comotion_server.kernels.jit import jit
from comotion_server.kernels.orthogonal_rows import inner

SAME_PUSH = 1e-12  # of the sum of the terms: shares that miss the push by more are not used


@jit
def same_push(A, push, shares):
    """Whether A^T shares = push (n,)."""
    m, n = A.shape
    largest = 0.0
    for k in range(n):
        largest = max(largest, abs(push[k]))
    for k in range(n):
        total, terms = -push[k], abs(push[k])
        for i in range(m):
            total += A[i, k] * shares[i]
            terms += abs(A[i, k]) * abs(shares[i])
        if abs(total) > SAME_PUSH * (terms + largest):
            return False
    return True


@jit
def share_push(A, push, one_sided, multiplier):
    """Replaces multiplier (m,) of tight rows A (m,n) by the unique one with A^T multiplier = push (n,).

    Not negative where one_sided (m,) bool. Returns whether there is one; if not, the old one stays.
    """
    m, n = A.shape
    rows, bounds, equal = np.zeros((n + m, m)), np.zeros(n + m), np.zeros(n + m, np.bool_)
    for k in range(n):
        for i in range(m):
            rows[k, i] = A[i, k]
        bounds[k] = push[k]
        equal[k] = inner(rows[k], rows[k]) > 0.0
    count = n
    for i in range(m):
        if one_sided[i]:
            rows[count, i] = 1.0
            count += 1
    shares, forces = np.empty(m), np.empty(n + m)
    status = project(
        rows[:count],
        bounds[:count],
        equal[:count],
        1e-9,
        np.zeros(m),
        shares,
        forces[:count],
        np.empty(count, np.bool_),
    )
    if status == SOLVED:
        for i in range(m):
            if one_sided[i]:
                shares[i] = max(shares[i], 0.0)
        if same_push(A, push, shares):
            multiplier[:] = shares
            return True
    return False
