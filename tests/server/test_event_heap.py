"""The heap against a sorted list: items in any order of coming, moving and going; equal times by rank."""

from math import inf

import numpy as np

from comotion_server.kernels.event_heap import first, new_heap, put, second_time, take_out


def order_of(truth):
    return sorted(truth, key=truth.get)


def test_first_and_second_are_those_of_a_sorted_list(rng):
    heap, truth = new_heap(50), {}
    ranks = rng.permutation(50)
    for _ in range(5000):
        item = int(rng.integers(50))
        if rng.random() < 0.3:
            take_out(heap, item)
            truth.pop(item, None)
        else:
            time = float(rng.integers(8))  # many are equal
            put(heap, item, time, ranks[item])
            truth[item] = (time, ranks[item])
        ordered = order_of(truth)
        assert first(heap) == ((truth[ordered[0]][0], ordered[0]) if ordered else (inf, -1))
        assert second_time(heap) == (truth[ordered[1]][0] if len(ordered) > 1 else inf)
        assert heap.size[0] == len(truth)


def test_items_leave_in_the_order_of_time_and_rank(rng):
    heap = new_heap(1000)
    times = np.round(rng.random(1000), 2)
    for item in rng.permutation(1000):
        put(heap, item, times[item], item)
    left = []
    while heap.size[0] > 0:
        _, item = first(heap)
        left.append(item)
        take_out(heap, item)
    assert left == sorted(range(1000), key=lambda item: (times[item], item))
