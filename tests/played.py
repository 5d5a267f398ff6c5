"""Playing a simulation and looking at what it did: for tests of physics."""

from collections import Counter

import numpy as np

SAME_TIME = 1e-12  # [s]: rows of one patch, or of one cluster, have one time


def play(sim, duration, dt, **given):
    """Steps of `dt` [s] over a duration [s]: all impacts, in order."""
    return [impact for _ in range(round(duration / dt)) for impact in sim.step(dt, **given).impacts]


def hits(impacts, *bodies):
    """Times [s] at which bodies hit: each pair once at a time, however many points its patch has."""
    pairs = {(i.body_a, i.body_b, round(i.time / SAME_TIME)): i for i in impacts if set(bodies) <= {i.body_a, i.body_b}}
    return np.array(sorted(impact.time for impact in pairs.values()))


def times(impacts):
    """Distinct times [s] of impacts, and how many rows each has."""
    return Counter(round(impact.time / SAME_TIME) * SAME_TIME for impact in impacts)


def momentum(sim):
    """Total (3,) [kg m/s] of the bodies with a mass."""
    return np.nansum(sim.bodies.mass[:, None] * sim.bodies.velocity, axis=0)


def row_of(sim, name):
    return sim.bodies.names.index(name)
