"""Generalised reflections with restitution inside the loop: the law `together`.

Smith, Kaufman, Vouga, Tamstorf, Grinspun (2012, "Reflections on simultaneous impact") reflect the velocities in the
polyhedron of those contacts that approach, until none does. Here each reflection keeps only a part e of what it turns
back, so that the law passes smoothly into plastic impact and equals the limit of impacts one after another as gaps vanish:

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
PATIENCE = 200  # reflections, before asking whether the cluster carries a stress of its own and can never part
LOST, WORK = 0, 1  # in a book (2,) [J]: taken by restitution; done by motion that is given


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
def reflect_once(rows, bounds, restitution, chosen, speeds, x, impulse, book, space):
    """One reflection of x (k,6) in the chosen rows: status, and the least e that was used."""
    y, multiplier, certificate, equal = space
    status, parts = project_cluster(rows, bounds, chosen, equal, 0.0, x, y, multiplier, certificate)
    if status == BLOCKED:
        return status, 0.0
    energy, elastic = np.zeros(parts.count), np.zeros(parts.count)
    for i in parts.rows:
        share = -multiplier[i] * speeds[i]
        energy[parts.of_row[i]] += share
        elastic[parts.of_row[i]] += restitution[i] * share
    least = 1.0
    for p in range(parts.count):
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
    return status, least


@jit
def space_for(rows, x):
    """Arrays that reflections work in: y, multiplier, certificate, equal."""
    count = len(rows.size)
    return np.empty_like(x), np.empty(count), np.zeros(count, np.bool_), np.zeros(count, np.bool_)


@jit
def take_all(rows, bounds, e, x, impulse, book, space):
    """One reflection with restitution e in all rows at once: status."""
    count = len(bounds)
    speeds = np.empty(count)
    approaches(rows, bounds, x, speeds)
    everywhere, alike = np.ones(count, np.bool_), np.full(count, e)
    status, _ = reflect_once(rows, bounds, alike, everywhere, speeds, x, impulse, book, space)
    return status


@jit
def stressed(rows, x, space):
    """Whether contacts press on each other with no net push (l >= 0, A^T l = 0): then no velocity parts them."""
    count = len(rows.size)
    y, multiplier, certificate, equal = space
    everywhere, apart = np.ones(count, np.bool_), rows.size.copy()
    status, _ = project_cluster(rows, apart, everywhere, equal, 0.0, np.zeros_like(x), y, multiplier, certificate)
    return status == BLOCKED


@jit
def reflect(rows, bounds, restitution, x, impulse, book):
    """Answers all rows that approach: x (k,6) becomes the velocities after, impulse (c,) what it took: status, count.

    When reflections do not end: with a stress of its own the cluster stops, JAMMED; elastic ones are taken once more
    from the start, all touching rows at once, and what is left plastically, CAPPED. book (2,) holds LOST and WORK.
    """
    count = len(bounds)
    space = space_for(rows, x)
    chosen, speeds, before, start_book = np.empty(count, np.bool_), np.empty(count), x.copy(), book.copy()
    impulse[:] = 0.0
    fastest, hardest = approaches(rows, bounds, x, speeds)
    most, done, status, least = max(1, MOST_ROWS // max(count, 1)), 0, SOLVED, 0.0
    jammed = ran_out = False
    while restitution.any() and who_approaches(rows, speeds, fastest, hardest, chosen):
        jammed = done == PATIENCE and least == 1.0 and stressed(rows, x, space)
        ran_out = done == most
        if jammed or ran_out:
            break
        state, least = reflect_once(rows, bounds, restitution, chosen, speeds, x, impulse, book, space)
        status = max(status, state)
        done += 1
        approaches(rows, bounds, x, speeds)
    if ran_out and least == 1.0:
        x[:], book[:], impulse[:] = before, start_book, 0.0
        take_all(rows, bounds, 1.0, x, impulse, book, space)
    status = max(status, take_all(rows, bounds, 0.0, x, impulse, book, space))
    if jammed:
        return max(status, JAMMED), done
    return max(status, CAPPED) if ran_out else status, done
