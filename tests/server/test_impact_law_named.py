"""Impacts of clusters with known answers (VALIDATION B), given straight to the law."""

from math import atan, cos, floor, pi, sin, sqrt

import numpy as np
import pytest
from clusters_by_hand import Clump, answer, line

from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.impact_cluster import BLOCKED, CAPPED, JAMMED, LOST, SEQUENTIAL, SOLVED, TOGETHER, WORK

ROUNDING = 5e-15  # of speeds about 1, over a handful of reflections


def closes_books(outcome):
    lost, work = outcome.report.book[LOST], outcome.report.book[WORK]
    return abs(outcome.growth - work + lost) <= 1e-14 * (outcome.scale + abs(work))


@pytest.mark.parametrize("law", [TOGETHER, SEQUENTIAL])
@pytest.mark.parametrize(
    ("before", "after"),
    [((1, 0, 0, 0, 0), (0, 0, 0, 0, 1)), ((1, 1, 0, 0, 0), (0, 0, 0, 1, 1)), ((1, 0, -1), (-1, 0, 1))],
)
def test_elastic_cradle(before, after, law):
    outcome = answer(line(before, 1.0), law)
    assert outcome.status == SOLVED
    np.testing.assert_allclose(outcome.v[:, 0], after, rtol=0, atol=ROUNDING)
    assert closes_books(outcome)


def impacts_in_turn(speeds, e):
    """The cradle with gaps that open and close one after another: left to right, again and again."""
    v = np.array(speeds, float)
    while (v[:-1] > v[1:]).any():
        for i in range(len(v) - 1):
            if v[i] > v[i + 1]:
                mean, half = (v[i] + v[i + 1]) / 2, e * (v[i] - v[i + 1]) / 2
                v[i], v[i + 1] = mean - half, mean + half
    return v


def test_cradle_with_losses_is_the_limit_of_separate_impacts():
    outcome = answer(line((1, 0, 0, 0, 0), 0.5))
    np.testing.assert_allclose(outcome.v[:, 0], impacts_in_turn((1, 0, 0, 0, 0), 0.5), rtol=0, atol=ROUNDING)
    assert closes_books(outcome)


def test_plastic_cradle_shares_the_momentum():
    np.testing.assert_allclose(answer(line((1, 0, 0, 0, 0), 0.0)).v[:, 0], 0.2, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("e", [0.02, 0.07])
def test_three_balls_collapse_into_one_below_7_minus_4_root_3(e):
    outcome = answer(line((1, 0, 0), e))
    assert outcome.status == SOLVED
    np.testing.assert_allclose(outcome.v[:, 0], 1 / 3, rtol=0, atol=ROUNDING)
    assert closes_books(outcome)


def ring(e, count=23, *, wall=False):
    clump = Clump()
    angles = 2 * pi * np.arange(count) / count
    out = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    for i in range(count):
        clump.ball(out[i] if wall else -out[i])
    for i in range(count):
        j = (i + 1) % count
        a, b = min(i, j), max(i, j)
        clump.touch(a, b, out[b] - out[a], e)
    if wall:
        pipe = clump.given()
        for i in range(count):
            clump.touch(i, pipe, out[i], e)
    return clump, out


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_ring_breathes_with_all_its_symmetry(e):
    clump, out = ring(e)
    outcome = answer(clump)
    np.testing.assert_allclose(outcome.v, e * out, rtol=0, atol=2e-14)  # a ring of 23: rounding goes round
    assert outcome.report.reflections[0] <= 1
    assert closes_books(outcome)


def test_ring_jammed_in_its_pipe_stops_and_says_so():
    """Touching neighbours and wall it carries a stress of its own: rest is the one velocity that is possible."""
    outcome = answer(ring(1.0, wall=True)[0])
    assert outcome.status == JAMMED
    assert np.abs(outcome.v).max() <= 1e-13
    assert closes_books(outcome)


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("extra", [0, 100])
def test_flat_cube_on_a_plane(rng, e, extra):
    clump = Clump()
    floor_, cube = clump.given(), clump.body(1.0, (1 / 6,) * 3, v=(0, 0, -2))
    corners = [(x, y, -0.5) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    for p in [*corners, *np.column_stack([rng.uniform(-0.5, 0.5, (extra, 2)), np.full(extra, -0.5)])]:
        clump.touch(floor_, cube, (0, 0, 1), e, p, p)
    outcome = answer(clump)
    np.testing.assert_allclose(outcome.v[cube], (0, 0, 2 * e), rtol=0, atol=ROUNDING)
    assert np.abs(outcome.w[cube]).max() <= ROUNDING
    if not extra:
        assert np.ptp(outcome.impulse[:, 2]) <= ROUNDING  # equal corners bear equal shares
    np.testing.assert_allclose(outcome.impulse.sum(axis=0), (0, 0, 2 * (1 + e)), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_bar_on_a_ledge_turns(e):
    """A thin bar of length 1 over a ledge under [1/4, 1/2]: one impulse (1 + e) m v / (1 + 12/16), at the inner end."""
    clump = Clump()
    ledge, bar = clump.given(), clump.body(1.0, (1e-3, 1 / 12, 1 / 12), v=(0, 0, -1))
    for x in (0.25, 0.5):
        clump.touch(ledge, bar, (0, 0, 1), e, (x, 0, 0), (x, 0, 0))
    outcome, j = answer(clump), (1 + e) * 4 / 7
    np.testing.assert_allclose(outcome.v[bar], (0, 0, j - 1), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(outcome.w[bar], (0, -3 * j, 0), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("theta", [0.0, 0.3, 1.2])
@pytest.mark.parametrize("e", [1.0, 0.4])
def test_rod_falls_on_its_end(theta, e):
    """j = (1 + e) m v / (1 + 3 cos^2 theta)."""
    clump = Clump()
    floor_ = clump.given()
    axis = np.array([cos(theta), 0.0, sin(theta)])
    R = np.column_stack([axis, [0.0, 1.0, 0.0], np.cross(axis, [0.0, 1.0, 0.0])])
    rod = clump.body(2.0, (1e-9, 2 / 12, 2 / 12), v=(0, 0, -3), R=R)
    clump.touch(floor_, rod, (0, 0, 1), e, (0, 0, 0), -0.5 * axis)
    outcome, j = answer(clump), (1 + e) * 2 * 3 / (1 + 3 * cos(theta) ** 2)
    np.testing.assert_allclose(outcome.impulse[0], (0, 0, j), rtol=0, atol=1e-14 * j)
    assert closes_books(outcome)


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_three_ball_break(e):
    """v1 = (v0 / 2.5) (1 - 1.5 e); each outer ball cos 30 deg (e v0 + v1) along its normal."""
    clump = Clump()
    cue = clump.ball((1, 0, 0))
    normals = [np.array([cos(pi / 6), s * sin(pi / 6), 0.0]) for s in (1, -1)]
    for n in normals:
        clump.touch(cue, clump.ball((0, 0, 0)), n, e)
    outcome, v1 = answer(clump), (1 - 1.5 * e) / 2.5
    np.testing.assert_allclose(outcome.v[cue], (v1, 0, 0), rtol=0, atol=ROUNDING)
    for i, n in enumerate(normals):
        np.testing.assert_allclose(outcome.v[1 + i], cos(pi / 6) * (e + v1) * n, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("mass", [1e2, 1e4, 1e6, 1e8, 1e10])
def test_galperin_counts_pi(mass):
    """Each impact turns (sqrt(M) V, v) by 2 atan(1/sqrt(M)), the wall mirrors it: pi's digits are the count."""
    clump = Clump()
    wall, small, large = clump.given(), clump.ball((0, 0, 0)), clump.ball((-1, 0, 0), mass)
    clump.touch(wall, small, (1, 0, 0), 1.0)
    clump.touch(small, large, (1, 0, 0), 1.0)
    outcome, count = answer(clump), floor(pi * sqrt(mass))
    turned = 2 * ((count + 1) // 2) * atan(1 / sqrt(mass))
    v = -sqrt(mass) * sin(turned)
    assert outcome.status == SOLVED
    assert outcome.report.reflections[0] == count
    assert outcome.v[large, 0] == pytest.approx(-cos(turned), abs=5e-14)
    assert outcome.v[small, 0] == pytest.approx(abs(v) if count % 2 == 0 else v, abs=2e-16 * sqrt(mass * count) + 1e-14)


def test_elastic_ball_on_plastic_box_on_the_floor():
    clump = Clump()
    floor_, box, ball = clump.given(), clump.ball((0, 0, 0)), clump.ball((0, 0, -1))
    clump.touch(floor_, box, (0, 0, 1), 0.0)
    clump.touch(box, ball, (0, 0, 1), 1.0)
    outcome = answer(clump)
    assert np.abs(outcome.v).max() <= ROUNDING
    assert closes_books(outcome)


@pytest.mark.parametrize("e", [1.0, 0.3, 0.0])
@pytest.mark.parametrize("law", [TOGETHER, SEQUENTIAL])
def test_pinch_of_hull_and_wall_is_blocked(e, law):
    clump = Clump()
    hull, floe, wall, loose = clump.given((1, 0, 0)), clump.ball((0, 0, 0)), clump.given(), clump.ball((-1, 0, 0))
    clump.touch(hull, floe, (1, 0, 0), e)
    clump.touch(floe, wall, (1, 0, 0), e)
    clump.touch(wall, loose, (1, 0, 0), e)
    outcome = answer(clump, law)
    assert outcome.status == BLOCKED
    assert outcome.report.certificate.tolist() == [True, True, False]
    assert not outcome.v[floe].any()
    assert not outcome.impulse.any()


def test_given_bodies_that_close_are_blocked():
    clump = Clump()
    clump.touch(clump.given((1, 0, 0)), clump.given(), (1, 0, 0), 0.5)
    outcome = answer(clump)
    assert outcome.status == BLOCKED
    assert outcome.report.certificate[0]


@pytest.mark.parametrize("e", [1.0, 0.3])
def test_contacts_that_open_or_rest_change_no_bit(e):
    clump = line((-0.1, 0.2, 0.2), e)
    outcome = answer(clump)
    assert np.array_equal(outcome.v, np.array(clump.v))
    assert not outcome.impulse.any()


@pytest.mark.parametrize("e", [1.0, 0.6, 0.0])
def test_one_contact_alone_and_twice_agree(rng, e):
    """The closed form of a single contact against the solver, which sees the same contact as two rows."""
    for _ in range(20):
        alone, twice = Clump(), Clump()
        motion, arms, n = rng.normal(size=(2, 2, 3)), rng.normal(size=(2, 3)), rng.normal(size=3)
        for clump, times in ((alone, 1), (twice, 2)):
            for v, w in motion:
                clump.body(2.0, (0.5, 0.7, 0.9), v, w, spin=SPIN_FREE)
            for _ in range(times):
                clump.touch(0, 1, n, e, *arms)
        one, two = answer(alone), answer(twice)
        np.testing.assert_allclose(two.v, one.v, rtol=0, atol=1e-14)
        np.testing.assert_allclose(two.L, one.L, rtol=0, atol=1e-14)
        np.testing.assert_allclose(two.impulse.sum(axis=0), one.impulse[0], rtol=0, atol=2e-14)
        np.testing.assert_allclose(two.report.book, one.report.book, rtol=0, atol=2e-14)
        u = [np.dot(n, o[1] + np.cross(p[1], arms[1]) - o[0] - np.cross(p[0], arms[0])) for o, p in
             ((motion[:, 0], motion[:, 1]), (one.v, one.w))]  # fmt: skip
        if u[0] < 0:
            assert u[1] == pytest.approx(-e * u[0], abs=1e-14)


def test_more_reflections_than_allowed_are_taken_at_once():
    """Mass ratio 1e13 wants ten million reflections; all at once the heavy ball turns back with all its energy."""
    clump = Clump()
    wall, small, large = clump.given(), clump.ball((0, 0, 0)), clump.ball((-1, 0, 0), 1e13)
    clump.touch(wall, small, (1, 0, 0), 1.0)
    clump.touch(small, large, (1, 0, 0), 1.0)
    outcome = answer(clump)
    assert outcome.status == CAPPED
    np.testing.assert_allclose(outcome.v[[small, large], 0], (0, 1), rtol=0, atol=1e-9)
    assert closes_books(outcome)
