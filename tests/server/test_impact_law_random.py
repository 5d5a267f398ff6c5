"""Random clusters: books, numbering, repeats; and the projection against non-negative least squares."""

import numpy as np
import pytest
from clusters_by_hand import answer
from random_clusters import KINDS, Audit, audit, random_clump
from scipy.optimize import nnls

from comotion_server.kernels.dual_active_set import BLOCKED, SOLVED, project
from comotion_server.kernels.impact_cluster import JAMMED, SEQUENTIAL, TOGETHER

CLUSTERS = 60  # of each kind here; benchmarks/impact_clusters.py runs 10 000
SECOND_METHOD = 1e-9  # what least squares keeps: it works with the squares of the condition


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", [TOGETHER, SEQUENTIAL])
def test_books_numbering_and_repeats(rng, kind, law):
    worst = Audit()
    for _ in range(CLUSTERS):
        worst.add(audit(random_clump(rng, kind), rng, law))
    assert worst.growth <= 1e-14
    assert worst.book <= 1e-12
    assert worst.momentum <= 1e-12  # of a body, against its impulses: hundreds of reflections add their rounding
    assert worst.closing <= 1e-8  # of the fastest approach: what the law calls none is 1e-9
    assert worst.repeats
    assert worst.same_status
    if law == TOGETHER:
        assert worst.numbering <= 1e-12


def by_least_squares(A, b, x):
    """The nearest point by Lawson and Hanson's least distance programming; None: no point satisfies the rows."""
    E = np.vstack([A.T, b - A @ x])
    f = np.append(np.zeros(A.shape[1]), 1.0)
    u, _ = nnls(E, f, maxiter=1000)
    r = E @ u - f
    return None if np.linalg.norm(r) < 1e-9 else x - r[:-1] / r[-1]


def solve(A, b, x, equal=None):
    y, force, certificate = np.empty_like(x), np.empty(len(b)), np.zeros(len(b), bool)
    equal = np.zeros(len(b), bool) if equal is None else equal
    return project(A, b, equal, 1e-6, x, y, force, certificate), y, force, certificate


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_projection_against_least_squares(rng, offset):
    blocked = 0
    for _ in range(150):
        m, n = rng.integers(1, 25), rng.integers(1, 13)
        A = rng.normal(size=(m, n)) * 10.0 ** rng.uniform(-1, 1, (m, 1))
        if m > 3:
            A[0], A[1] = A[2], -A[3]  # rows twice, and two that face each other
        b, x = offset * rng.normal(size=m), rng.normal(size=n)
        b = np.where(np.arange(m) < 4, np.minimum(b, 0.0), b)
        truth = by_least_squares(A, b, x)
        status, y, force, certificate = solve(A, b, x)
        if truth is None:
            blocked += 1
            assert status == BLOCKED
            weights, _ = nnls(np.vstack([A[certificate].T, b[certificate]]), np.append(np.zeros(n), 1.0))
            assert np.linalg.norm(A[certificate].T @ weights) <= 1e-9 * np.abs(weights).max() * np.abs(A).max()
            assert b[certificate] @ weights > 0.0
            continue
        assert status == SOLVED
        np.testing.assert_allclose(y, truth, rtol=0, atol=SECOND_METHOD * (1 + np.abs(truth).max()))
        np.testing.assert_allclose(A.T @ force, y - x, rtol=0, atol=1e-13 * (1 + np.abs(A).max() * force.sum()))
        assert force.min() >= 0.0
    assert offset == 0.0 or blocked > 10


def test_projection_with_equalities_against_the_pseudo_inverse(rng):
    for _ in range(50):
        m, n = int(rng.integers(1, 6)), 8
        A, x = rng.normal(size=(m, n)), rng.normal(size=n)
        A = np.vstack([A, A[0] + A[-1] if m > 1 else A[0]])  # one too many, and consistent
        b = A @ rng.normal(size=n)
        status, y, _, _ = solve(A, b, x, np.ones(len(A), bool))
        assert status == SOLVED
        np.testing.assert_allclose(y, x + np.linalg.pinv(A) @ (b - A @ x), rtol=0, atol=1e-11)


def test_blocked_clusters_change_nothing(rng):
    seen = 0
    for _ in range(200):
        clump = random_clump(rng, "given")
        outcome = answer(clump)
        if outcome.status == BLOCKED:
            seen += 1
            assert np.array_equal(outcome.v, np.array(clump.v))
            assert not outcome.impulse.any()
            assert outcome.report.certificate.any()
    assert seen > 0


def test_elastic_clusters_keep_their_energy(rng):
    for _ in range(100):
        outcome = answer(random_clump(rng, "elastic"))
        if outcome.status != JAMMED:
            assert abs(outcome.growth) <= 1e-13 * outcome.scale
