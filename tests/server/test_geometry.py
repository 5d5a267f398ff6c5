"""The public interface of the geometry: answers against closed forms, refusals by name."""

import gc

import numpy as np
import pytest
from meshes_by_hand import l_shape, needles, torus
from triangle_families import turn

from comotion_server.geometry import MeshError, PoseError, TriangleMesh, distance, intersects, penetration
from comotion_server.geometry.prepared_pair import _alone, _together
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.meshes import box

ROUNDING = 1e-14
HERE = (np.eye(3), np.zeros(3))
CUBE, SMALL = box([1.0, 1.0, 1.0]), box([0.5, 0.5, 0.5])
TRIANGLE = np.array([[0, 1, 2]])


def at(x, y, z, rotation=HERE[0]):
    return rotation, [x, y, z]


def about_x(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def test_distance_of_boxes():
    found = distance(CUBE, HERE, SMALL, at(0.1, 0.2, 2.0))
    assert found.distance == pytest.approx(1.25, abs=ROUNDING)
    assert found.point_a[2] == pytest.approx(0.5, abs=ROUNDING)
    assert found.point_b[2] == pytest.approx(1.75, abs=ROUNDING)
    np.testing.assert_allclose(found.normal, [0, 0, 1], atol=ROUNDING)
    assert set(CUBE.vertices[CUBE.triangles[found.triangle_a]][:, 2]) == {0.5}
    again = distance(CUBE, HERE, SMALL, at(0.1, 0.2, 2.0), start=(found.triangle_a, found.triangle_b))
    assert again.distance == found.distance


def test_distance_equals_all_pairs_of_triangles_and_its_points_lie_on_them(rng):
    meshes = [torus(8, 5), l_shape(), needles(rng, 20)]
    for _ in range(20):
        a, b = (meshes[i] for i in rng.integers(3, size=2))
        poses = [(turn(rng), 1.5 * rng.normal(size=3)) for _ in range(2)]
        corners = [
            [tuple(map(tuple, t)) for t in (m.vertices @ R.T + x)[m.triangles].tolist()]
            for m, (R, x) in zip((a, b), poses, strict=True)
        ]
        found = distance(a, poses[0], b, poses[1])
        truth = min(triangle_points(*p, *q)[0] for p in corners[0] for q in corners[1])
        assert found.distance == pytest.approx(truth, abs=10 * ROUNDING)
        assert intersects(a, poses[0], b, poses[1]) == (truth == 0.0)
        for point, own, triangle in (
            (found.point_a, corners[0], found.triangle_a),
            (found.point_b, corners[1], found.triangle_b),
        ):
            p = tuple(point.tolist())
            assert triangle_points(*own[triangle], p, p, p)[0] <= 10 * ROUNDING


@pytest.mark.parametrize(
    ("offset", "meets"),
    [([1.0, 0.0, 0.0], True), ([1.0, 1.0, 1.0], True), ([1.0 + 1e-12, 0, 0], False), ([0.0, 0.0, 0.0], False)],
    ids=["faces touch", "corners touch", "a hair apart", "one inside the other"],
)
def test_intersection(offset, meets):
    other = SMALL if not any(offset) else CUBE
    assert intersects(CUBE, HERE, other, at(*offset)) is meets
    assert (distance(CUBE, HERE, other, at(*offset)).distance == 0.0) is meets


def test_a_mesh_may_meet_itself():
    assert distance(CUBE, HERE, CUBE, at(3.0, 0.0, 0.0)).distance == pytest.approx(2.0, abs=ROUNDING)


def test_depth_of_a_vertex_in_a_face_and_its_witness_points():
    corner = turn(np.random.default_rng(1))
    lowest = (SMALL.vertices @ corner.T)[:, 2].min()
    found = penetration(CUBE, HERE, SMALL, at(0.1, 0.0, 0.45 - lowest, corner), direction=[0, 0, 2.0])
    assert found.depth == pytest.approx(0.05, abs=ROUNDING)
    np.testing.assert_allclose(found.direction, [0, 0, 1])
    assert found.point_b[2] == pytest.approx(0.45, abs=ROUNDING)
    np.testing.assert_allclose(found.point_a, found.point_b + np.array([0, 0, 0.05]), atol=ROUNDING)
    back = penetration(SMALL, at(0.1, 0.0, 0.45 - lowest, corner), CUBE, HERE, direction=[0, 0, -1.0])
    assert back.depth == pytest.approx(0.05, abs=ROUNDING)
    np.testing.assert_allclose(back.point_a, found.point_b, atol=ROUNDING)
    np.testing.assert_allclose(back.point_b, found.point_a, atol=ROUNDING)


def test_depth_of_two_edges_and_its_witness_points():
    roof, keel = about_x(np.pi / 4), about_x(np.pi / 4)[np.ix_([1, 0, 2], [1, 0, 2])]
    found = penetration(CUBE, at(0, 0, 0, roof), CUBE, at(0.1, 0.2, 2**0.5 - 0.01, keel), direction=[0, 0, 1])
    assert found.depth == pytest.approx(0.01, abs=ROUNDING)
    np.testing.assert_allclose(found.point_a - found.point_b, [0, 0, 0.01], atol=ROUNDING)


def test_depth_without_a_direction_is_along_the_origins():
    found = penetration(CUBE, HERE, CUBE, at(0.0, 0.0, 0.9))
    assert found.depth == pytest.approx(0.1, abs=ROUNDING)
    np.testing.assert_allclose(found.direction, [0, 0, 1])


def test_least_depth_is_for_bodies_that_meet():
    assert penetration(CUBE, HERE, CUBE, at(1.0, 0.3, 0.2), minimum=1e-3).depth == 1e-3
    apart = penetration(CUBE, HERE, CUBE, at(1.5, 0.0, 0.0), minimum=1e-3)
    assert apart.depth == 0.0
    assert apart.point_b[0] - apart.point_a[0] == pytest.approx(0.5, abs=ROUNDING)


@pytest.mark.parametrize("scale", [1e-6, 1e4, 1e12])
def test_sizes_from_a_speck_to_a_planet(scale):
    mesh = TriangleMesh(CUBE.vertices * scale, CUBE.triangles)
    found = distance(mesh, HERE, mesh, at(3.0 * scale, 0.0, 0.0))
    assert found.distance == pytest.approx(2.0 * scale, rel=ROUNDING)


@pytest.mark.parametrize("corners", [np.ones((3, 3)), np.outer([0, 1, 2], [1.0, 1, 1])], ids=["point", "segment"])
def test_triangles_without_area_never_give_nan(corners):
    flat = TriangleMesh(corners, TRIANGLE)
    for other in (flat, CUBE):
        for offset in ([0.0, 0, 0], [3.0, 0, 0], [-4.0, 1, 0]):
            found = distance(flat, HERE, other, at(*offset))
            assert np.isfinite([found.distance, *found.point_a, *found.point_b, *found.normal]).all()
            assert np.isfinite(penetration(flat, HERE, other, at(*offset)).depth)


@pytest.mark.parametrize(
    ("vertices", "triangles", "words"),
    [
        (np.full((3, 3), np.nan), TRIANGLE, "finite; vertex 0"),
        (np.diag([1.0, np.inf, 1.0]), TRIANGLE, "finite; vertex 1"),
        (np.eye(3), [[0, 1, 3]], "vertices 0 to 2; got 3"),
        (np.eye(3), [[0, 1, -1]], "vertices 0 to 2; got -1"),
        (np.eye(3), np.zeros((0, 3), int), "at least one triangle"),
        (np.zeros((0, 3)), np.zeros((0, 3), int), "at least one triangle"),
        (np.eye(3) * 1e200, TRIANGLE, "within 1e"),
    ],
)
def test_bad_meshes_are_refused_by_name(vertices, triangles, words):
    with pytest.raises(MeshError, match=words):
        TriangleMesh(vertices, triangles)


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        ((np.eye(3), [0, np.nan, 0]), "position of pose_b must be finite"),
        ((np.full((3, 3), np.inf), [0, 0, 0]), "rotation of pose_b must be finite"),
        ((2 * np.eye(3), [0, 0, 0]), "orthonormal"),
        ((np.diag([1.0, 1, -1]), [0, 0, 0]), "not mirror"),
        ((np.eye(2), [0, 0, 0]), r"shape \(3, 3\)"),
        ((np.eye(3), [0, 0]), r"shape \(3,\)"),
        ((np.eye(3), [0, 0, 1e30]), "within 1e"),
        ((np.eye(3), "abc"), "numbers"),
        (None, r"must be \(R, x\)"),
    ],
)
def test_bad_poses_are_refused_by_name(pose, words):
    for query in (distance, intersects, penetration):
        with pytest.raises(PoseError, match=words):
            query(CUBE, HERE, SMALL, pose)


def test_bad_directions_depths_and_starts_are_refused():
    with pytest.raises(PoseError, match="direction must not be zero"):
        penetration(CUBE, HERE, SMALL, at(0.5, 0, 0), direction=[0, 0, 0])
    with pytest.raises(ValueError, match="minimum must be"):
        penetration(CUBE, HERE, SMALL, at(0.5, 0, 0), minimum=-1.0)
    with pytest.raises(ValueError, match="12 and 12"):
        distance(CUBE, HERE, SMALL, HERE, start=(12, 0))


def test_what_is_prepared_lives_as_long_as_the_mesh():
    mesh = torus(8, 5)
    distance(mesh, HERE, CUBE, at(5, 0, 0))
    distance(CUBE, at(5, 0, 0), mesh, HERE)
    assert mesh in _alone
    before, partners = len(_alone), len(_together[CUBE])
    distance(mesh, HERE, CUBE, at(6, 0, 0))
    assert len(_alone) == before
    del mesh
    gc.collect()
    assert len(_alone) == before - 1
    assert len(_together[CUBE]) == partners - 1
