"""The projection P of a cluster: the least change of motion, in the mass metric, that chosen rows allow."""

import numpy as np

from comotion_server.kernels.cluster_parts import parts_of
from comotion_server.kernels.cluster_rows import NOT_REACTING, add_row, along_row
from comotion_server.kernels.dual_active_set import BLOCKED, ROUNDING, SOLVED, project, terms_of
from comotion_server.kernels.impulse_shares import share_push
from comotion_server.kernels.jit import jit
from comotion_server.kernels.large_parts import project_large
from comotion_server.kernels.orthogonal_rows import inner

LARGE = 100  # rows of a part above which the sparse method is faster
TIGHT = 1e-11  # of a row's terms: an opening speed that counts as none, so that the row may carry a share


@jit
def part_matrix(rows, part_rows, place, A):
    """Writes the dense rows A (m, 6 count) of one part; place (k,): where a member stands in it."""
    A[:] = 0.0
    for r in range(len(part_rows)):
        for side in range(2):
            j = rows.link[part_rows[r], side]
            if j != NOT_REACTING:
                for k in range(6):
                    A[r, 6 * place[j] + k] += rows.part[part_rows[r], side, k]


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
    m, n = len(part_rows), 6 * len(part_members)
    A, b, start, end, forces = np.empty((m, n)), np.empty(m), np.empty(n), np.empty(n), np.empty(m)
    fixed, mark = np.empty(m, np.bool_), np.zeros(m, np.bool_)
    for j in range(len(part_members)):
        place[part_members[j]] = j
        for k in range(6):
            start[6 * j + k] = x[part_members[j], k]
    part_matrix(rows, part_rows, place, A)
    for r in range(m):
        b[r], fixed[r] = bounds[part_rows[r]], equal[part_rows[r]]
    status = project(A, b, fixed, weak, start, end, forces, mark)
    if status != BLOCKED:
        share_tight(A, b, fixed, start, end, forces)
    for r in range(m):
        certificate[part_rows[r]], multiplier[part_rows[r]] = mark[r], forces[r]
    for j in range(len(part_members)):
        for k in range(6):
            y[part_members[j], k] = end[6 * j + k]
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
            status = project_large_part(
                rows, bounds, equal, part_rows, part_members, place, x, y, multiplier, certificate
            )
        else:
            status = project_part(
                rows, bounds, equal, weak, part_rows, part_members, place, x, y, multiplier, certificate
            )
        worst = max(worst, status)
    return worst, parts
