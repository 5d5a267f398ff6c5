"""The projection P of a cluster: the least change of motion, in the mass metric, that chosen rows allow."""

import numpy as np

from comotion_server.kernels.cluster_parts import parts_of
from comotion_server.kernels.cluster_rows import NOT_REACTING, add_row, along_row
from comotion_server.kernels.dual_active_set import (
    BLOCKED,
    ROUNDING,
    SOLVED,
    begin_with_equalities,
    project,
    slack_of,
    terms_of,
)
from comotion_server.kernels.impulse_shares import share_push
from comotion_server.kernels.jit import jit
from comotion_server.kernels.large_parts import project_large
from comotion_server.kernels.orthogonal_rows import inner, new_factors, split_row

LARGE = 100  # rows of a part above which the sparse method is faster
SAME = 1e-14  # relative difference of two numbers of a row that counts as none
TIGHT = 1e-11  # of a row's terms: an opening speed that counts as none, so that the row may carry a share


@jit
def columns_of(rows, part_rows, part_members, place, columns):
    """Where the unknowns of a part stand in its matrix, columns (members,6), -1 where no row has any; how many do."""
    columns[:], total = -1, 0
    for j in range(len(part_members)):
        place[part_members[j]] = j
    for i in part_rows:
        for side in range(2):
            j = rows.link[i, side]
            if j != NOT_REACTING:
                for k in range(6):
                    if rows.part[i, side, k] != 0.0:
                        columns[place[j], k] = 0
    for j in range(len(part_members)):
        for k in range(6):
            if columns[j, k] == 0:
                columns[j, k] = total
                total += 1
    return total


@jit
def part_matrix(rows, part_rows, place, columns, A):
    """Writes the dense rows A (m,n) of one part; place (k,): where a member stands in it."""
    A[:] = 0.0
    for r in range(len(part_rows)):
        for side in range(2):
            j = rows.link[part_rows[r], side]
            if j != NOT_REACTING:
                for k in range(6):
                    if columns[place[j], k] >= 0:
                        A[r, columns[place[j], k]] += rows.part[part_rows[r], side, k]


@jit
def project_row(rows, bounds, i, y, multiplier):
    """The part of a single row, in closed form: status. Twice: rounding of the row's norm must not add up."""
    if rows.size[i] == 0.0:
        return SOLVED if bounds[i] <= 0.0 else BLOCKED
    for _ in range(2):
        speed = along_row(rows, i, y) - bounds[i]
        if speed >= 0.0 and multiplier[i] == 0.0:
            return SOLVED
        step = -speed / rows.size[i] ** 2
        multiplier[i] += step
        add_row(rows, i, step, y)
    return SOLVED


@jit
def share_tight(A, b, equal, start, end, multiplier):
    """Makes the multipliers unique where more rows are tight than carry a load."""
    m, n = A.shape
    tight, count, loaded = np.empty(m, np.int64), 0, 0
    reach, push = np.empty(n), np.empty(n)
    for k in range(n):
        push[k] = end[k] - start[k]
        reach[k] = abs(end[k]) + abs(push[k])
    for i in range(m):
        loaded += multiplier[i] != 0.0
        if multiplier[i] != 0.0 or equal[i] or abs(inner(A[i], end) - b[i]) <= TIGHT * terms_of(A[i], reach, b[i]):
            tight[count] = i
            count += 1
    if loaded == 0 or loaded == count:
        return
    chosen, shares, one_sided = np.empty((count, n)), np.empty(count), np.empty(count, np.bool_)
    for r in range(count):
        chosen[r], shares[r], one_sided[r] = A[tight[r]], multiplier[tight[r]], not equal[tight[r]]
    share_push(chosen, push, one_sided, shares)
    for r in range(count):
        multiplier[tight[r]] = shares[r]


@jit
def project_part(rows, bounds, equal, weak, part_rows, part_members, place, x, y, multiplier, certificate):
    """The projection of one part: status."""
    columns = np.empty((len(part_members), 6), np.int64)
    m, n = len(part_rows), columns_of(rows, part_rows, part_members, place, columns)
    A, b, start, end, forces = np.empty((m, n)), np.empty(m), np.empty(n), np.empty(n), np.empty(m)
    fixed, mark = np.empty(m, np.bool_), np.zeros(m, np.bool_)
    for j in range(len(part_members)):
        for k in range(6):
            if columns[j, k] >= 0:
                start[columns[j, k]] = x[part_members[j], k]
    part_matrix(rows, part_rows, place, columns, A)
    for r in range(m):
        b[r], fixed[r] = bounds[part_rows[r]], equal[part_rows[r]]
    status = project(A, b, fixed, weak, start, end, forces, mark)
    if status != BLOCKED:
        share_tight(A, b, fixed, start, end, forces)
    for r in range(m):
        certificate[part_rows[r]], multiplier[part_rows[r]] = mark[r], forces[r]
    for j in range(len(part_members)):
        for k in range(6):
            if columns[j, k] >= 0:
                y[part_members[j], k] = end[columns[j, k]]
    return status


@jit
def satisfied(rows, bounds, equal, part_rows, x):
    """Whether a part has nothing to answer: no equality, no row closer than rounding."""
    for i in part_rows:
        if equal[i]:
            return False
        speed, terms = -bounds[i], abs(bounds[i])
        for side in range(2):
            j = rows.link[i, side]
            if j != NOT_REACTING:
                for k in range(6):
                    speed += rows.part[i, side, k] * x[j, k]
                    terms += abs(rows.part[i, side, k] * x[j, k])
        if speed < -ROUNDING * terms:
            return False
    return True


@jit
def left_out(A, b, equal, weak, x, out):
    """Marks rows out (m,) within `weak` (relative) of the span of the equalities that stay, if they hold by these."""
    m, n = A.shape
    factors, h, z, y, reach = new_factors(min(m, n), n), np.empty(m), np.empty(n), np.empty(n), np.zeros(n)
    count = begin_with_equalities(A, b, equal, weak, factors, x, y, h, reach)
    for i in range(m):
        near = split_row(factors, count, A[i], h, z) <= weak * weak * inner(A[i], A[i])
        out[i] = near and (equal[i] or b[i] - inner(A[i], y) <= slack_of(A[i], z, reach, b[i]))
    for j in range(count):
        out[factors.rows[j]] = False


@jit
def mark_doubles(A, b, equal, out):
    """Marks of inequalities (m,) with the same numbers, but for rounding, all but the strictest."""
    for i in range(len(b)):
        for j in range(i):
            if out[i] or out[j] or equal[i] or equal[j]:
                continue
            same = True
            for k in range(A.shape[1]):
                same &= abs(A[i, k] - A[j, k]) <= SAME * (abs(A[i, k]) + abs(A[j, k]))
            if same:
                out[i if b[i] <= b[j] else j] = True


@jit
def without_doubles(rows, bounds, equal, weak, part_rows, x):
    """The rows of a part but those that follow from others of the same pair of bodies; these follow each other."""
    stays, first, last = np.ones(len(part_rows), np.bool_), 0, 0
    while first < len(part_rows):
        a, b = rows.link[part_rows[first]]
        while last < len(part_rows) and rows.link[part_rows[last], 0] == a and rows.link[part_rows[last], 1] == b:
            last += 1
        of_pair = part_rows[first:last]
        A, start, out = np.empty((len(of_pair), 12)), np.zeros(12), np.zeros(len(of_pair), np.bool_)
        for side in range(2):
            if rows.link[of_pair[0], side] != NOT_REACTING:
                start[6 * side : 6 * side + 6] = x[rows.link[of_pair[0], side]]
            A[:, 6 * side : 6 * side + 6] = rows.part[of_pair, side]
        if equal[of_pair].any():
            left_out(A, bounds[of_pair], equal[of_pair], weak, start, out)
        mark_doubles(A, bounds[of_pair], equal[of_pair], out)
        stays[first:last] = ~out
        first = last
    return part_rows[stays]


@jit
def project_large_part(rows, bounds, equal, part_rows, part_members, place, x, y, multiplier, certificate):
    """As `project_part`, sparse; multipliers are unique but not those of least norm."""
    m, k = len(part_rows), len(part_members)
    link, part, size, b = np.full((m, 2), NOT_REACTING), np.empty((m, 2, 6)), np.empty(m), np.empty(m)
    fixed, mark, forces, start = equal[part_rows], np.zeros(m, np.bool_), np.zeros(m), np.empty((k, 6))
    for j in range(k):
        place[part_members[j]] = j
        start[j] = x[part_members[j]]
    end = start.copy()
    for r in range(m):
        i = part_rows[r]
        part[r], size[r], b[r] = rows.part[i], rows.size[i], bounds[i]
        for side in range(2):
            if rows.link[i, side] != NOT_REACTING:
                link[r, side] = place[rows.link[i, side]]
    status = project_large(link, part, size, b, fixed, start, end, forces, mark)
    for r in range(m):
        certificate[part_rows[r]], multiplier[part_rows[r]] = mark[r], forces[r]
    for j in range(k):
        y[part_members[j]] = end[j]
    return status


@jit
def project_cluster(rows, bounds, chosen, equal, weak, x, y, multiplier, certificate):
    """Nearest y (k,6) to x (k,6) with opening speeds >= 0 (= 0 where equal) in the chosen rows (c,): status, parts.

    y - x = sum of multiplier (c,) times rows; multipliers are unique (those of least norm), zero where not chosen.
    BLOCKED: certificate (c,) marks rows that cannot hold together. A member that no multiplier reaches keeps its bits.
    """
    parts = parts_of(rows.link, chosen, len(x))
    multiplier[:], y[:], certificate[:] = 0.0, x, False
    place, worst = np.empty(len(x), np.int64), SOLVED
    for p in range(parts.total):
        part_rows = parts.rows[parts.first_row[p] : parts.first_row[p + 1]]
        part_members = parts.members[parts.first_member[p] : parts.first_member[p + 1]]
        if len(part_rows) == 1 and not equal[part_rows[0]]:
            status = project_row(rows, bounds, part_rows[0], y, multiplier)
            certificate[part_rows[0]] |= status == BLOCKED
        elif satisfied(rows, bounds, equal, part_rows, x):
            status = SOLVED
        elif len(part_rows) > LARGE:
            own = without_doubles(rows, bounds, equal, weak, part_rows, x)
            status = project_large_part(rows, bounds, equal, own, part_members, place, x, y, multiplier, certificate)
        else:
            status = project_part(
                rows, bounds, equal, weak, part_rows, part_members, place, x, y, multiplier, certificate
            )
        worst = max(worst, status)
    return worst, parts
