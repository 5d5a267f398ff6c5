"""The impacts of a step: a row for every contact point of every impact, in the order of time."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit


class ImpactLog(NamedTuple):
    """Room for c contact points; world frame, SI. A row stands for a pair of bodies a, b, a the lower row."""

    bodies: np.ndarray  # (c,2) int64
    time: np.ndarray  # (c,) local, of the impact [s]
    contact_time: np.ndarray  # (c,) when the gap would have been zero [s]
    point: np.ndarray  # (c,3) on b [m]
    normal: np.ndarray  # (c,3) unit, from a to b
    impulse: np.ndarray  # (c,3) on b [N s]
    approach: np.ndarray  # (c,) speed before; negative: the points parted already [m/s]
    restitution: np.ndarray  # (c,)
    cluster: np.ndarray  # (c,) int64 number of the impact: contacts that were answered together have the same
    total: np.ndarray  # (2,) int64 rows in use, impacts
    books: np.ndarray  # (3,) largest relative errors of momentum, angular momentum and energy of all impacts


ROWS, IMPACTS = 0, 1  # of `total`


@jit
def new_impact_log(capacity):
    """An empty log."""
    return ImpactLog(
        np.empty((capacity, 2), np.int64),
        np.empty(capacity),
        np.empty(capacity),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
        np.empty(capacity),
        np.empty(capacity),
        np.empty(capacity, np.int64),
        np.zeros(2, np.int64),
        np.zeros(3),
    )


@jit
def clear(log):
    """Forget all."""
    log.total[:] = 0
    log.books[:] = 0.0
