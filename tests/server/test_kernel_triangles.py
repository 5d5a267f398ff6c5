"""P5, P7: triangle distance and intersection against exact integer arithmetic."""

import numpy as np
import pytest
from exact_triangles import exact_distance
from triangle_families import FAMILIES, random, shared_vertex, turn

from comotion_server.kernels.orientation import orientation
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.kernels.triangle_intersection import triangles_intersect

CASES = 150  # per family
DISTANCE_ERROR = 4e-15  # of the size: 18 roundings of the coordinates
POINTS_ERROR = 1e-14  # of the largest coordinate: |p - q| is formed again from rounded points
IN_PLANE_ERROR = 1e-14  # of the size: how far a closest point may lie off its triangle


def corners(triangle):
    return [tuple(map(float, corner)) for corner in triangle]


def points(a, b):
    return triangle_points(*corners(a), *corners(b))


def size_of(a, b):
    return max(np.ptp(a, axis=0).max(), np.ptp(b, axis=0).max())


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_distance_is_exact_to_rounding_and_between_its_points(family, rng):
    for _ in range(CASES):
        a, b = family(rng)
        distance, p, q, direction = points(a, b)
        size, reach = size_of(a, b), max(np.abs(a).max(), np.abs(b).max())
        assert abs(exact_distance(a, b) - distance) <= DISTANCE_ERROR * size
        assert abs(np.linalg.norm(np.subtract(p, q)) - distance) <= POINTS_ERROR * reach
        assert exact_distance([p, p, p], a) <= IN_PLANE_ERROR * reach
        assert exact_distance([q, q, q], b) <= IN_PLANE_ERROR * reach
        assert np.linalg.norm(direction) == pytest.approx(float(distance > 0), abs=1e-15)
        assert triangles_intersect(*corners(a), *corners(b)) == (distance == 0.0)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_distance_does_not_depend_on_the_order(family, rng):
    for _ in range(CASES):
        a, b = family(rng)
        swapped = points(b[::-1], np.roll(a, 1, axis=0))
        assert abs(points(a, b)[0] - swapped[0]) <= 2 * DISTANCE_ERROR * size_of(a, b)


FLAT = [(0, 0, 0), (4, 0, 0), (0, 4, 0)]


@pytest.mark.parametrize(
    ("other", "meets"),
    [
        ([(1, 1, -1), (1, 1, 1), (5, 5, 1)], True),  # an edge through the inside
        ([(1, 1, 0), (2, 1, 0), (1, 2, 0)], True),  # coplanar, one inside the other
        ([(-1, 1, 0), (5, 1, 0), (2, 9, 0)], True),  # coplanar, edges cross
        ([(5, 5, 0), (6, 5, 0), (5, 6, 0)], False),  # coplanar, apart
        ([(4, 0, 0), (9, 0, 1), (9, 1, 1)], True),  # vertex on vertex
        ([(2, 0, 0), (2, -3, 1), (3, -3, 1)], True),  # vertex on edge
        ([(1, 1, 0), (1, 2, 5), (2, 1, 5)], True),  # vertex on face
        ([(0, 0, 0), (4, 0, 0), (0, 0, 7)], True),  # a shared edge
        ([(1, -1, -1), (1, -1, 1), (1, 1, 0)], True),  # edge of the first through the inside of the second
        ([(2, 2, -1), (2, 2, 1), (9, 9, 0)], True),  # edge through the edge
        ([(1, 1, 1e-12), (2, 1, 1e-12), (1, 2, 1e-12)], False),  # parallel, barely apart
        ([(2.000000001, 2, -1), (2.000000001, 2, 1), (9, 9, 0)], False),  # beside the edge, barely apart
        ([(1, 1, 0), (1, 1, 0), (1, 1, 0)], True),  # a point on the face
        ([(1, 1, -1), (1, 1, 1), (1, 1, 0)], True),  # a line through the face
        ([(7, 7, -1), (7, 7, 1), (7, 7, 0)], False),  # a line beside it
    ],
)
def test_intersection_with_touching_and_coplanar_cases(other, meets):
    assert triangles_intersect(*corners(FLAT), *corners(other)) == meets
    assert triangles_intersect(*corners(other), *corners(FLAT)) == meets


def test_two_points_of_one_place_meet():
    assert points(np.ones((3, 3)), np.ones((3, 3)))[0] == 0.0


def test_direction_separates_the_triangles_by_the_distance(rng):
    for _ in range(CASES):
        a, b = random(rng)
        distance, _, _, direction = points(a, b)
        if distance > 0:
            assert (b @ direction).min() - (a @ direction).max() >= distance - DISTANCE_ERROR * size_of(a, b)


def test_scaling_by_a_power_of_two_scales_the_bits(rng):
    for _ in range(CASES):
        a, b = random(rng)
        assert points(1024 * a, 1024 * b)[0] == 1024 * points(a, b)[0]


def test_side_of_a_plane_is_right_where_a_plain_determinant_is_rounding():
    corner = np.array([0.5, 0.5, 0.5])
    a, b, c = np.array([12.0, 12.0, 12.0]), np.array([24.0, 24.0, 24.0]), np.array([24.0, 23.0, 24.0])
    for step in range(-8, 9):
        point = np.add(corner, [step * 2.0**-52, 0.0, 0.0])
        exact = np.sign(step)  # a, b, c lie in the plane x = z
        assert orientation(*corners([a, b, c]), tuple(map(float, point))) in (exact, -exact)
        assert (orientation(*corners([a, b, c]), tuple(map(float, point))) == 0) == (step == 0)


def test_never_nan(rng):
    for _ in range(CASES):
        a, b = shared_vertex(rng)
        a = np.outer(rng.normal(size=3), a[0]) if rng.random() < 0.5 else a * [1, 1, 0]
        for scale in (1e-60, 1e-6, 1e60):
            result = points(scale * a @ turn(rng).T, scale * b)
            assert np.isfinite(np.hstack(result)).all()
