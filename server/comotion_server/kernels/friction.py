"""Coulomb friction of a cluster, once its normal impulses are known.

Tangential impulses take as much kinetic energy as they can, |l_t| <= mu l_n for each contact, while the normal speeds of
loaded contacts stay as restitution left them: their rows T are projected to T' = T (I - Q Q^T), Q spanning the loaded
normals N, and the normal impulses change by what that costs. The change of energy is the minimum of a convex function
that starts at zero: it never rises. Bounds follow the normal impulses in a few rounds.

Legend: f loaded contacts, n unknowns; N (f,n) normals, T (2f,n) tangents, two per contact; c opening speeds; g slip
with the normal speeds taken out; l_n, l_t impulses; d = T'^T l_t the change of the unknowns.
"""

from math import sqrt

import numpy as np

from comotion_server.kernels.cluster_parts import parts_of
from comotion_server.kernels.cluster_projection import part_matrix
from comotion_server.kernels.cluster_rows import along_row
from comotion_server.kernels.coulomb_discs import descend
from comotion_server.kernels.dual_active_set import DEPENDENT
from comotion_server.kernels.impulse_shares import share_push
from comotion_server.kernels.jit import jit
from comotion_server.kernels.orthogonal_rows import (
    advance,
    append_row,
    inner,
    new_factors,
    solve_back,
    solve_forward,
    split_row,
)
from comotion_server.kernels.reflections import RUBBED, WORK
from comotion_server.kernels.vectors import cross, row, unit

ROUNDS = 40  # of bounds; each starts where the last ended
SETTLED = 1e-13  # relative change of the bounds that ends the rounds
LOADED = 1e-13  # of the largest impulse: less is no load


@jit
def span_of(N):
    """Factors of the independent ones among rows N (f,n), and their count."""
    f, n = N.shape
    factors, count = new_factors(min(f, n), n), 0
    h, z = np.empty(len(factors.rows)), np.empty(n)
    for i in range(f):
        if count == len(factors.rows):
            break
        outside = split_row(factors, count, N[i], h, z)
        if outside > DEPENDENT * DEPENDENT * inner(N[i], N[i]):
            count = append_row(factors, count, i, h, z, sqrt(outside))
    return factors, count


@jit
def press_again(N, factors, count, pressed, T, rubbing, pressing):
    """Normal impulses (f,) from those before, `pressed`, so that rubbing (2f,) leaves the normal speeds alone."""
    push, along = np.zeros(N.shape[1]), np.empty(count)
    for k in range(len(rubbing)):
        advance(push, -rubbing[k], T[k])
    for j in range(count):
        along[j] = inner(factors.basis[j], push)
    push[:] = 0.0
    for j in range(count):
        advance(push, along[j], factors.basis[j])
    pressing[:] = pressed
    if count == len(pressed):
        solve_back(factors, count, along)
        for j in range(count):
            pressing[factors.rows[j]] += along[j]
        return
    for i in range(len(pressed)):
        advance(push, pressed[i], N[i])
    one_sided = np.ones(len(pressed), np.bool_)
    if not share_push(N, push, one_sided, pressing):
        share_push(N, push, ~one_sided, pressing)


@jit
def rub_part(N, c, T, slip, friction, pressing, rubbing, d):
    """Friction of one part; the heat [J]. pressing (f,) goes in frictionless and comes out with friction.

    Writes rubbing (2f,), tangential impulses, and d (n,). A contact that would have to pull is marked by pressing < 0.
    """
    f, n = N.shape
    factors, count = span_of(N)
    stopped, toward = np.empty(count), np.zeros(n)
    for j in range(count):
        stopped[j] = c[factors.rows[j]]
    solve_forward(factors, count, stopped)
    for j in range(count):
        advance(toward, stopped[j], factors.basis[j])
    g, inside, h = np.empty(2 * f), np.empty((2 * f, n)), np.empty(len(factors.rows))
    for k in range(2 * f):
        g[k] = slip[k] - inner(T[k], toward)
        split_row(factors, count, T[k], h, inside[k])
    pressed, radius, rubbing[:] = pressing.copy(), np.zeros(f), 0.0
    for _ in range(ROUNDS):
        change = 0.0
        for i in range(f):
            wanted = friction[i] * max(pressing[i], 0.0)
            change = max(change, abs(wanted - radius[i]) / max(wanted, radius[i], 1e-300))
            radius[i] = wanted
        if change <= SETTLED:
            break
        descend(inside, g, radius, rubbing, d)
        press_again(N, factors, count, pressed, T, rubbing, pressing)
    return -(inner(g, rubbing) + 0.5 * inner(d, d))


@jit
def tangents_of(normals):
    """Two unit directions (c,3) each, normal to `normals` (c,3) and to each other."""
    first, second = np.empty_like(normals), np.empty_like(normals)
    for i in range(len(normals)):
        n = row(normals, i)
        x, y, z = abs(n[0]), abs(n[1]), abs(n[2])
        other = (1.0, 0.0, 0.0) if x <= y and x <= z else ((0.0, 1.0, 0.0) if y <= z else (0.0, 0.0, 1.0))
        t = unit(cross(n, other))
        first[i, 0], first[i, 1], first[i, 2] = t
        second[i, 0], second[i, 1], second[i, 2] = cross(n, t)
    return first, second


@jit
def rub_rows(normal, tangent, friction, chosen, members, place, x, impulse, rubbing, book):
    """Friction of one part, its loaded rows `chosen`; a contact that would have to pull loses its grip."""
    rows, bounds = normal
    while len(chosen) > 0:
        N, f = part_matrix(rows, chosen, place, len(members)), len(chosen)
        T, slip, c = np.empty((2 * f, N.shape[1])), np.empty(2 * f), np.empty(f)
        for k in range(2):
            T[k::2] = part_matrix(tangent[k][0], chosen, place, len(members))
        for r in range(f):
            c[r] = along_row(rows, chosen[r], x) - bounds[chosen[r]]
            for k in range(2):
                slip[2 * r + k] = along_row(tangent[k][0], chosen[r], x) - tangent[k][1][chosen[r]]
        pressing, rub, d = impulse[chosen], np.empty(2 * f), np.zeros(N.shape[1])
        heat = rub_part(N, c, T, slip, friction[chosen], pressing, rub, d)
        weakest = np.argmin(pressing)
        if pressing[weakest] >= 0.0:
            book[RUBBED] += heat
            for r in range(f):
                i = chosen[r]
                book[WORK] += (pressing[r] - impulse[i]) * bounds[i]
                impulse[i] = pressing[r]
                for k in range(2):
                    rubbing[i, k] += rub[2 * r + k]
                    book[WORK] += rub[2 * r + k] * tangent[k][1][i]
            for j in range(len(members)):
                for k in range(6):
                    x[members[j], k] += d[6 * j + k]
            return
        chosen = np.delete(chosen, weakest)


@jit
def rub(normal, tangent, friction, x, impulse, rubbing, book):
    """Friction (c,) at the contacts that normal impulses (c,) have just loaded: changes x (k,6) and both impulses.

    normal: rows and bounds along the normals; tangent: two of these along the tangents; rubbing (c,2) is added to.
    """
    loaded = impulse > LOADED * impulse.max()
    parts = parts_of(normal[0].link, loaded, len(x))
    place = np.empty(len(x), np.int64)
    for p in range(parts.count):
        chosen = parts.rows[parts.first_row[p] : parts.first_row[p + 1]].copy()
        members = parts.members[parts.first_member[p] : parts.first_member[p + 1]]
        for j in range(len(members)):
            place[members[j]] = j
        if friction[chosen].any():
            rub_rows(normal, tangent, friction, chosen, members, place, x, impulse, rubbing, book)
