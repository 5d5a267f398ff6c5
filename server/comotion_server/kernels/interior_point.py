"""The way to a projection of many rows: a primal-dual interior point method, all sparse.

    min |y - x|^2 / 2  under  A y >= b:  s = A y - b >= 0,  y = x + A^T l,  l >= 0,  and s l falls to zero.

Mehrotra's predictor and corrector (1992), then corrections that even out the products s l (Gondzio 1996). Each step
factorises I + A^T (l / s) A once; some twenty steps lead close to the solution however many rows are active and
however they depend on each other. It does not end there: multipliers of rows without load only fall towards zero.

Legend: m rows, k bodies in the order of elimination; s slack, l multipliers, w = l / s; equalities have a fixed w.
"""

import numpy as np

from comotion_server.kernels.block_cholesky import solve
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.sparse_rows import add_transposed, build, times

MOST_STEPS = 60  # some 15 to 30 are usual
NEAR = 1e-13  # mean product s l, relative to the square of the largest speed, that ends the steps
MISSES = 1e-10  # of the largest speed: what A y - s - b may miss then
EXACT = 1e8  # weight of equalities
INSIDE = 1e-3  # of the largest speed: the least slack and multiplier to begin with
SHORT = 0.995  # of the way to the nearest zero
CORRECTIONS = 2  # at most, of the products
LOW, HIGH = 0.1, 10.0  # of their aim: products beyond are corrected
BEYOND = 1e12  # of the largest speed: multipliers that grow so large find no solution
SMALLEST = 1e-300  # where there is no product
LONGER = 1.01  # a correction that does not lengthen the step by this is dropped


@lean_jit
def way_to_zero(u, change, equal, way):
    """The largest step up to `way` at which u (m,) + step * change stays positive where not equal (m,)."""
    for i in range(len(u)):
        if not equal[i] and u[i] + way * change[i] < 0.0:
            way = -u[i] / change[i]
    return way


@lean_jit
def direction(part, pattern, factor, w, lack, miss, aim, change):
    """Newton's step: change = (dy (k,d), ds (m,), dl (m,)).

    lack (k,d) = y - x - A^T l, miss (m,) = A y - s - b, aim (m,) = what s l should lose, over s.
    """
    dy, ds, dl = change
    for i in range(len(w)):
        dl[i] = -aim[i] - w[i] * miss[i]
    for j in range(dy.shape[0]):
        for k in range(dy.shape[1]):
            dy[j, k] = -lack[j, k]
    add_transposed(part, dl, dy)
    solve(pattern, factor, dy)
    times(part, dy, ds)
    for i in range(len(w)):
        ds[i] += miss[i]
        dl[i] = -aim[i] - w[i] * ds[i]


@lean_jit
def length_of(part, s, l, change):
    """How much of a step keeps slack and multipliers positive: at most 1."""
    return way_to_zero(l, change[2], part.equal, way_to_zero(s, change[1], part.equal, 1.0))


@jit
def new_change(like, m):
    """Room for a step."""
    return np.empty_like(like), np.empty(m), np.empty(m)


@lean_jit
def mean_product(s, l, change, step, equal):
    """The mean of s l after part of a step, where not equal (m,)."""
    total, count = 0.0, 0
    for i in range(len(s)):
        if not equal[i]:
            total += (s[i] + step * change[1][i]) * (l[i] + step * change[2][i])
            count += 1
    return total / max(count, 1)


@jit
def evened(part, pattern, factor, w, lack, miss, s, l, aim, target, change, room):
    """Corrects a step so that products come nearer to their `target` and it gets longer: its length."""
    step, trial = length_of(part, s, l, change), aim.copy()
    for _ in range(CORRECTIONS):
        farther = min(1.0, 1.5 * step + 0.1)
        for i in range(len(s)):
            if not part.equal[i]:
                value = (s[i] + farther * change[1][i]) * (l[i] + farther * change[2][i])
                correction = min(max(value, LOW * target), HIGH * target) - value
                trial[i] = aim[i] - max(correction, -HIGH * target) / s[i]
        direction(part, pattern, factor, w, lack, miss, trial, room)
        reached = length_of(part, s, l, room)
        if reached < LONGER * step:
            break
        step, aim[:] = reached, trial
        change[0][:], change[1][:], change[2][:] = room
    return step


@jit
def begin_inside(part, x, y, s, l, scale):
    """First y (k,d), slack and multipliers (m,), positive where rows are not equal."""
    times(part, x, s)
    lowest = -INSIDE * scale
    for i in range(len(s)):
        s[i] -= part.bound[i]
        if not part.equal[i]:
            lowest = min(lowest, s[i])
    for i in range(len(s)):
        l[i] = 0.0 if part.equal[i] else max(-s[i], 0.0) - lowest
        s[i] = 0.0 if part.equal[i] else max(s[i], 0.0) - lowest
    y[:] = x
    add_transposed(part, l, y)


@jit
def approach(part, pattern, factor, x, scale, y, l):
    """Brings y (k,d) and multipliers l (m,) close to the solution for x (k,d): whether it got there.

    It does not where there is no solution; scale: the largest speed [m/s kg^1/2].
    """
    m = len(l)
    s, w, miss, aim, lack = np.empty(m), np.empty(m), np.empty(m), np.empty(m), np.empty_like(y)
    change, room = new_change(y, m), new_change(y, m)
    begin_inside(part, x, y, s, l, scale)
    change[1][:], change[2][:] = 0.0, 0.0
    for _ in range(MOST_STEPS):
        times(part, y, miss)
        worst = 0.0
        for i in range(m):
            miss[i] -= s[i] + part.bound[i]
            worst = max(worst, abs(miss[i]))
        mean = mean_product(s, l, change, 0.0, part.equal)
        if mean <= NEAR * scale * scale and worst <= MISSES * scale:
            return True
        for i in range(m):
            w[i] = EXACT if part.equal[i] else l[i] / s[i]
            aim[i] = 0.0 if part.equal[i] else l[i]
        lack[:] = x
        add_transposed(part, l, lack)
        for j in range(lack.shape[0]):
            for k in range(lack.shape[1]):
                lack[j, k] = y[j, k] - lack[j, k]
        build(part, pattern, w, factor)
        direction(part, pattern, factor, w, lack, miss, aim, change)
        step = length_of(part, s, l, change)
        target = mean_product(s, l, change, step, part.equal) ** 3 / max(mean * mean, SMALLEST)
        for i in range(m):
            if not part.equal[i]:
                aim[i] += (change[1][i] * change[2][i] - target) / s[i]
        direction(part, pattern, factor, w, lack, miss, aim, change)
        step = SHORT * evened(part, pattern, factor, w, lack, miss, s, l, aim, target, change, room)
        largest = 0.0
        for i in range(m):
            s[i] += step * change[1][i] if not part.equal[i] else 0.0
            l[i] += step * change[2][i]
            largest = max(largest, abs(l[i]))
        if not largest <= BEYOND * scale:
            return False
        for j in range(y.shape[0]):
            for k in range(y.shape[1]):
                y[j, k] += step * change[0][j, k]
    return False
