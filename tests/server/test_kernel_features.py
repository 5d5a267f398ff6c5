"""P12, P13: which face counts at a contact point, and whether an edge lies flat."""

import numpy as np
import pytest
from triangle_families import turn

from comotion_server.kernels.features import EDGE, FACE, NO_EDGE, VERTEX, contact_features, edge_cosine
from comotion_server.meshes import box
from comotion_server.meshes.mesh_store import MeshStore

HALF = np.array([0.5, 1.0, 1.5])
ROUNDING = 1e-14  # products of unit vectors and rotations


@pytest.fixture(scope="module")
def store():
    return MeshStore.build([box([0.2, 0.2, 0.2]), box(2 * HALF)])


def triangles_at(store, point):
    """The triangles (index within the shape) of the second shape that hold a point of its surface."""
    m = store.arrays
    first = m.triangle_start[1]
    corners = m.vertices[m.triangles[first:]]
    # barycentric coordinates, at which all are non-negative and the height over the plane is zero
    for t, (a, b, c) in enumerate(corners):
        weights, *_ = np.linalg.lstsq(np.vstack([np.transpose([a, b, c]), np.ones(3)]), np.append(point, 1), rcond=None)
        if weights.min() > -1e-9 and np.allclose(weights @ [a, b, c], point, atol=1e-12):
            yield t


def look(store, point, direction, rng):
    """(feature, normal in the body frame) from every triangle that holds the point, in a random pose."""
    for triangle in triangles_at(store, point):
        R, x, normal = turn(rng), rng.normal(size=3), np.empty(3)
        feature = contact_features(store.arrays, 1, x, R, triangle, R @ point + x, R @ direction, normal)
        yield feature, R.T @ normal


@pytest.mark.parametrize(
    ("point", "direction", "feature", "normal"),
    [
        ([1, 1, 1], [1.0, 0.2, 0.1], VERTEX, [1, 0, 0]),
        ([1, 1, 1], [0.3, 0.2, 0.9], VERTEX, [0, 0, 1]),
        ([-1, 1, -1], [0.5, 0.6, -0.1], VERTEX, [0, 1, 0]),
        ([1, 1, 0.3], [0.6, 0.5, 0.9], EDGE, [1, 0, 0]),
        ([1, 1, 0.3], [0.5, 0.6, 0.9], EDGE, [0, 1, 0]),
        ([0.2, 0.1, -1], [0.9, 0.1, -0.2], FACE, [0, 0, -1]),
    ],
)
def test_the_face_nearest_to_the_direction_counts(store, rng, point, direction, feature, normal):
    seen = list(look(store, np.array(point) * HALF, np.array(direction), rng))
    assert seen
    for found, found_normal in seen:
        assert found == feature
        np.testing.assert_allclose(found_normal, normal, atol=ROUNDING)


def test_the_feature_is_found_ten_thousand_kilometres_away(store):
    point, away, normal = HALF * [1, 1, 0.3], np.array([1e7, -1e7, 1e7]), np.empty(3)
    for triangle in triangles_at(store, point):
        args = (store.arrays, 1, away, np.eye(3), triangle, point + away, np.array([1.0, 0.0, 0.0]), normal)
        assert contact_features(*args) == EDGE


@pytest.mark.parametrize(
    ("point", "direction", "cosine"),
    [
        ([1, 1, 0.3], [1.0, 0.0, 0.0], 0.0),  # the edge along z against a face across x
        ([1, 1, 0.3], [0.6, 0.0, 0.8], 0.8),
        ([1, 1, 1], [0.48, 0.6, 0.64], 0.48),  # the flattest of the three edges at a corner
        ([0.2, 0.1, -1], [1.0, 0.0, 0.0], NO_EDGE),  # inside a face
        ([1, 0, 0], [1.0, 0.0, 0.0], NO_EDGE),  # on the line that cuts a face in two triangles
    ],
)
def test_cosine_of_the_flattest_edge(store, rng, point, direction, cosine):
    point = np.array(point) * HALF
    seen = 0
    for triangle in triangles_at(store, point):
        R, x = turn(rng), rng.normal(size=3)
        found = edge_cosine(store.arrays, 1, x, R, triangle, R @ point + x, R @ np.array(direction))
        assert found == pytest.approx(cosine, abs=ROUNDING)
        seen += 1
    assert seen
