"""Vertex-face and edge-edge contacts, exact in rational numbers: none is missed, none is late (VALIDATION C)."""

from collections import Counter
from fractions import Fraction

import numpy as np
from exact_motion import queries

from comotion_server.kernels.linear_impact import linear_impacts
from comotion_server.kernels.pair_impact import HIT
from comotion_server.kernels.triangle_distance import triangle_points

COUNT = 3000
TOLERANCE = 2.0**-30


def test_no_contact_is_missed_or_late_or_without_reason(rng):
    a, b, va, vb, when, names = queries(rng, COUNT)
    status, time = np.empty(COUNT, np.int64), np.empty(COUNT)
    linear_impacts(a, b, va, vb, 1.0, TOLERANCE, status, time)
    missed = Counter(name for name, ended in zip(names, status, strict=True) if ended != HIT)
    late = Counter(name for name, t, truth in zip(names, time, when, strict=True) if Fraction(t) > truth)
    assert missed == {}
    assert late == {}
    for k in range(COUNT):
        corners = [tuple(map(tuple, (x[k] + time[k] * v[k]).tolist())) for x, v in ((a, va), (b, vb))]
        assert triangle_points(*corners[0], *corners[1])[0] <= TOLERANCE * (1 + 1e-6)
