"""The projection P of a cluster: the least change of motion, in the mass metric, that chosen rows allow."""

import numpy as np

from comotion_server.kernels.cluster_parts import parts_of
from comotion_server.kernels.cluster_rows import NOT_REACTING, along_row
from comotion_server.kernels.dual_active_set import BLOCKED, SOLVED, project, terms_of
from comotion_server.kernels.impulse_shares import share_push
from comotion_server.kernels.jit import jit
from comotion_server.kernels.orthogonal_rows import inner

TIGHT = 1e-11  # of a row's terms: an opening speed that counts as none, so that the row may carry a share


@jit
def part_matrix(rows, part_rows, place, count):
    """The dense rows (m, 6 count) of one part; place (k,): where a member stands in it."""
    A = np.zeros((len(part_rows), 6 * count))
    for r in range(len(part_rows)):
        for side in range(2):
            j = rows.link[part_rows[r], side]
            if j != NOT_REACTING:
                for k in range(6):
                    A[r, 6 * place[j] + k] += rows.part[part_rows[r], side, k]
    return A


@jit
def project_row(rows, bounds, i, x, y, multiplier):
    """The part of a single row, in closed form: status."""
    speed = along_row(rows, i, x) - bounds[i]
    if speed >= 0.0:
        return SOLVED
    if rows.size[i] == 0.0:
        return BLOCKED
    multiplier[i] = -speed / rows.size[i] ** 2
    for side in range(2):
        j = rows.link[i, side]
        if j != NOT_REACTING:
            for k in range(6):
                y[j, k] += multiplier[i] * rows.part[i, side, k]
    return SOLVED


@jit
def share_tight(A, b, equal, y, push, multiplier):
    """Makes the multipliers unique where more rows are tight than carry a load."""
    reach = np.abs(y)
    tight = np.zeros(len(b), np.bool_)
    loaded = 0
    for i in range(len(b)):
        tight[i] = equal[i] or abs(inner(A[i], y) - b[i]) <= TIGHT * terms_of(A[i], reach + np.abs(push), b[i])
        if multiplier[i] != 0.0:
            tight[i] = True
            loaded += 1
    if loaded == 0 or loaded == tight.sum():
        return
    chosen = np.flatnonzero(tight)
    shares = multiplier[chosen]
    share_push(A[chosen], push, ~equal[chosen], shares)
    multiplier[chosen] = shares


@jit
def project_part(rows, bounds, equal, weak, part_rows, part_members, place, x, y, multiplier, certificate):
    """The projection of one part: status."""
    A = part_matrix(rows, part_rows, place, len(part_members))
    b, fixed = bounds[part_rows], equal[part_rows]
    start = x[part_members].reshape(A.shape[1])
    end, forces, mark = np.empty(A.shape[1]), np.empty(len(b)), np.zeros(len(b), np.bool_)
    status = project(A, b, fixed, weak, start, end, forces, mark)
    if status == BLOCKED:
        certificate[part_rows] = mark
        return status
    share_tight(A, b, fixed, end, end - start, forces)
    multiplier[part_rows] = forces
    for j in range(len(part_members)):
        y[part_members[j]] = end[6 * j : 6 * j + 6]
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
    for p in range(parts.count):
        part_rows = parts.rows[parts.first_row[p] : parts.first_row[p + 1]]
        part_members = parts.members[parts.first_member[p] : parts.first_member[p + 1]]
        if len(part_rows) == 1 and not equal[part_rows[0]]:
            status = project_row(rows, bounds, part_rows[0], x, y, multiplier)
            certificate[part_rows[0]] |= status == BLOCKED
        else:
            for j in range(len(part_members)):
                place[part_members[j]] = j
            status = project_part(
                rows, bounds, equal, weak, part_rows, part_members, place, x, y, multiplier, certificate
            )
        worst = max(worst, status)
    return worst, parts
