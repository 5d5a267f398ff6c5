"""The nearest point of a polyhedron: min |y - x|^2 / 2 under A y >= b, some rows with equality.

The dual active set method of Goldfarb and Idnani (1983, "A numerically stable dual method for solving strictly convex
quadratic programs") for a unit Hessian: rows come in by the largest violation, leave where their multiplier would turn
negative, and the dual objective only grows. y = x + A^T lambda is unique; lambda is not where rows depend on each
other. Linearly dependent rows never enter the factorisation. At last the solution is refined with the rows that stayed.

Legend: q the row that enters, z its part outside the active rows, r = R^-1 Q^T a_q the exchange rates of the active
multipliers, t the step; reach (n,) the largest size each unknown had on the way: what rounding is relative to.
"""

from math import inf, sqrt

import numpy as np

from comotion_server.kernels.jit import jit
from comotion_server.kernels.orthogonal_rows import (
    advance,
    append_row,
    inner,
    new_factors,
    remove_row,
    solve_back,
    solve_forward,
    split_row,
)

SOLVED, CAPPED, JAMMED, BLOCKED = 0, 1, 2, 3  # also of clusters: done; cut short; energy had to go; impossible

ROUNDING = 4e-15  # of a row's terms: a violation below it is none. Smaller: duplicated rows cycle
DEPENDENT = (
    1e-10  # |z| / |a|: closer to the active rows than this is in their span. Larger: mass ratios above 1e14 fail
)
CONSISTENT = 1e-11  # of a row's terms: a dependent row violated by less is left alone, by more it is impossible
BLOCKING = 1e-13  # of the largest exchange rate: smaller ones are rounding and block nothing
STEPS_PER_ROW = 50  # above it rounding makes the method circle
SWEEPS = 2  # refinements of the final solution


@jit
def terms_of(a, reach, bound):
    """The sum of the sizes of a row's terms: what the rounding of a.y - bound is relative to."""
    total = abs(bound)
    for k in range(len(a)):
        total += abs(a[k]) * reach[k]
    return total


@jit
def slack_of(a, z, reach, bound):
    """By how much a row may be violated that is in the span of others but for its part z: by rounding and by z.y."""
    return CONSISTENT * terms_of(a, reach, bound) + 2.0 * terms_of(z, reach, 0.0)


@jit
def widen(reach, y):
    """Raises reach (n,) to the sizes of y (n,)."""
    for k in range(len(y)):
        reach[k] = max(reach[k], abs(y[k]))


@jit
def widen_by(reach, A, multiplier):
    """Raises reach (n,) to the sizes of the terms of A^T multiplier, which may cancel."""
    for k in range(len(reach)):
        total = 0.0
        for i in range(len(multiplier)):
            total += abs(A[i, k] * multiplier[i])
        reach[k] = max(reach[k], total)


@jit
def most_violated(A, b, out, y, reach):
    """The row with the largest violation |b - a.y| / |a| above rounding, among those not `out`; -1: none."""
    worst, found = 0.0, -1
    for i in range(A.shape[0]):
        if out[i]:
            continue
        violation = b[i] - inner(A[i], y)
        if violation > ROUNDING * terms_of(A[i], reach, b[i]):
            size = sqrt(inner(A[i], A[i]))
            score = violation / size if size > 0.0 else inf
            if score > worst:
                worst, found = score, i
    return found


@jit
def refine(A, b, factors, count, x, y, multiplier):
    """One sweep: y from the multipliers of the active rows, then both corrected so that A_active y = b."""
    u = np.empty(count)
    y[:] = x
    for i in range(A.shape[0]):
        if multiplier[i] != 0.0:
            advance(y, multiplier[i], A[i])
    for j in range(count):
        u[j] = b[factors.rows[j]] - inner(A[factors.rows[j]], y)
    solve_forward(factors, count, u)
    for j in range(count):
        advance(y, u[j], factors.basis[j])
    solve_back(factors, count, u)
    for j in range(count):
        multiplier[factors.rows[j]] += u[j]


@jit
def take_equalities(A, equal, weak, factors):
    """Makes rows marked `equal` active, the most independent first, none whose |z| / |a| is below `weak`; the count."""
    m, n = A.shape
    count = 0
    wanted = False
    for i in range(m):
        wanted |= equal[i]
    if not wanted:
        return count
    outside, h, z = A.copy(), np.empty(len(factors.rows)), np.empty(n)
    open_rows = equal.copy()
    while count < len(factors.rows):
        best, q = weak * weak, -1
        for i in range(m):
            if open_rows[i]:
                size = inner(A[i], A[i])
                share = inner(outside[i], outside[i]) / size if size > 0.0 else 0.0
                if share > best:
                    best, q = share, i
        if q < 0:
            break
        size = sqrt(split_row(factors, count, A[q], h, z))
        count = append_row(factors, count, q, h, z, size)
        open_rows[q] = False
        for i in range(m):
            if open_rows[i]:
                advance(outside[i], -inner(factors.basis[count - 1], outside[i]), factors.basis[count - 1])
    return count


@jit
def begin_with_equalities(A, b, equal, weak, factors, x, y, multiplier, reach):
    """Brings y (n,) from x to the equalities, but those within `weak` (relative) of the span of others: active rows."""
    multiplier[:], y[:] = 0.0, x
    widen(reach, x)
    count = take_equalities(A, equal, weak, factors)
    if count > 0:
        refine(A, b, factors, count, x, y, multiplier)
        widen(reach, y)
        widen_by(reach, A, multiplier)
    return count


@jit
def first_to_vanish(factors, count, equal, rates, multiplier):
    """The step at which the first active multiplier reaches zero, and its place; (inf, -1): none does."""
    largest = 0.0
    for j in range(count):
        largest = max(largest, abs(rates[j]))
    step, place = inf, -1
    for j in range(count):
        if rates[j] > BLOCKING * largest and not equal[factors.rows[j]]:
            ratio = max(multiplier[factors.rows[j]], 0.0) / rates[j]
            if ratio < step:
                step, place = ratio, j
    return step, place


@jit
def certify(factors, count, q, rates, certificate):
    """Marks the rows that together are impossible: a_q and the active rows it would need to pull."""
    largest = 0.0
    for j in range(count):
        largest = max(largest, abs(rates[j]))
    certificate[q] = True
    for j in range(count):
        if abs(rates[j]) > BLOCKING * largest:
            certificate[factors.rows[j]] = True


@jit
def enter(A, b, equal, weak, factors, count, q, y, reach, multiplier, certificate):
    """Lets row q in, others out as they must: (status, count); an unchanged count without q: q is left alone."""
    h, rates, z = np.empty(len(factors.rows)), np.empty(len(factors.rows)), np.empty(A.shape[1])
    a, size = A[q], inner(A[q], A[q])
    while True:
        violation = b[q] - inner(a, y)
        outside = split_row(factors, count, a, h, z)
        slight = violation <= slack_of(a, z, reach, b[q])
        if slight and multiplier[q] == 0.0 and outside < weak * weak * size:
            return SOLVED, count
        dependent = count == len(factors.rows) or outside <= DEPENDENT * DEPENDENT * size
        rates[:count] = h[:count]
        solve_back(factors, count, rates)
        step, place = first_to_vanish(factors, count, equal, rates, multiplier)
        if dependent and place < 0:
            if slight:
                return SOLVED, count
            certify(factors, count, q, rates, certificate)
            return BLOCKED, count
        full = inf if dependent else max(violation, 0.0) / outside
        t = min(step, full)
        multiplier[q] += t
        for j in range(count):
            multiplier[factors.rows[j]] -= t * rates[j]
        if not dependent:
            advance(y, t, z)
        widen(reach, y)
        if full <= step:
            return SOLVED, append_row(factors, count, q, h, z, sqrt(outside))
        multiplier[factors.rows[place]] = 0.0
        count = remove_row(factors, count, place)


@jit
def project(A, b, equal, weak, x, y, multiplier, certificate):
    """The nearest y (n,) to x (n,) with A y >= b, = b in rows marked `equal`: status SOLVED, CAPPED or BLOCKED.

    A (m,n), b (m,), equal (m,) bool; an equality closer than `weak` (relative) to the span of others is left out, and
    so is, beside equalities, an inequality closer to that of active rows and violated by no more than the difference
    explains: what differs from others by rounding alone would get multipliers as large as that is small.
    Writes y = x + A^T multiplier, multiplier (m,) >= 0 but for equalities; BLOCKED: certificate (m,) marks rows that
    cannot hold together, and y is of no use.
    """
    m, n = A.shape
    factors = new_factors(min(m, n), n)
    reach, skipped, out, sweeps = np.zeros(n), np.zeros(m, np.bool_), np.empty(m, np.bool_), 0
    count = begin_with_equalities(A, b, equal, weak, factors, x, y, multiplier, reach)
    near = weak if count > 0 else 0.0
    for _ in range(STEPS_PER_ROW * m + 1):
        for i in range(m):
            out[i] = equal[i] or skipped[i]
        for j in range(count):
            out[factors.rows[j]] = True
        q = most_violated(A, b, out, y, reach)
        if q < 0 and (sweeps == SWEEPS or count == 0):
            for i in range(m):
                if not equal[i]:
                    multiplier[i] = max(multiplier[i], 0.0)
            return SOLVED
        if q < 0:
            refine(A, b, factors, count, x, y, multiplier)
            sweeps += 1
            continue
        status, count = enter(A, b, equal, near, factors, count, q, y, reach, multiplier, certificate)
        if status == BLOCKED:
            return BLOCKED
        if count > 0 and factors.rows[count - 1] == q:
            skipped[:] = False
        else:
            skipped[q] = True
    refine(A, b, factors, count, x, y, multiplier)
    return CAPPED
