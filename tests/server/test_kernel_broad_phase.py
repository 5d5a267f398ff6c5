"""The grid finds exactly the pairs of spheres that meet, in order, wherever and however large they are."""

import numpy as np
import pytest

from comotion_server.kernels.broad_phase import FEW, pairs_in_reach
from comotion_server.kernels.radix_sort import sort_by_key


def by_brute_force(x, size, reacts):
    distance = np.linalg.norm(x[:, None] - x[None], axis=2)
    meets = (distance <= size[:, None] + size[None]) & (reacts[:, None] | reacts[None])
    return np.argwhere(np.triu(meets, 1))


def found(x, radius, reach, reacts, room=None):
    pairs = np.empty((len(x) ** 2 if room is None else room, 2), np.int64)
    return pairs[: pairs_in_reach(x, radius, reach, reacts, pairs)]


@pytest.mark.parametrize("places", ["box", "line", "two heaps", "one place", "lattice"])
@pytest.mark.parametrize("sizes", ["alike", "two kinds", "all scales", "points"])
def test_equals_brute_force(places, sizes, rng):
    for _ in range(10):
        n = int(rng.integers(2, 150))
        x = {
            "box": lambda n=n: 5 * rng.random((n, 3)),
            "line": lambda n=n: np.outer(rng.random(n), [1e3, 0, 0]) + 1e7,
            "two heaps": lambda n=n: rng.normal(size=(n, 3)) + 1e6 * rng.integers(2, size=(n, 1)),
            "one place": lambda n=n: np.ones((n, 3)),
            "lattice": lambda n=n: rng.integers(6, size=(n, 3)).astype(float),
        }[places]()
        radius = {
            "alike": lambda n=n: 0.4 + 0.2 * rng.random(n),
            "two kinds": lambda n=n: np.where(rng.random(n) < 0.3, 1.9, 0.1),
            "all scales": lambda n=n: 10.0 ** rng.uniform(-6, 3, n),
            "points": lambda n=n: np.zeros(n),
        }[sizes]()
        reach, reacts = 0.1 * rng.random(n) * rng.integers(2), rng.random(n) < 0.7
        expected = by_brute_force(x, radius + reach, reacts)
        np.testing.assert_array_equal(found(x, radius, reach, reacts), expected)


def test_many_large_bodies_among_small_ones(rng):
    n = 20 * FEW
    x, radius = 4 * rng.random((n, 3)), np.where(np.arange(n) % 3, 0.05, 0.8)
    expected = by_brute_force(x, radius, np.ones(n, bool))
    np.testing.assert_array_equal(found(x, radius, np.zeros(n), np.ones(n, bool)), expected)


@pytest.mark.parametrize("room", [0, 1, 5])
def test_counts_all_where_there_is_no_room(rng, room):
    x, radius = rng.random((30, 3)), np.full(30, 0.2)
    pairs = np.empty((room, 2), np.int64)
    count = pairs_in_reach(x, radius, np.zeros(30), np.ones(30, bool), pairs)
    assert count == len(by_brute_force(x, radius, np.ones(30, bool))) > room


def test_no_bodies_make_no_pairs():
    assert len(found(np.empty((0, 3)), np.empty(0), np.empty(0), np.empty(0, bool))) == 0


@pytest.mark.parametrize("largest", [1, 511, 512, 10**6, 2**61])
def test_radix_sort_is_stable(rng, largest):
    keys, values = rng.integers(0, min(largest, 50) + 1, 300) * (largest // min(largest, 50)), np.arange(300)
    expected = np.argsort(keys, kind="stable")
    sorted_keys = keys[expected]
    sort_by_key(keys, values, largest)
    np.testing.assert_array_equal(values, expected)
    np.testing.assert_array_equal(keys, sorted_keys)
