"""Generalised reflections with restitution inside the loop: the law `together`.

Smith, Kaufman, Vouga, Tamstorf, Grinspun (2012, "Reflections on simultaneous impact") reflect the velocities in the
polyhedron of those contacts that approach, until none does. Here each reflection keeps only a part e of what it turns
back, so that the law passes smoothly into plastic impact, and is the limit of impacts one after another as gaps vanish:

    V = rows that approach;  y = P_V(x);  x <- y + e (y - x),   e = sum e_i l_i |c_i| / sum l_i |c_i|  over a part of V,

l the multipliers of P_V and c the opening speeds. Since y - x is orthogonal to y (relative to what is given), kinetic
energy changes by exactly  (1 + e) l.bound - (1 - e^2) |y - x|^2 / 2:  the work of given motion and the loss.
"""

import numpy as np

from comotion_server.kernels.cluster_projection import project_cluster
from comotion_server.kernels.cluster_rows import along_row
from comotion_server.kernels.dual_active_set import BLOCKED, CAPPED, JAMMED, SOLVED
from comotion_server.kernels.jit import jit

APPROACH = 1e-9  # of the largest approach before: slower is none. A constant of the law: it decides who takes part
MOST_ROWS = 1_000_000  # rows times reflections; above it the rest is taken at once. Mass ratio 1e10 against a wall: 6e5
PATIENCE = 200  # reflections before asking whether the cluster carries a stress of its own; ten times that to ask again
CHECK, REFLECT, STRESS, RESTART, FINISH = 0, 1, 2, 3, 4  # stages of an answer
OWN = -1.0  # in the place of a restitution: that of the contacts
RESTITUTION = (0.0, OWN, 0.0, 1.0, 0.0)  # of each stage
LOST, WORK, RUBBED = 0, 1, 2  # in a book (3,) [J]: taken by restitution; done by motion that is given; by friction


@jit
def approaches(rows, bounds, x, speeds):
    """Opening speeds (c,) at x; returns the largest approach as a speed and as sqrt(2 energy)."""
    fastest = hardest = 0.0
    for i in range(len(bounds)):
        speeds[i] = along_row(rows, i, x) - bounds[i]
        fastest = max(fastest, -speeds[i])
        if rows.size[i] > 0.0:
            hardest = max(hardest, -speeds[i] / rows.size[i])
    return fastest, hardest


@jit
def who_approaches(rows, speeds, fastest, hardest, chosen):
    """Marks in chosen (c,) the rows that approach noticeably, by speed or by energy; whether there are any."""
    found = False
    for i in range(len(speeds)):
        c = speeds[i]
        chosen[i] = c < 0.0 and (c < -APPROACH * fastest or c < -APPROACH * hardest * rows.size[i])
        found |= chosen[i]
    return found


@jit
def turn_back(bounds, restitution, alike, parts, multiplier, speeds, y, x, impulse, book):
    """Reflects x (k,6) about its projection y, e for each part: `alike`, or of `restitution` if that is below zero.

    Adds to impulse (c,) and the book; returns the least e that was used.
    """
    energy, elastic, least = np.zeros(parts.total), np.zeros(parts.total), 1.0
    for i in parts.rows:
        share = -multiplier[i] * speeds[i]
        energy[parts.of_row[i]] += share
        elastic[parts.of_row[i]] += (restitution[i] if alike < 0.0 else alike) * share
    for p in range(parts.total):
        elastic[p] = min(max(elastic[p] / energy[p], 0.0), 1.0) if energy[p] > 0.0 else 0.0
        book[LOST] += 0.5 * (1.0 - elastic[p] ** 2) * energy[p]
        least = min(least, elastic[p])
    for i in parts.rows:
        given = (1.0 + elastic[parts.of_row[i]]) * multiplier[i]
        impulse[i] += given
        book[WORK] += given * bounds[i]
    for j in parts.members:
        for k in range(6):
            x[j, k] = y[j, k] + elastic[parts.of_member[j]] * (y[j, k] - x[j, k])
    return least


@jit
def common(a, b):
    """Whether two marks (c,) have a row in common."""
    found = False
    for i in range(len(a)):
        found |= a[i] and b[i]
    return found


@jit
def largest_of(values):
    """The largest of values (c,), at least zero."""
    largest = 0.0
    for value in values:
        largest = max(largest, abs(value))
    return largest


@jit
def reflect(rows, bounds, restitution, x, impulse, book, certificate):
    """Answers all rows that approach: status and reflections.

    All of it is one projection after another, in stages:

    CHECK   that rows and given motion allow any motion at all: else BLOCKED with its certificate (c,), x unchanged;
    REFLECT while rows approach, if there is any restitution;
    STRESS  asked when that does not end: rows that still approach and press on each other with no net push (l >= 0,
            A^T l = 0) can never part, whatever they do: JAMMED, they stop;
    RESTART when elastic reflections run out: from the start, all rows at once, elastically (CAPPED);
    FINISH  all rows at once, plastically: what is too slow to count, or was left.

    x (k,6) become the velocities after, impulse (c,) what it took; adds to book (3,).
    """
    count = len(bounds)
    y, multiplier, speeds, equal = np.empty_like(x), np.empty(count), np.empty(count), np.zeros(count, np.bool_)
    chosen, everywhere, rest = np.empty(count, np.bool_), np.ones(count, np.bool_), np.zeros_like(x)
    before, lost, work = x.copy(), book[LOST], book[WORK]
    impulse[:] = 0.0
    fastest, hardest = approaches(rows, bounds, x, speeds)
    bounces, given = largest_of(restitution) > 0.0, largest_of(bounds) > 0.0
    most, patience, done, status, least = max(1, MOST_ROWS // count), PATIENCE, 0, SOLVED, 0.0
    stage = CHECK if given else REFLECT
    while True:
        if stage == REFLECT:
            if not bounces or not who_approaches(rows, speeds, fastest, hardest, chosen):
                stage = FINISH
            elif done == patience:
                stage, patience = STRESS, 10 * patience
            elif done == most:
                stage, status = RESTART if least == 1.0 else FINISH, max(status, CAPPED)
                if stage == RESTART:
                    x[:], book[LOST], book[WORK], impulse[:] = before, lost, work, 0.0
                    approaches(rows, bounds, x, speeds)
        state, parts = project_cluster(
            rows,
            rows.size if stage == STRESS else bounds,
            chosen if stage == REFLECT else everywhere,
            equal,
            0.0,
            rest if stage == STRESS else x,
            y,
            multiplier,
            certificate,
        )
        if stage == CHECK:
            if state == BLOCKED:
                return BLOCKED, 0
            stage = REFLECT
        elif stage == STRESS:
            jammed = common(chosen, certificate)
            status, stage = (max(status, JAMMED), FINISH) if jammed else (status, REFLECT)
        else:
            e = RESTITUTION[stage]
            least = turn_back(bounds, restitution, e, parts, multiplier, speeds, y, x, impulse, book)
            status = max(status, state)
            if stage == FINISH:
                return status, done
            approaches(rows, bounds, x, speeds)
            done += stage == REFLECT
            stage = REFLECT if stage == REFLECT else FINISH
