"""Impacts one after another, the fastest approach first: the law `sequential`."""

import numpy as np

from comotion_server.kernels.cluster_projection import project_cluster
from comotion_server.kernels.dual_active_set import CAPPED, SOLVED
from comotion_server.kernels.jit import jit
from comotion_server.kernels.reflections import OWN, approaches, turn_back, who_approaches

MOST_PER_ROW = 1000  # impacts per contact; above it the rest is left


@jit
def _fastest_pair(rows, speeds, chosen):
    """Keeps in chosen (c,) only the contacts of the pair of bodies that approaches fastest; whether there is one."""
    worst = -1
    for i in range(len(speeds)):
        if chosen[i] and rows.size[i] > 0.0 and (worst < 0 or speeds[i] < speeds[worst]):
            worst = i
    for i in range(len(speeds)):
        chosen[i] &= worst >= 0 and rows.link[i, 0] == rows.link[worst, 0] and rows.link[i, 1] == rows.link[worst, 1]
    return worst >= 0


@jit
def take_turns(rows, bounds, restitution, x, impulse, book):
    """Each impact answers all contacts of one pair of bodies that approach, ties the first row: status and impacts.

    x (k,6) become the velocities after, impulse (c,) what it took; adds to book (3,). CAPPED: some rows still approach.
    """
    count = len(bounds)
    chosen, speeds, multiplier, done = np.empty(count, np.bool_), np.empty(count), np.empty(count), 0
    equal, certificate, y = np.zeros(count, np.bool_), np.empty(count, np.bool_), np.empty_like(x)
    impulse[:] = 0.0
    fastest, hardest = approaches(rows, bounds, x, speeds)
    while done < MOST_PER_ROW * count and who_approaches(rows, speeds, fastest, hardest, chosen):
        if not _fastest_pair(rows, speeds, chosen):
            break
        _, parts = project_cluster(rows, bounds, chosen, equal, 0.0, x, y, multiplier, certificate)
        turn_back(bounds, restitution, OWN, parts, multiplier, speeds, y, x, impulse, book)
        done += 1
        approaches(rows, bounds, x, speeds)
    return SOLVED if done < MOST_PER_ROW * count else CAPPED, done
