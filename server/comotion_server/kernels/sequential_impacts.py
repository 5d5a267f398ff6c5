"""Impacts one after another, the fastest approach first: the law `sequential`."""

import numpy as np

from comotion_server.kernels.cluster_rows import NOT_REACTING
from comotion_server.kernels.dual_active_set import CAPPED, SOLVED
from comotion_server.kernels.jit import jit
from comotion_server.kernels.reflections import (
    LOST,
    WORK,
    approaches,
    space_for,
    take_all,
    who_approaches,
)

MOST_PER_ROW = 1000  # impacts per contact; above it the rest is taken at once, plastically


@jit
def take_turns(rows, bounds, restitution, x, impulse, book):
    """As `reflections.reflect`: each impact answers one contact with its own restitution, ties the lowest row."""
    count = len(bounds)
    chosen, speeds, done = np.empty(count, np.bool_), np.empty(count), 0
    impulse[:] = 0.0
    fastest, hardest = approaches(rows, bounds, x, speeds)
    while who_approaches(rows, speeds, fastest, hardest, chosen):
        if done == MOST_PER_ROW * count:
            return max(CAPPED, take_all(rows, bounds, 0.0, x, impulse, book, space_for(rows, x))), done
        worst = -1
        for i in range(count):
            if chosen[i] and rows.size[i] > 0.0 and (worst < 0 or speeds[i] < speeds[worst]):
                worst = i
        if worst < 0:
            break
        e, ease = restitution[worst], rows.size[worst] ** 2
        given = -(1.0 + e) * speeds[worst] / ease
        for side in range(2):
            j = rows.link[worst, side]
            if j != NOT_REACTING:
                for k in range(6):
                    x[j, k] += given * rows.part[worst, side, k]
        impulse[worst] += given
        book[LOST] += 0.5 * (1.0 - e * e) * speeds[worst] ** 2 / ease
        book[WORK] += given * bounds[worst]
        done += 1
        approaches(rows, bounds, x, speeds)
    return SOLVED, done
