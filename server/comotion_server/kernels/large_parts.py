"""The projection of a part with many contacts: augmented Lagrangian, each step by semi-smooth Newton, all sparse.

    min |y - x|^2 / 2  under  A y >= b:  y = argmin |y - x|^2 / 2 + sum max(0, l - rho (A y - b))^2 / (2 rho),
    then l = max(0, l - rho (A y - b)), again, with rho growing (Rockafellar 1976; Li, Sun, Toh 2018).

The inner function is convex and piecewise quadratic with Hessian I + rho A_W^T A_W, W the rows whose term is not zero:
positive definite however rows depend on each other, and sparse as the graph of contacts. Newton with an exact line
search ends after finitely many steps: few where few rows decide, or from nearby; else hundreds, so that an interior
point method leads close first. At last both y and l are refined on W.

Legend: m rows, k bodies in the order of elimination; s = A y - b; l multipliers; W active rows; d Newton's direction.
"""

from math import sqrt

import numpy as np

from comotion_server.kernels.block_cholesky import new_factor, pattern_of, solve
from comotion_server.kernels.dual_active_set import BLOCKED, CAPPED, SOLVED
from comotion_server.kernels.interior_point import approach
from comotion_server.kernels.jit import jit
from comotion_server.kernels.sparse_rows import add_transposed, build, norm, part_of, product, times, unknowns_of

FROM_AFAR, FROM_NEAR = 10.0, 1e7  # the first rho
EASY = 30  # factorisations after which the way from afar is left for that through the interior
LARGEST_WEIGHT, LAST_WEIGHT = 1e10, 10.0  # rho; near the largest, rounding of A y - b shows in the multipliers
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
def inner_minimum(part, pattern, factor, fresh, weight, x, l, y, s, force, active, left):
    """Newton's method for y (k,d) at multipliers l (m,): the force (m,) there; whether the factor fits `active`.

    left (1,): how many factorisations there may be, less those there were.
    """
    r, along = np.empty_like(y), np.empty(len(s))
    times(part, y, s)
    s -= part.bound
    fresh &= not pull(part, l, weight, s, force, active)
    for _ in range(NEWTON_STEPS):
        if not fresh:
            if left[0] == 0:
                return False
            left[0] -= 1
            build(part, pattern, weight * active, factor)
            fresh = True
        r[:] = x
        add_transposed(part, force, r)
        r -= y
        solve(pattern, factor, r)
        base, square = product(r, y - x), product(r, r)
        if square <= NOTHING * NOTHING * norm(y) ** 2:
            return fresh
        times(part, r, along)
        t = step_length(part, l, weight, s, along, base, square)
        y += t * r
        times(part, y, s)
        s -= part.bound
        changed = pull(part, l, weight, s, force, active)
        if t == 1.0 and not changed:
            return True
        fresh = not changed
    return fresh


@jit
def polish(part, pattern, factor, weight, active, x, y, l):
    """Refines l (m,) so that A_W y = b_W of y (k,d) = x + A^T l, which is room."""
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
def certifies(part, change, room, certificate):
    """Whether the change (m,) of the multipliers proves that no y exists; marks its rows. room (k,d)."""
    room[:] = 0.0
    add_transposed(part, change, room)
    size = gain = largest = 0.0
    for i in range(len(change)):
        size += change[i] ** 2
        gain += change[i] * part.bound[i]
        largest = max(largest, abs(change[i]))
    proved = gain > 0.0 and norm(room) <= IMPOSSIBLE * sqrt(size)
    for i in range(len(change)):
        certificate[i] = proved and abs(change[i]) > 1e-6 * largest
    return proved


@jit
def end_exactly(part, pattern, factor, x, scale, weight, most, y, l, active, certificate):
    """Multipliers l (m,) of the solution and its `active` rows (m,), from some there are: status, and the last weight.

    CAPPED where `most` factorisations are not enough: l is then of no use.
    """
    m = len(l)
    s, force, room, left = np.empty(m), np.empty(m), np.empty_like(y), np.full(1, most)
    last, fits = np.inf, False
    for attempt in range(ROUNDS):
        fits = inner_minimum(part, pattern, factor, fits, weight, x, l, y, s, force, active, left)
        if left[0] == 0:
            break
        error = 0.0
        for i in range(m):
            error = max(error, abs(force[i] - l[i]) / weight)
            l[i], s[i] = force[i], force[i] - l[i]
        if error <= CLOSE * scale:
            return SOLVED, weight
        if attempt > 10 and error > 0.5 * last:
            if certifies(part, s, room, certificate):
                return BLOCKED, weight
            if error <= NEARLY * scale:
                return SOLVED, weight
        if error > SLOW * last and weight < LARGEST_WEIGHT:
            weight, fits = 10.0 * weight, False
        last = error
    return CAPPED, weight


@jit
def project_large(link, rows, size, bound, equal, x, y, multiplier, certificate):
    """As `dual_active_set.project`, for rows (m,2,6) of norms size (m,) that join bodies link (m,2); x, y (k,6)."""
    k, unknowns = len(x), unknowns_of(rows)
    pattern = pattern_of(link, k)
    part = part_of(link, rows, size, bound, equal, unknowns, pattern.order)
    start, end = np.empty((k, len(unknowns))), np.empty((k, len(unknowns)))
    for p in range(k):
        for n in range(len(unknowns)):
            start[p, n] = x[pattern.order[p], unknowns[n]]
    factor = new_factor(pattern, len(unknowns))
    l, active = np.zeros(len(link)), np.zeros(len(link), np.bool_)
    scale = np.abs(start).max() + np.abs(part.bound).max()
    end[:], weight, most = start, FROM_AFAR, EASY
    status, heaviest = end_exactly(part, pattern, factor, start, scale, weight, most, end, l, active, certificate)
    if status == CAPPED:
        weight, most = FROM_NEAR, ROUNDS * NEWTON_STEPS
        if not approach(part, pattern, factor, start, scale, end, l):
            weight, end[:], l[:] = FROM_AFAR, start, 0.0
        status, heaviest = end_exactly(part, pattern, factor, start, scale, weight, most, end, l, active, certificate)
    if status == BLOCKED:
        return status
    pulls = True
    while pulls:
        weight = heaviest
        while weight >= LAST_WEIGHT:
            build(part, pattern, weight * active, factor)
            polish(part, pattern, factor, weight, active, start, end, l)
            weight *= LIGHTER
        pulls = drop_pulls(part, active, l)
    end[:] = start
    add_transposed(part, l, end)
    multiplier[:] = l / size
    y[:] = x
    for p in range(k):
        for n in range(len(unknowns)):
            y[pattern.order[p], unknowns[n]] = end[p, n]
    return status
