"""Coulomb friction of a cluster, once its normal impulses are known.

Tangential impulses take as much kinetic energy as they can, |l_t| <= mu l_n for each contact, while the normal speeds
of loaded contacts stay as restitution left them: their rows T are projected to T' = T (I - Q Q^T), Q spanning the
loaded normals N, and the normal impulses change by what that costs. The change of energy is the minimum of a convex
function that starts at zero: it never rises. Bounds follow the normal impulses in a few rounds.

Legend: f loaded contacts, n unknowns; N (f,n) normals, T (2f,n) tangents, two per contact; c opening speeds; g slip
with the normal speeds taken out; l_n, l_t impulses; d = T'^T l_t the change of the unknowns.
"""

from math import sqrt

import numpy as np

from comotion_server.kernels.cluster_parts import parts_of
from comotion_server.kernels.cluster_projection import part_matrix
from comotion_server.kernels.cluster_rows import along_row, bounds_along, rows_along
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
from comotion_server.kernels.reflections import RUBBED, WORK, largest_of
from comotion_server.kernels.vectors import cross, row, unit

ROUNDS = 60  # of bounds; each starts where the last ended
FULL_ROUNDS = 20  # after these, bounds go half the way: where friction and normal impulses chase each other
SETTLED = 1e-11  # relative change of the bounds that ends the rounds
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
    push[:], pressing[:] = 0.0, pressed
    for j in range(count):
        advance(push, along[j], factors.basis[j])
    if count == len(pressed):
        solve_back(factors, count, along)
        for j in range(count):
            pressing[factors.rows[j]] += along[j]
        return
    one_sided = np.ones(len(pressed), np.bool_)
    for i in range(len(pressed)):
        advance(push, pressed[i], N[i])
    while not share_push(N, push, one_sided, pressing) and one_sided[0]:
        one_sided[:] = False


@jit
def take_out_normals(factors, count, N, c, T, slip, g, inside):
    """Tangents (2f,n) without their part in the span of the normals, and their slip g (2f,) with those stopped."""
    stopped, toward, h = np.empty(count), np.zeros(N.shape[1]), np.empty(len(factors.rows))
    for j in range(count):
        stopped[j] = c[factors.rows[j]]
    solve_forward(factors, count, stopped)
    for j in range(count):
        advance(toward, stopped[j], factors.basis[j])
    for k in range(len(T)):
        g[k] = slip[k] - inner(T[k], toward)
        if split_row(factors, count, T[k], h, inside[k]) <= DEPENDENT * DEPENDENT * inner(T[k], T[k]):
            g[k], inside[k, :] = 0.0, 0.0


@jit
def rub_part(N, c, T, slip, friction, pressing, rubbing, d):
    """Friction of one part; the heat [J]. pressing (f,) goes in frictionless and comes out with friction.

    Writes rubbing (2f,), tangential impulses, and d (n,). A contact that would have to pull has pressing < 0.
    """
    f, n = N.shape
    factors, count = span_of(N)
    g, inside = np.empty(2 * f), np.empty((2 * f, n))
    take_out_normals(factors, count, N, c, T, slip, g, inside)
    pressed, radius = pressing.copy(), np.zeros(f)
    rubbing[:], d[:] = 0.0, 0.0
    for attempt in range(ROUNDS):
        change, step = 0.0, 1.0 if attempt < FULL_ROUNDS else 0.5
        for i in range(f):
            wanted = friction[i] * max(pressing[i], 0.0)
            change = max(change, abs(wanted - radius[i]) / max(wanted, radius[i], 1e-300))
            radius[i] += step * (wanted - radius[i])
        if change <= SETTLED:
            break
        descend(inside, g, radius, rubbing, d)
        press_again(N, factors, count, pressed, T, rubbing, pressing)
    heat = -inner(slip, rubbing) - 0.5 * inner(d, d)
    for i in range(f):
        heat -= (pressing[i] - pressed[i]) * c[i]
    return heat


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
def part_arrays(normal, tangent, chosen, members, x):
    """Dense N, c, T and slip of the loaded rows `chosen` of one part."""
    f, n = len(chosen), 6 * len(members)
    place, columns = np.empty(len(x), np.int64), np.arange(n).reshape(-1, 6)
    for j in range(len(members)):
        place[members[j]] = j
    N, T, one, c, slip = np.empty((f, n)), np.empty((2 * f, n)), np.empty((f, n)), np.empty(f), np.empty(2 * f)
    part_matrix(normal[0], chosen, place, columns, N)
    for k in range(2):
        part_matrix(tangent[k][0], chosen, place, columns, one)
        for r in range(f):
            T[2 * r + k] = one[r]
            slip[2 * r + k] = along_row(tangent[k][0], chosen[r], x) - tangent[k][1][chosen[r]]
            c[r] = along_row(normal[0], chosen[r], x) - normal[1][chosen[r]]
    return N, c, T, slip


@jit
def rub(bodies, contacts, cluster, normal, friction, v, w, x, pressed, impulse, book):
    """Friction (c,) at the contacts that normal impulses `pressed` (c,) have just loaded.

    normal: rows and bounds along the normals. Changes x (k,6) and pressed, adds the tangential part to impulse (c,3).
    A contact that would have to pull loses its grip, and the others of its part are answered again without it.
    """
    rows, bounds = normal
    first, second = tangents_of(contacts.normal[: len(bounds)])
    tangent = (
        (rows_along(cluster, contacts, first), bounds_along(bodies, contacts, first, v, w)),
        (rows_along(cluster, contacts, second), bounds_along(bodies, contacts, second, v, w)),
    )
    loaded, least = np.empty(len(bounds), np.bool_), LOADED * largest_of(pressed)
    for i in range(len(bounds)):
        loaded[i] = pressed[i] > least
    parts = parts_of(rows.link, loaded, len(x))
    for p in range(parts.total):
        chosen = parts.rows[parts.first_row[p] : parts.first_row[p + 1]].copy()
        members = parts.members[parts.first_member[p] : parts.first_member[p + 1]]
        while len(chosen) > 0:
            f = len(chosen)
            N, c, T, slip = part_arrays(normal, tangent, chosen, members, x)
            pressing, grip, rubbing, d = np.empty(f), np.empty(f), np.empty(2 * f), np.empty(N.shape[1])
            for r in range(f):
                pressing[r], grip[r] = pressed[chosen[r]], friction[chosen[r]]
            heat = rub_part(N, c, T, slip, grip, pressing, rubbing, d)
            weakest = 0
            for r in range(f):
                weakest = r if pressing[r] < pressing[weakest] else weakest
            if pressing[weakest] >= 0.0:
                book[RUBBED] += heat
                give(chosen, members, bounds, tangent, (first, second), pressing, rubbing, d, x, pressed, impulse, book)
                break
            for r in range(weakest, f - 1):
                chosen[r] = chosen[r + 1]
            chosen = chosen[: f - 1]


@jit
def give(chosen, members, bounds, tangent, directions, pressing, rubbing, d, x, pressed, impulse, book):
    """Books the friction of one part and applies it."""
    for r in range(len(chosen)):
        i = chosen[r]
        book[WORK] += (pressing[r] - pressed[i]) * bounds[i]
        pressed[i] = pressing[r]
        for k in range(2):
            rubbed = rubbing[2 * r + k]
            book[WORK] += rubbed * tangent[k][1][i]
            for m in range(3):
                impulse[i, m] += rubbed * directions[k][i, m]
    for j in range(len(members)):
        for k in range(6):
            x[members[j], k] += d[6 * j + k]
