"""Impacts one after another, the fastest approach first: the law `sequential`."""

import numpy as np

from comotion_server.kernels.cluster_projection import project_row
from comotion_server.kernels.cluster_rows import add_row
from comotion_server.kernels.dual_active_set import CAPPED, SOLVED
from comotion_server.kernels.jit import jit
from comotion_server.kernels.reflections import LOST, WORK, approaches, who_approaches

MOST_PER_ROW = 1000  # impacts per contact; above it the rest is left


@jit
def take_turns(rows, bounds, restitution, x, impulse, book):
    """Each impact answers one contact with its own restitution, ties the lowest row: status and impacts.

    x (k,6) become the velocities after, impulse (c,) what it took; adds to book (3,). CAPPED: some rows still approach.
    """
    count = len(bounds)
    chosen, speeds, turned, done = np.empty(count, np.bool_), np.empty(count), np.empty(count), 0
    impulse[:] = 0.0
    fastest, hardest = approaches(rows, bounds, x, speeds)
    while done < MOST_PER_ROW * count and who_approaches(rows, speeds, fastest, hardest, chosen):
        worst = -1
        for i in range(count):
            if chosen[i] and rows.size[i] > 0.0 and (worst < 0 or speeds[i] < speeds[worst]):
                worst = i
        if worst < 0:
            break
        e, turned[worst] = restitution[worst], 0.0
        project_row(rows, bounds, worst, x, turned)
        add_row(rows, worst, e * turned[worst], x)
        impulse[worst] += (1.0 + e) * turned[worst]
        book[LOST] -= 0.5 * (1.0 - e * e) * speeds[worst] * turned[worst]
        book[WORK] += (1.0 + e) * turned[worst] * bounds[worst]
        done += 1
        approaches(rows, bounds, x, speeds)
    return SOLVED if done < MOST_PER_ROW * count else CAPPED, done
