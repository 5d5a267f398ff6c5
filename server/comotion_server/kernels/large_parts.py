"""The projection of a part with many contacts: augmented Lagrangian, each step by semi-smooth Newton, all sparse.

    min |y - x|^2 / 2  under  A y >= b:  y = argmin |y - x|^2 / 2 + sum max(0, l - rho (A y - b))^2 / (2 rho),
    then l = max(0, l - rho (A y - b)), again, with rho growing (Rockafellar 1976; Li, Sun, Toh 2018).

The inner function is convex and piecewise quadratic with Hessian I + rho A_W^T A_W, W the rows whose term is not zero:
positive definite however rows depend on each other, and sparse as the graph of contacts. Newton with an exact line
search ends after finitely many steps. Rows are scaled to length one. At last both y and l are refined on W.

Legend: m rows, k bodies in the order of elimination; s = A y - b; l multipliers; W active rows; d Newton's direction.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.block_cholesky import Factor, add_outer, factorise, pattern_of, solve
from comotion_server.kernels.dual_active_set import BLOCKED, CAPPED, SOLVED
from comotion_server.kernels.jit import jit

FIRST_WEIGHT, LARGEST_WEIGHT = 10.0, 1e10  # rho; near the last, rounding of A y - b shows in the multipliers
SLOW = 0.1  # a round that leaves more of the error than this raises rho tenfold
ROUNDS = 60  # of multipliers
NEWTON_STEPS = 100  # in one round; most need less than ten
HALVINGS = 60  # of the line search
NOTHING = 1e-15  # of |y|: a Newton step shorter than this is rounding, and rows at their bounds come and go with it
CLOSE = 1e-14  # of the largest term of a row: an error that ends the rounds
NEARLY = 1e-10  # likewise, where rounds hardly lessen it any more: rows that depend on each other but for rounding
IMPOSSIBLE = 1e-7  # |A^T change of l| / |change of l|: below it the change is a certificate
SWEEPS = 3  # refinements on the active rows with one weight
LIGHTER = 1e-3  # the next weight: a large one mends weak directions, smaller ones the rounding it leaves in others


class Part(NamedTuple):
    """Rows of length one over the bodies of a part, bodies in the order of elimination."""

    link: np.ndarray  # (m,2) int64 places, or -1
    part: np.ndarray  # (m,2,6)
    bound: np.ndarray  # (m,)
    equal: np.ndarray  # (m,) bool


@jit
def times(part, y, out):
    """Product A y, out (m,)."""
    for i in range(len(out)):
        out[i] = 0.0
        for side in range(2):
            j = part.link[i, side]
            if j >= 0:
                for k in range(6):
                    out[i] += part.part[i, side, k] * y[j, k]


@jit
def add_transposed(part, l, y):
    """Adds A^T l to y (k,6)."""
    for i in range(len(l)):
        if l[i] != 0.0:
            for side in range(2):
                j = part.link[i, side]
                if j >= 0:
                    for k in range(6):
                        y[j, k] += l[i] * part.part[i, side, k]


@jit
def norm(u):
    """Euclidean norm of u (k,6)."""
    total = 0.0
    for j in range(len(u)):
        for k in range(6):
            total += u[j, k] * u[j, k]
    return sqrt(total)


@jit
def build(part, pattern, active, weight, factor):
    """The factor of I + weight A_W^T A_W."""
    D, B = factor
    D[:], B[:] = 0.0, 0.0
    for j in range(len(D)):
        for k in range(6):
            D[j, k, k] = 1.0
    for i in range(len(active)):
        if active[i]:
            a, b = part.link[i]
            for side in range(2):
                if part.link[i, side] >= 0:
                    add_outer(part.part[i, side], part.part[i, side], weight, D[part.link[i, side]])
            if a > b >= 0:
                add_outer(part.part[i, 0], part.part[i, 1], weight, B[pattern.at[a, b]])
            elif b > a >= 0:
                add_outer(part.part[i, 1], part.part[i, 0], weight, B[pattern.at[b, a]])
    factorise(pattern, factor)


@jit
def pull(part, l, weight, s, out, active):
    """Multipliers out (m,) = max(0, l - weight s), equalities either sign; marks active (m,); whether that changed."""
    changed = False
    for i in range(len(s)):
        out[i] = l[i] - weight * s[i]
        now = part.equal[i] or out[i] > 0.0
        if not now:
            out[i] = 0.0
        changed |= now != active[i]
        active[i] = now
    return changed


@jit
def slope_at(part, l, weight, s, along, t, base, square):
    """Derivative of the inner function at step t along d: `base` = d.(y - x), `square` = d.d, `along` = A d."""
    total = base + t * square
    for i in range(len(s)):
        force = l[i] - weight * (s[i] + t * along[i])
        if part.equal[i] or force > 0.0:
            total -= force * along[i]
    return total


@jit
def step_length(part, l, weight, s, along, base, square):
    """The step in (0, 1] where the derivative along d vanishes, 1 if it is not yet positive there."""
    if slope_at(part, l, weight, s, along, 1.0, base, square) <= 1e-12 * square:
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if slope_at(part, l, weight, s, along, middle, base, square) > 0.0:
            high = middle
        else:
            low = middle
    return high


@jit
def inner_minimum(part, pattern, factor, fresh, weight, x, l, y, s, force, active):
    """Newton's method for y (k,6) at multipliers l (m,): the force (m,) there; whether the factor fits `active`."""
    r, along = np.empty_like(y), np.empty(len(s))
    times(part, y, s)
    for i in range(len(s)):
        s[i] -= part.bound[i]
    fresh &= not pull(part, l, weight, s, force, active)
    for _ in range(NEWTON_STEPS):
        if not fresh:
            build(part, pattern, active, weight, factor)
            fresh = True
        r[:] = x
        add_transposed(part, force, r)
        base = square = 0.0
        for j in range(len(r)):
            for k in range(6):
                r[j, k] -= y[j, k]
        solve(pattern, factor, r)
        for j in range(len(r)):
            for k in range(6):
                base += r[j, k] * (y[j, k] - x[j, k])
                square += r[j, k] ** 2
        if square <= NOTHING * NOTHING * norm(y) ** 2:
            return fresh
        times(part, r, along)
        t = step_length(part, l, weight, s, along, base, square)
        for j in range(len(r)):
            for k in range(6):
                y[j, k] += t * r[j, k]
        times(part, y, s)
        for i in range(len(s)):
            s[i] -= part.bound[i]
        changed = pull(part, l, weight, s, force, active)
        if t == 1.0 and not changed:
            return True
        fresh = not changed
    return fresh


@jit
def polish(part, pattern, factor, weight, active, x, y, l):
    """Refines l (m,) so that A_W y = b_W of y (k,6) = x + A^T l, which is room."""
    s, pull_back, along = np.empty(len(l)), np.empty_like(y), np.empty(len(l))
    for _ in range(SWEEPS):
        y[:] = x
        add_transposed(part, l, y)
        times(part, y, s)
        for i in range(len(l)):
            s[i] = weight * (part.bound[i] - s[i]) if active[i] else 0.0
        pull_back[:] = 0.0
        add_transposed(part, s, pull_back)
        solve(pattern, factor, pull_back)
        times(part, pull_back, along)
        for i in range(len(l)):
            if active[i]:
                l[i] += s[i] - weight * along[i]


@jit
def drop_pulls(part, active, l):
    """Rows whose multiplier (m,) would pull are no longer active; whether there were any."""
    found = False
    for i in range(len(l)):
        if l[i] < 0.0 and not part.equal[i]:
            l[i], active[i], found = 0.0, False, True
    return found


@jit
def certifies(part, change, certificate):
    """Whether the change (m,) of the multipliers proves that no y exists; marks its rows."""
    push = np.zeros((1 + part.link.max(), 6))
    add_transposed(part, change, push)
    size = gain = largest = 0.0
    for i in range(len(change)):
        size += change[i] ** 2
        gain += change[i] * part.bound[i]
        largest = max(largest, abs(change[i]))
    proved = gain > 0.0 and norm(push) <= IMPOSSIBLE * sqrt(size)
    for i in range(len(change)):
        certificate[i] = proved and abs(change[i]) > 1e-6 * largest
    return proved


@jit
def project_large(link, rows, size, bound, equal, x, y, multiplier, certificate):
    """As `dual_active_set.project`, for rows (m,2,6) of norms size (m,) that join bodies link (m,2); x, y (k,6)."""
    m, k = len(link), len(x)
    pattern = pattern_of(link, k)
    place = np.empty(k, np.int64)
    for p in range(k):
        place[pattern.order[p]] = p
    part = Part(np.full((m, 2), -1), rows.copy(), bound / size, equal)
    start, end = np.empty_like(x), np.empty_like(x)
    for i in range(m):
        for side in range(2):
            if link[i, side] >= 0:
                part.link[i, side] = place[link[i, side]]
            for n in range(6):
                part.part[i, side, n] /= size[i]
    for p in range(k):
        start[p] = x[pattern.order[p]]
    end[:] = start
    factor = Factor(np.empty((k, 6, 6)), np.empty((len(pattern.later), 6, 6)))
    l, s, force, active = np.zeros(m), np.empty(m), np.empty(m), np.zeros(m, np.bool_)
    weight, last, fits, status = FIRST_WEIGHT, np.inf, False, CAPPED
    scale = np.abs(start).max() + np.abs(part.bound).max()
    for attempt in range(ROUNDS):
        fits = inner_minimum(part, pattern, factor, fits, weight, start, l, end, s, force, active)
        error = 0.0
        for i in range(m):
            error = max(error, abs(force[i] - l[i]) / weight)
            l[i], s[i] = force[i], force[i] - l[i]
        if error <= CLOSE * scale:
            status = SOLVED
            break
        if attempt > 10 and error > 0.5 * last:
            if certifies(part, s, certificate):
                return BLOCKED
            if error <= NEARLY * scale:
                status = SOLVED
                break
        if error > SLOW * last and weight < LARGEST_WEIGHT:
            weight, fits = 10.0 * weight, False
        last = error
    heaviest, pulls = weight, True
    while pulls:
        weight = heaviest
        while weight >= FIRST_WEIGHT:
            build(part, pattern, active, weight, factor)
            polish(part, pattern, factor, weight, active, start, end, l)
            weight *= LIGHTER
        pulls = drop_pulls(part, active, l)
    end[:] = start
    add_transposed(part, l, end)
    for i in range(m):
        multiplier[i] = l[i] / size[i]
    for p in range(k):
        y[pattern.order[p]] = end[p]
    return status
