"""Random tumbling bodies against dense sampling: never missed, never late, the gap and the contact time right.

`benchmarks/contact_times.py --cases 10000` asks many more.
"""

import numpy as np
import pytest
from contact_cases import FAMILIES, faults

from comotion_server.geometry.contact_time import default_tolerance, time_of_impact

CASES = {"convex": 150, "ell": 150, "linked": 100, "bullet": 20, "fast spin": 60}


@pytest.mark.parametrize("family", FAMILIES)
def test_agrees_with_dense_sampling(family):
    rng = np.random.default_rng(17)
    wrong, contacts, steep = [], 0, 0
    for k in range(CASES[family]):
        case = FAMILIES[family](rng)
        answer = time_of_impact(*case.query)
        found, plain = faults(case, answer, default_tolerance(*case.query))
        wrong += [(k, fault) for fault in found]
        contacts += answer.time is not None
        steep += plain
    assert wrong == []
    assert contacts > 0.15 * CASES[family]
    assert steep > 0.6 * contacts
