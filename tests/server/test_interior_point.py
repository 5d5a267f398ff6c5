"""The interior point method on the way to a projection of many rows: how near it comes, and where it gives up."""

import numpy as np
import pytest
from random_clusters import packing

from comotion_server.kernels.block_cholesky import new_factor, pattern_of
from comotion_server.kernels.interior_point import approach
from comotion_server.kernels.large_parts import project_large
from comotion_server.kernels.sparse_rows import part_of, unknowns_of

NEAR = 1e-5  # of the fastest: products of slack and multiplier end at 1e-13


def approached(link, rows, b, x, equal):
    size = np.sqrt((rows**2).sum(axis=(1, 2)))
    pattern, unknowns = pattern_of(link, len(x)), unknowns_of(rows)
    part = part_of(link, rows, size, b, equal, unknowns, pattern.order)
    start = np.ascontiguousarray(x[pattern.order][:, unknowns])
    end, l, scale = np.empty_like(start), np.zeros(len(b)), np.abs(start).max() + np.abs(part.bound).max()
    done = approach(part, pattern, new_factor(pattern, len(unknowns)), start, scale, end, l)
    y = x.copy()
    for place, body in enumerate(pattern.order):
        y[body, unknowns] = end[place]
    return done, y, l / size


@pytest.mark.parametrize(("ratio", "twice", "space"), [(1.0, True, False), (1e4, True, False), (1.0, False, True)])
def test_it_comes_near_the_exact_solution(rng, ratio, twice, space):
    """Also where half the rows depend on the others; bodies of three unknowns, and of six."""
    link, rows, x = packing(14, 14, rng, ratio, twice=twice)
    if space:
        x[:, 2:5], rows[:, :, 2:5] = rng.normal(size=(len(x), 3)), 0.2 * rows[:, :, :1]
    b, equal = np.zeros(len(link)), np.zeros(len(link), bool)
    equal[::7] = not twice
    y, force, certificate = np.empty_like(x), np.zeros(len(b)), np.zeros(len(b), bool)
    size = np.sqrt((rows**2).sum(axis=(1, 2)))
    project_large(link, rows, size, b, equal, x, y, force, certificate)
    done, near, multiplier = approached(link, rows, b, x, equal)
    assert done
    np.testing.assert_allclose(near, y, rtol=0, atol=NEAR * np.abs(x).max())
    assert multiplier[~equal].min() >= 0.0


def test_it_gives_up_where_nothing_satisfies_all_rows():
    """A column of balls between a wall and a hull that comes nearer."""
    k = 150
    link = np.array([(i - 1, i if i < k else -1) for i in range(k + 1)])
    rows = np.zeros((k + 1, 2, 6))
    rows[1:, 0, 0], rows[:-1, 1, 0] = -1.0, 1.0
    b = np.zeros(k + 1)
    b[-1] = 1.0
    done, _, _ = approached(link, rows, b, np.zeros((k, 6)), np.zeros(k + 1, bool))
    assert not done
