"""Distances of curved shapes against arithmetic of 50 digits, in poses at random and where directions vanish."""

import itertools

import numpy as np
import pytest
from curved_truth import CAPSULE, CYLINDER, PIPE, PLANE, SPHERE, Posed, bounds, pipe_and_rims, pipe_and_round
from scipy.spatial.transform import Rotation

from comotion_server.kernels.curved_gap import curved_gap, is_known

ROUNDING = 1e-14  # of the size of what is measured: what the distances are to be right to
Z, NO_TURN = (0.0, 0.0, 1.0), np.eye(3)
ON_X = Rotation.from_euler("y", 90, degrees=True).as_matrix()
SIZES = {
    PLANE: (0.0, 0.0, 0.0, 0.0),
    SPHERE: (0.5, 0.0, 0.0, 0.0),
    CAPSULE: (0.3, 0.7, 0.0, 0.0),
    CYLINDER: (0.4, 0.6, 0.0, 0.0),
}
CONVEX = list(itertools.combinations_with_replacement(SIZES, 2))[1:]
OPEN, CLOSED = (0.8, 1.0, 1.2, 0.0), (0.8, 1.0, 1.2, 1.0)


def posed(kind, x=(0.0, 0.0, 0.0), R=NO_TURN, size=None, axis=Z):
    return Posed(kind, size or SIZES[kind], axis, np.array(x, dtype=float), R)


def at_random(rng, kind, spread, size=None):
    return posed(kind, spread * rng.normal(size=3), Rotation.random(random_state=rng).as_matrix(), size)


def ask(a, b):
    distance, p, q, n = curved_gap(*a.arguments, *b.arguments)
    return distance, np.array(p), np.array(q), np.array(n)


def extent(a, b):
    return np.linalg.norm(b.x - a.x) + sum(a.size) + sum(b.size)


def assert_proven(a, b):
    """The distance is shown from both sides."""
    distance, p, q, n = ask(a, b)
    lower, upper = bounds(a, b, p, q, n)
    rounding = ROUNDING * extent(a, b)
    assert lower >= distance - rounding, (a, b, distance, lower)
    assert abs(np.linalg.norm(n) - 1.0) < 1e-15 * 4
    if distance > 0.0:
        assert abs(upper - distance) <= rounding, (a, b, distance, upper)
    return distance


@pytest.mark.parametrize(("kind_a", "kind_b"), CONVEX)
def test_poses_at_random(kind_a, kind_b):
    rng, apart = np.random.default_rng(kind_a * 10 + kind_b), 0
    while apart < 25:
        a, b = at_random(rng, kind_a, 0.1), at_random(rng, kind_b, 2.0)
        if ask(a, b)[0] > 0.0:
            assert_proven(a, b)
            apart += 1


@pytest.mark.parametrize(("kind_a", "kind_b"), CONVEX)
@pytest.mark.parametrize("gap", [1e-6, 1e-9, 1e-12])
def test_bodies_that_all_but_touch(kind_a, kind_b, gap):
    rng, apart = np.random.default_rng(kind_a * 10 + kind_b), 0
    while apart < 6:
        a, b = at_random(rng, kind_a, 0.1), at_random(rng, kind_b, 2.0)
        distance, _, _, n = ask(a, b)
        if distance <= 0.0:
            continue
        near = Posed(b.kind, b.size, b.axis, b.x - (distance - gap) * n, b.R)
        assert_proven(a, near)
        assert ask(a, near)[0] == pytest.approx(gap, abs=ROUNDING * extent(a, b))
        apart += 1


TILT = Rotation.from_euler("y", 30, degrees=True).as_matrix()
SPECIAL = [
    ("parallel, beside each other", (1.5, 0.0, 0.3), NO_TURN),
    ("parallel, beyond each other", (1.5, 0.0, 3.0), NO_TURN),
    ("one axis", (0.0, 0.0, 3.0), NO_TURN),
    ("opposite", (0.0, 0.0, 3.0), np.diag([1.0, -1.0, -1.0])),
    ("crossing at a right angle", (0.0, 1.5, 0.0), ON_X),
    ("upright on it", (0.0, 0.0, 2.0), ON_X),
    ("in one plane", (1.6, 0.0, 1.1), TILT),
    ("edge above the middle", (0.0, 0.0, 2.2), TILT),
    ("all but parallel", (1.5, 0.0, 0.3), Rotation.from_rotvec([1e-9, 2e-10, 0.0]).as_matrix()),
    ("far", (3e3, 4e3, 0.5), TILT),
]


@pytest.mark.parametrize(("x", "R"), [case[1:] for case in SPECIAL], ids=[case[0] for case in SPECIAL])
@pytest.mark.parametrize(("kind_a", "kind_b"), CONVEX)
def test_poses_in_which_directions_vanish(kind_a, kind_b, x, R):
    a, b = posed(kind_a), posed(kind_b, x, R)
    if ask(a, b)[0] > 0.0 or CYLINDER not in (kind_a, kind_b):
        assert_proven(a, b)
    assert ask(b, a)[0] == ask(a, b)[0]


def test_two_planes_and_a_cylinder_with_an_open_pipe_have_no_answer():
    shapes = [*SIZES.items(), (PIPE, OPEN), (PIPE, CLOSED)]
    unknown = {
        (a, b)
        for (a, size_a), (b, size_b) in itertools.product(shapes, repeat=2)
        if not is_known(a, np.array(size_a), b, np.array(size_b))
    }
    assert unknown == {(PLANE, PLANE), (CYLINDER, PIPE), (PIPE, CYLINDER)}
    assert is_known(CYLINDER, np.array(SIZES[CYLINDER]), PIPE, np.array(CLOSED))


def test_known_distances():
    cylinder, sphere, capsule = posed(CYLINDER), posed(SPHERE), posed(CAPSULE)
    assert ask(cylinder, posed(CYLINDER, (2.0, 0.0, 0.0)))[0] == pytest.approx(1.2, abs=1e-15)
    assert ask(cylinder, posed(CYLINDER, (0.0, 0.0, 1.5)))[0] == pytest.approx(0.3, abs=1e-15)
    assert ask(cylinder, posed(CYLINDER, (0.0, 1.0, 0.0), ON_X))[0] == pytest.approx(0.2, abs=1e-15)
    assert ask(cylinder, posed(CYLINDER, (1.1, 0.0, 1.6)))[0] == pytest.approx(0.5, abs=1e-15)
    assert ask(sphere, posed(SPHERE, (0.6, 0.0, 0.0)))[0] == pytest.approx(-0.4, abs=1e-15)
    assert ask(capsule, posed(CAPSULE, (0.0, 0.1, 0.0), ON_X))[0] == pytest.approx(-0.5, abs=1e-15)
    assert ask(posed(PLANE), posed(CYLINDER, (0.0, 0.0, 0.5)))[0] == pytest.approx(-0.1, abs=1e-15)


@pytest.mark.parametrize(("kind_a", "kind_b"), CONVEX[3:])
def test_one_inside_the_other_is_no_number_above_zero(kind_a, kind_b):
    for x, R in (((0.0, 0.0, 0.0), NO_TURN), ((0.0, 0.0, 0.0), ON_X), ((0.0, 0.0, 0.1), TILT)):
        distance, p, q, n = ask(posed(kind_a), posed(kind_b, x, R))
        assert distance < 0.0
        assert np.isfinite([*p, *q]).all()
        assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-15)


def test_cylinders_that_overlap_come_apart_along_the_normal():
    rng, overlaps = np.random.default_rng(5), 0
    while overlaps < 50:
        a, b = at_random(rng, CYLINDER, 0.1), at_random(rng, CYLINDER, 0.4)
        distance, _, _, n = ask(a, b)
        if distance > 0.0:
            continue
        overlaps += 1
        assert ask(a, Posed(b.kind, b.size, b.axis, b.x - (distance - 1e-12) * n, b.R))[0] > 0.0


@pytest.mark.parametrize("kind", [SPHERE, CAPSULE])
@pytest.mark.parametrize("size", [OPEN, CLOSED], ids=["open", "closed"])
def test_pipes_at_random(kind, size):
    rng, apart = np.random.default_rng(kind), 0
    thin = (0.1, 0.5, 0.0, 0.0) if kind == CAPSULE else (0.1, 0.0, 0.0, 0.0)
    while apart < 12:
        pipe, other = at_random(rng, PIPE, 0.0, size), at_random(rng, kind, 0.7, thin)
        distance, p, q, n = ask(pipe, other)
        if distance <= 0.0:
            continue
        assert distance == pytest.approx(pipe_and_round(pipe, other), abs=ROUNDING * extent(pipe, other))
        assert np.allclose(q - p, distance * n, atol=ROUNDING * extent(pipe, other))
        assert ask(other, pipe)[0] == distance
        apart += 1


PLACES = [
    ("in the middle", (0.0, 0.0, 0.0), NO_TURN),
    ("along the wall", (0.5, 0.0, 0.1), NO_TURN),
    ("out of the end", (0.1, 0.2, 1.3), TILT),
    ("in the mouth, across", (0.0, 0.0, 1.5), ON_X),
    ("outside, along", (1.5, 0.0, 0.0), NO_TURN),
    ("outside, across", (1.5, 0.0, 0.0), Rotation.from_euler("x", 90, degrees=True).as_matrix()),
]


@pytest.mark.parametrize(("x", "R"), [place[1:] for place in PLACES], ids=[place[0] for place in PLACES])
@pytest.mark.parametrize("kind", [SPHERE, CAPSULE])
def test_places_about_an_open_pipe(kind, x, R):
    thin = (0.1, 0.4, 0.0, 0.0) if kind == CAPSULE else (0.1, 0.0, 0.0, 0.0)
    pipe, other = posed(PIPE, size=OPEN), posed(kind, x, R, thin)
    distance, _, _, n = ask(pipe, other)
    assert distance == pytest.approx(pipe_and_round(pipe, other), abs=ROUNDING * extent(pipe, other))
    assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-15)


def test_a_capsule_through_the_wall_overlaps():
    pipe = posed(PIPE, size=OPEN)
    assert ask(pipe, posed(CAPSULE, (0.9, 0.0, 0.0), ON_X))[0] < 0.0
    assert ask(pipe, posed(CAPSULE, (0.0, 0.0, 0.0), ON_X, (0.1, 3.0, 0.0, 0.0)))[0] < 0.0


def test_cylinders_in_a_closed_pipe():
    rng = np.random.default_rng(3)
    for _ in range(3):
        pipe = at_random(rng, PIPE, 1.0, CLOSED)
        inside = Posed(CYLINDER, (0.2, 0.3, 0, 0), Z, pipe.x + 0.15 * rng.normal(size=3), NO_TURN)
        distance = ask(pipe, inside)[0]
        assert distance == pytest.approx(pipe_and_rims(pipe, inside), abs=ROUNDING * extent(pipe, inside))
    for R in (NO_TURN, ON_X, TILT):
        for x in ((0.0, 0.0, 0.0), (0.1, 0.0, 0.2)):
            pipe, inside = posed(PIPE, size=CLOSED), posed(CYLINDER, x, R, (0.2, 0.3, 0.0, 0.0))
            assert ask(pipe, inside)[0] == pytest.approx(pipe_and_rims(pipe, inside), abs=ROUNDING * 3)


def test_scaled_by_a_power_of_two_everything_scales_bit_by_bit():
    rng = np.random.default_rng(8)
    shapes = [*SIZES.items(), (PIPE, OPEN), (PIPE, CLOSED)]
    for (kind_a, size_a), (kind_b, size_b) in itertools.product(shapes, shapes[1:]):
        for _ in range(10):
            a, b = at_random(rng, kind_a, 1.0, size_a), at_random(rng, kind_b, 1.0, size_b)
            s = 2.0 ** int(rng.integers(-40, 40))
            large = [Posed(c.kind, (*(s * v for v in c.size[:3]), c.size[3]), c.axis, s * c.x, c.R) for c in (a, b)]
            one, two = ask(a, b), ask(*large)
            assert [s * one[0], *(s * one[1]), *(s * one[2]), *one[3]] == [two[0], *two[1], *two[2], *two[3]]


def test_swapped_and_mirrored_the_distance_is_the_same_number():
    rng = np.random.default_rng(9)
    shapes = [*SIZES.items(), (PIPE, OPEN), (PIPE, CLOSED)]
    mirror = np.array([-1.0, 1.0, 1.0])
    for (kind_a, size_a), (kind_b, size_b) in itertools.product(shapes, shapes[1:]):
        for _ in range(10):
            a, b = at_random(rng, kind_a, 1.0, size_a), at_random(rng, kind_b, 1.0, size_b)
            seen = [Posed(c.kind, c.size, c.axis, mirror * c.x, np.diag(mirror) @ c.R) for c in (a, b)]
            assert ask(b, a)[0] == ask(a, b)[0] == ask(*seen)[0]


RIMS = 1e-12  # of the size: what the normal of two rims with tangents all but parallel can show, the gap tiny as well


def test_slender_flat_large_and_small_bodies_all_but_aligned():
    """Lengths over three decades, angles and gaps down to rounding: where formulas meet their ends."""
    rng, done = np.random.default_rng(5), 0
    straight = [np.array(d) for d in ([0.0, 0, 1], [1.0, 0, 0], [1.0, 1, 0], [1.0, 0, 1])]
    turns = [
        Rotation.identity(),
        Rotation.from_euler("x", 90, degrees=True),
        Rotation.from_euler("y", 180, degrees=True),
    ]
    while done < 400:
        kinds = rng.choice([SPHERE, CAPSULE, CYLINDER], 2).tolist()
        sizes = [(*(10.0 ** rng.uniform(-2, 1, 2)), 0.0, 0.0) for _ in kinds]
        common, tilt = (
            Rotation.random(random_state=rng),
            Rotation.from_rotvec(10.0 ** -rng.uniform(0, 17) * rng.normal(size=3)),
        )
        way = straight[rng.integers(4)] + 10.0 ** -rng.uniform(0, 17) * rng.normal(size=3)
        a = Posed(kinds[0], sizes[0], Z, rng.normal(size=3), common.as_matrix())
        x = a.x + common.apply(way) / np.linalg.norm(way) * rng.uniform(0.5, 2.0) * (sum(sizes[0]) + sum(sizes[1]))
        b = Posed(kinds[1], sizes[1], Z, x, (common * turns[rng.integers(3)] * tilt).as_matrix())
        distance, _, _, n = ask(a, b)
        if rng.random() < 0.7 and distance > 0.0:
            b = Posed(b.kind, b.size, b.axis, b.x - (distance - 10.0 ** -rng.uniform(1, 16)) * n, b.R)
        distance, p, q, n = ask(a, b)
        if distance <= 0.0:
            continue
        lower, upper = bounds(a, b, p, q, n)
        assert abs(upper - distance) <= ROUNDING * extent(a, b), (a, b)
        assert lower >= distance - (RIMS if kinds == [CYLINDER, CYLINDER] else ROUNDING) * extent(a, b), (a, b)
        done += 1
