"""The pairs of bodies that may meet: what is known of each, and lists of the pairs of every body.

A pair has a row as long as the rooms of its bodies overlap (`neighbour_cells`), and rows are used again. Each pair is a
link in the lists of both its bodies: link 2 k belongs to the first body of row k, link 2 k + 1 to the second.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.impact_query import KNOWN, forget_flight, new_memory
from comotion_server.kernels.jit import jit, lean_jit

NO_ROW = -1
LONG_AGO = -1e300  # [s] time of the last impact of a pair that had none


class Pairs(NamedTuple):
    """Room for c pairs of n bodies."""

    bodies: np.ndarray  # (c,2) int64 rows a < b; -1 where the row is free
    first: np.ndarray  # (n,) int64 first link of each body, -1: none
    next: np.ndarray  # (2c,) int64
    previous: np.ndarray  # (2c,) int64
    free: np.ndarray  # (c,) int64 rows that are free, in the first `free_count` places
    free_count: np.ndarray  # (1,) int64
    memory: np.ndarray  # (c,MEMORY) of `impact_query`
    witness: np.ndarray  # (c,2) int64
    tolerance: np.ndarray  # (c,) gap that counts as contact for the time of impact [m]
    hit_time: np.ndarray  # (c,) local time of the last impact [s]
    hit_speed: np.ndarray  # (c,) speed at which the pair parted then [m/s]; inf before the first


@jit
def new_pairs(body_count, capacity):
    """No pairs."""
    memory, witness = new_memory(capacity)
    return Pairs(
        np.full((capacity, 2), -1),
        np.full(body_count, -1),
        np.full(2 * capacity, -1),
        np.full(2 * capacity, -1),
        np.arange(capacity)[::-1].copy(),
        np.full(1, capacity),
        memory,
        witness,
        np.zeros(capacity),
        np.full(capacity, LONG_AGO),
        np.full(capacity, inf),
    )


@lean_jit
def partner(pairs, link):
    """The other body of the pair that a body's link belongs to."""
    return pairs.bodies[link >> 1, 1 - (link & 1)]


@lean_jit
def row_of(pairs, i, j):
    """The row of the pair of bodies i and j, or NO_ROW."""
    link = pairs.first[i]
    while link >= 0:
        if partner(pairs, link) == j:
            return link >> 1
        link = pairs.next[link]
    return NO_ROW


@lean_jit
def join(pairs, i, j, time, tolerance):
    """A row for bodies i and j, which are apart at `time` [s]; NO_ROW where there is no room left."""
    if pairs.free_count[0] == 0:
        return NO_ROW
    pairs.free_count[0] -= 1
    k = pairs.free[pairs.free_count[0]]
    pairs.bodies[k, 0], pairs.bodies[k, 1] = min(i, j), max(i, j)
    for link in (2 * k, 2 * k + 1):
        body = pairs.bodies[k, link & 1]
        after = pairs.first[body]
        pairs.next[link], pairs.previous[link] = after, -1
        pairs.first[body] = link
        if after >= 0:
            pairs.previous[after] = link
    forget_flight(pairs.memory[k], time)
    pairs.memory[k, KNOWN] = 0.0
    pairs.witness[k, :] = -1
    pairs.tolerance[k] = tolerance
    pairs.hit_time[k], pairs.hit_speed[k] = LONG_AGO, inf
    return k


@lean_jit
def part(pairs, k):
    """Row k is free again."""
    for link in (2 * k, 2 * k + 1):
        after, before = pairs.next[link], pairs.previous[link]
        if before >= 0:
            pairs.next[before] = after
        else:
            pairs.first[pairs.bodies[k, link & 1]] = after
        if after >= 0:
            pairs.previous[after] = before
    pairs.bodies[k, :] = -1
    pairs.free[pairs.free_count[0]] = k
    pairs.free_count[0] += 1
