"""Clusters of many contacts: the sparse method against the dense one and against the conditions of optimality."""

import numpy as np
import pytest
from clusters_by_hand import Clump, answer
from random_clusters import jam, opening_speeds, packing

from comotion_server.kernels.dual_active_set import BLOCKED, SOLVED, project
from comotion_server.kernels.impact_cluster import LOST, WORK, settle_velocities
from comotion_server.kernels.large_parts import project_large

SAME = 1e-13  # of the fastest: both methods refine their solution


def solve_sparse(link, rows, b, x, equal=None):
    size = np.sqrt((rows**2).sum(axis=(1, 2)))
    y, force, certificate = np.empty_like(x), np.zeros(len(b)), np.zeros(len(b), bool)
    equal = np.zeros(len(b), bool) if equal is None else equal
    status = project_large(link, rows, size, b, equal, x, y, force, certificate)
    return status, y, force, certificate


def dense_rows(link, rows, k):
    A = np.zeros((len(link), 6 * k))
    for i, pair in enumerate(link):
        for side, j in enumerate(pair):
            if j >= 0:
                A[i, 6 * j : 6 * j + 6] += rows[i, side]
    return A


@pytest.mark.parametrize(("ratio", "twice"), [(1.0, False), (1e3, False), (1e6, False), (1.0, True), (1e3, True)])
def test_sparse_and_dense_agree(rng, ratio, twice):
    link, rows, x = packing(8, 8, rng, ratio, twice=twice)
    m, k = len(link), len(x)
    A, b = dense_rows(link, rows, k), np.zeros(m)
    status, y, _, _ = solve_sparse(link, rows, b, x)
    truth, force = np.empty(6 * k), np.empty(m)
    assert project(A, b, np.zeros(m, bool), 0.0, x.ravel(), truth, force, np.zeros(m, bool)) == SOLVED
    assert status == SOLVED
    np.testing.assert_allclose(y.ravel(), truth, rtol=0, atol=SAME * np.abs(x).max())


def test_conditions_of_optimality_with_given_motion(rng):
    link, rows, x = packing(18, 18, rng, 10.0)
    b = -0.3 * np.abs(rng.normal(size=len(link)))
    status, y, force, _ = solve_sparse(link, rows, b, x)
    A = dense_rows(link, rows, len(x))
    slack = A @ y.ravel() - b
    assert status == SOLVED
    assert slack.min() >= -SAME * np.abs(x).max()
    assert force.min() >= 0.0
    assert np.abs(A.T @ force - (y - x).ravel()).max() <= 1e-12 * np.abs(x).max()
    assert np.abs(force * slack).max() <= 1e-12 * np.abs(x).max() * force.max()


def test_equalities_hold(rng):
    link, rows, x = packing(6, 6, rng, 1.0)
    equal = np.arange(len(link)) % 5 == 0
    status, y, _, _ = solve_sparse(link, rows, np.zeros(len(link)), x, equal)
    slack = dense_rows(link, rows, len(x)) @ y.ravel()
    assert status == SOLVED
    assert np.abs(slack[equal]).max() <= 1e-13 * np.abs(x).max()
    assert slack.min() >= -1e-13 * np.abs(x).max()


def column(count, speed):
    """Balls in a row between a wall and a hull that presses."""
    clump = Clump()
    wall = clump.given()
    balls = [clump.ball((0, 0, 0)) for _ in range(count)]
    hull = clump.given((-speed, 0, 0))
    for a, b in zip([wall, *balls], [*balls, hull], strict=True):
        clump.touch(a, b, (1, 0, 0), 0.5)
    return clump


def test_long_column_between_hull_and_wall_is_blocked():
    outcome = answer(column(200, 1.0))
    assert outcome.status == BLOCKED
    assert outcome.report.certificate.all()
    assert not outcome.v[1:-1].any()


def test_an_impossible_column_leaves_no_impulses():
    """Whatever was in the memory that the solver takes: rest goes on from these numbers."""
    clump = column(200, 1.0)
    bodies, contacts, v, R, L, w = clump.arrays()
    c = len(clump.rows)
    litter = [np.full(c, 1e300) for _ in range(100)]
    del litter
    impulse, equal, certificate = np.ones(c), np.zeros(c, bool), np.zeros(c, bool)
    status = settle_velocities(bodies, contacts, c, equal, np.zeros(c), v, R, L, w, impulse, certificate)
    assert status == BLOCKED
    np.testing.assert_array_equal(impulse, np.zeros(c))


def test_boxes_in_a_row_closed_at_corners_that_differ_by_noise_keep_their_slip(rng):
    """Four corners a face, two of them closed exactly; that normals differ by 1e-9 is no third condition."""
    clump, equal = Clump(), []
    before = clump.given()
    for _ in range(40):
        box = clump.body(1.0, (1 / 6,) * 3, (*rng.normal(size=2), 0), free=(1, 1, 0), spin=2)
        for y in (-0.5, 0.5):
            for exactly in (True, False):
                normal = (1.0, 1e-9 * rng.normal(), 0.0)
                clump.touch(before, box, normal, 0.0, (0.5 * clump.reacts[before], y, 0), (-0.5, y, 0))
                equal.append(exactly)
        before = box
    bodies, contacts, v, R, L, w = clump.arrays()
    c = len(equal)
    impulse, certificate, slip = np.zeros(c), np.zeros(c, bool), v[:, 1].copy()
    status = settle_velocities(bodies, contacts, c, np.array(equal), np.zeros(c), v, R, L, w, impulse, certificate)
    assert status == SOLVED
    np.testing.assert_allclose(v[:, 0], 0.0, rtol=0, atol=1e-7)
    np.testing.assert_allclose(v[:, 1], slip, rtol=0, atol=1e-7)
    assert np.abs(impulse).max() <= 40 * 4.0


def test_jam_of_discs_closes_its_books(rng):
    """A packing thrown into a corner, e = .5, through the whole law."""
    clump = jam(12, 12, 0.5, rng)
    outcome = answer(clump)
    lost, work = outcome.report.book[LOST], outcome.report.book[WORK]
    assert outcome.status == SOLVED
    assert abs(outcome.growth - work + lost) <= 1e-12 * outcome.scale
    fastest = outcome.report.approach.max()
    assert opening_speeds(clump, outcome.v, outcome.w).min() >= -1e-9 * fastest
