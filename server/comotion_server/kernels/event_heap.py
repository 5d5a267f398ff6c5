"""A binary heap of items that each have a time: the earliest is first, and any of them can be moved or taken out.

Every item knows its place, so a new time replaces the old one: nothing in the heap is ever out of date. Equal times are
put in order by the items' ranks, which are all different: the order never depends on how the heap was filled.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit, lean_jit

NOBODY = -1


class Heap(NamedTuple):
    """A heap of up to c items; place k has its children at 2 k + 1 and 2 k + 2."""

    time: np.ndarray  # (c,) [s]
    rank: np.ndarray  # (c,) int64
    item: np.ndarray  # (c,) int64
    place: np.ndarray  # (c,) int64 of each item, -1 where it is not in the heap
    size: np.ndarray  # (1,) int64


@jit
def new_heap(capacity):
    """An empty heap for the items 0 to capacity - 1."""
    return Heap(
        np.empty(capacity),
        np.empty(capacity, np.int64),
        np.empty(capacity, np.int64),
        np.full(capacity, -1),
        np.zeros(1, np.int64),
    )


@lean_jit
def _set(heap, k, time, rank, item):
    heap.time[k], heap.rank[k], heap.item[k] = time, rank, item
    heap.place[item] = k


@lean_jit
def _before(heap, k, time, rank):
    return heap.time[k] < time or (heap.time[k] == time and heap.rank[k] < rank)


@lean_jit
def _rise(heap, k, time, rank, item):
    """Put an item at place k or above."""
    while k > 0:
        parent = (k - 1) >> 1
        if _before(heap, parent, time, rank):
            break
        _set(heap, k, heap.time[parent], heap.rank[parent], heap.item[parent])
        k = parent
    _set(heap, k, time, rank, item)


@lean_jit
def _sink(heap, k, time, rank, item):
    """Put an item at place k or below."""
    size = heap.size[0]
    while 2 * k + 1 < size:
        child = 2 * k + 1
        if child + 1 < size and _before(heap, child + 1, heap.time[child], heap.rank[child]):
            child += 1
        if not _before(heap, child, time, rank):
            break
        _set(heap, k, heap.time[child], heap.rank[child], heap.item[child])
        k = child
    _set(heap, k, time, rank, item)


@lean_jit
def put(heap, item, time, rank):
    """Give an item a time [s], whether it is in the heap or not."""
    k = heap.place[item]
    if k < 0:
        k = heap.size[0]
        heap.size[0] += 1
    elif _before(heap, k, time, rank):
        _sink(heap, k, time, rank, item)
        return
    _rise(heap, k, time, rank, item)


@lean_jit
def take_out(heap, item):
    """Take an item out, if it is in."""
    k = heap.place[item]
    if k < 0:
        return
    heap.place[item] = -1
    heap.size[0] -= 1
    last = heap.size[0]
    if k == last:
        return
    time, rank, other = heap.time[last], heap.rank[last], heap.item[last]
    parent = (k - 1) >> 1
    if k > 0 and not _before(heap, parent, time, rank):
        _rise(heap, k, time, rank, other)
    else:
        _sink(heap, k, time, rank, other)


@lean_jit
def first(heap):
    """(time [s], item) of the first; (inf, NOBODY) of an empty heap."""
    return (heap.time[0], heap.item[0]) if heap.size[0] > 0 else (inf, NOBODY)


@lean_jit
def second_time(heap):
    """The time [s] of the one after the first; inf where there is none."""
    time = heap.time[1] if heap.size[0] > 1 else inf
    return min(time, heap.time[2]) if heap.size[0] > 2 else time
