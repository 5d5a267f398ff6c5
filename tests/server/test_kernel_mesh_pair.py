"""P6: the walk down two trees gives the same answer as all pairs of triangles."""

from dataclasses import dataclass

import numpy as np
import pytest
from meshes_by_hand import l_shape, needles, torus
from triangle_families import turn

from comotion_server.kernels.hierarchy import DEEPEST
from comotion_server.kernels.mesh_pair import closest_points_of_pairs
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.meshes import TriangleMesh, box
from comotion_server.meshes.mesh_store import MeshStore

ROUNDING = 1e-14  # of the size: poses are applied in another order than in the truth
FAR_ROUNDING = 1e-9  # [m] at 1e6 m: four units in the last place of the positions


@dataclass
class Answer:
    distance: float
    point_a: np.ndarray
    point_b: np.ndarray
    normal: np.ndarray
    witness: np.ndarray


def ask(store, shapes, positions, rotations, *, reach=np.inf, witness=(-1, -1)):
    distance, points, normal = np.empty(1), np.empty((2, 1, 3)), np.empty((1, 3))
    found = np.array([witness])
    closest_points_of_pairs(
        store.arrays,
        np.array(shapes),
        positions,
        rotations,
        np.array([[0, 1]]),
        np.array([reach]),
        found,
        distance,
        points[0],
        points[1],
        normal,
    )
    return Answer(distance[0], points[0, 0], points[1, 0], normal[0], found[0])


def all_pairs(meshes, positions, rotations):
    """The definition: the least distance over all pairs of triangles, in the world frame."""
    moved = [mesh.vertices @ R.T + x for mesh, x, R in zip(meshes, positions, rotations, strict=True)]
    corners = [
        [tuple(map(tuple, corner.tolist())) for corner in v[m.triangles]] for v, m in zip(moved, meshes, strict=True)
    ]
    return min(triangle_points(*a, *b)[0] for a in corners[0] for b in corners[1])


@pytest.fixture(scope="module")
def meshes():
    rng = np.random.default_rng(11)
    return [torus(9, 5), l_shape(), needles(rng, 30), box([1.0, 0.4, 2.0]), torus(12, 4, tube=0.1)]


@pytest.fixture(scope="module")
def store(meshes):
    return MeshStore.build(meshes)


def poses(rng, spread):
    return spread * rng.normal(size=(2, 3)), np.stack([turn(rng), turn(rng)])


@pytest.mark.parametrize("spread", [0.6, 1.2, 4.0])
def test_equals_all_pairs_in_any_order_from_any_start(meshes, store, rng, spread):
    for _ in range(25):
        shapes = rng.integers(len(meshes), size=2)
        positions, rotations = poses(rng, spread)
        truth = all_pairs([meshes[s] for s in shapes], positions, rotations)
        answer = ask(store, shapes, positions, rotations)
        size = store.size[shapes].max() + np.abs(positions).max()
        assert abs(answer.distance - truth) <= ROUNDING * size
        assert (answer.distance == 0.0) == (truth == 0.0)
        assert abs(np.linalg.norm(answer.point_a - answer.point_b) - truth) <= ROUNDING * size
        assert (answer.point_b - answer.point_a) @ answer.normal == pytest.approx(truth, abs=ROUNDING * size)

        swapped = ask(store, shapes[::-1], positions[::-1], rotations[::-1])
        assert abs(swapped.distance - truth) <= ROUNDING * size
        anywhere = [rng.integers(len(meshes[s].triangles)) for s in shapes]
        started = ask(store, shapes, positions, rotations, witness=anywhere)
        assert abs(started.distance - truth) <= ROUNDING * size
        again = ask(store, shapes, positions, rotations, witness=answer.witness)
        assert abs(again.distance - truth) <= ROUNDING * size


def test_tiny_gaps_and_touching_are_told_apart_alike_from_any_start(meshes, store, rng):
    for case in range(120):
        shapes = rng.integers(len(meshes), size=2)
        positions, rotations = poses(rng, 1.5)
        rotations[1] = rotations[case % 2]  # half of them with level faces
        apart = ask(store, shapes, positions, rotations)
        gap = 10.0 ** rng.uniform(-16, -3)
        positions[1] -= apart.normal * (apart.distance - gap)
        cold = ask(store, shapes, positions, rotations)
        warm = ask(store, shapes, positions, rotations, witness=apart.witness)
        size = store.size[shapes].max() + np.abs(positions).max()
        if apart.distance > 0:
            assert cold.distance == pytest.approx(gap, abs=ROUNDING * size)
        assert warm.distance == pytest.approx(cold.distance, abs=ROUNDING * size)
        assert (warm.distance == 0.0) == (cold.distance == 0.0)
        if gap > ROUNDING * size:
            assert (cold.distance > 0.0) == (apart.distance > 0.0)


def test_poses_that_are_no_numbers_end_at_once(store):
    positions = np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
    assert np.isnan(ask(store, [0, 1], positions, np.stack([np.eye(3)] * 2)).distance)


def test_witness_triangles_hold_the_points(meshes, store, rng):
    for _ in range(30):
        shapes = rng.integers(len(meshes), size=2)
        positions, rotations = poses(rng, 1.5)
        answer = ask(store, shapes, positions, rotations)
        for body, point in enumerate((answer.point_a, answer.point_b)):
            mesh = meshes[shapes[body]]
            corners = mesh.vertices[mesh.triangles[answer.witness[body]]] @ rotations[body].T + positions[body]
            p = tuple(point.tolist())
            off = triangle_points(p, p, p, *map(tuple, corners.tolist()))[0]
            assert off <= ROUNDING * (store.size.max() + np.abs(positions).max())


def test_a_scene_far_away_keeps_its_digits(meshes, store, rng):
    for _ in range(20):
        shapes = rng.integers(len(meshes), size=2)
        positions, rotations = poses(rng, 1.5)
        there = ask(store, shapes, positions + 1e6 * rng.normal(size=3), rotations)
        assert abs(there.distance - ask(store, shapes, positions, rotations).distance) <= FAR_ROUNDING


def test_beyond_reach_is_a_proven_bound_and_below_it_exact(meshes, store, rng):
    for _ in range(60):
        shapes = rng.integers(len(meshes), size=2)
        positions, rotations = poses(rng, 1.5)
        truth = ask(store, shapes, positions, rotations).distance
        reach = 2 * truth * rng.random() + 0.01 * rng.random()
        answer = ask(store, shapes, positions, rotations, reach=reach)
        if truth < reach:
            assert abs(answer.distance - truth) <= ROUNDING * store.size.max()
        else:
            assert reach <= answer.distance <= truth * (1 + ROUNDING)
        assert (answer.witness >= 0).all()


def test_linked_tori_do_not_touch(rng):
    ring = torus(24, 8, radius=1.0, tube=0.1)
    store = MeshStore.build([ring])
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    for _ in range(10):
        positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0] + 0.3 * rng.normal(size=3)])
        rotations = np.stack([np.eye(3), upright])
        truth = all_pairs([ring, ring], positions, rotations)
        assert abs(ask(store, [0, 0], positions, rotations).distance - truth) <= ROUNDING * ring.size
    linked = ask(store, [0, 0], np.array([[0.0, 0, 0], [1.0, 0, 0]]), np.stack([np.eye(3), upright]))
    assert linked.distance == pytest.approx(
        0.8, abs=0.02
    )  # circles 1 apart, tubes of 0.1; facets cut the circles short


def test_boxes_have_their_closed_form(rng):
    store = MeshStore.build([box([1.0, 2.0, 3.0]), box([0.5, 0.5, 0.5])])
    half = np.array([0.75, 1.25, 1.75])
    for _ in range(50):
        offset = 4 * rng.normal(size=3)
        gaps = np.maximum(np.abs(offset) - half, 0)
        answer = ask(store, [0, 1], np.array([np.zeros(3), offset]), np.stack([np.eye(3)] * 2))
        if gaps.any():
            assert answer.distance == pytest.approx(np.linalg.norm(gaps), abs=4 * ROUNDING)


def test_one_call_answers_many_pairs(store, rng):
    count = 6
    shapes = rng.integers(len(store.size), size=count)
    positions, rotations = 2 * rng.normal(size=(count, 3)), np.stack([turn(rng) for _ in range(count)])
    pairs = np.array([(i, j) for i in range(count) for j in range(i)])
    distance, points, normal = np.empty(len(pairs)), np.empty((2, len(pairs), 3)), np.empty((len(pairs), 3))
    witness, reach = np.full((len(pairs), 2), -1), np.full(len(pairs), np.inf)
    closest_points_of_pairs(
        store.arrays, shapes, positions, rotations, pairs, reach, witness, distance, *points, normal
    )
    for k, pair in enumerate(pairs):
        alone = ask(store, shapes[pair], positions[pair], rotations[pair])
        assert alone.distance == distance[k]
        assert (alone.witness == witness[k]).all()


def depth_of(arrays):
    depth = np.zeros(len(arrays.child), dtype=int)
    for node in range(len(arrays.child)):
        if arrays.child[node] >= 0:
            depth[arrays.child[node] : arrays.child[node] + 2] = depth[node] + 1
    return depth.max()


@pytest.mark.parametrize(
    "places",
    [
        np.zeros((500, 3)),  # all in one place: nothing to divide by
        np.outer(2.0 ** -np.arange(500), [1, 2, 3]),  # each division splits off one triangle
    ],
    ids=["coincident", "geometric"],
)
def test_odd_meshes_give_trees_of_bounded_depth(places):
    corners = places[:, None, :] + 1e-3 * places[:, None, :1] * np.eye(3) + 1e-9 * np.eye(3)
    mesh = TriangleMesh(corners.reshape(-1, 3), np.arange(3 * len(places)).reshape(-1, 3))
    store = MeshStore.build([mesh, box([1.0, 1.0, 1.0])])
    assert depth_of(store.arrays) <= DEEPEST + np.log2(len(places)) + 1
    positions = np.array([[0.0, 0, 0], [-2.0, -2.5, -3.0]])
    answer = ask(store, [0, 1], positions, np.stack([np.eye(3)] * 2))
    assert answer.distance == pytest.approx(all_pairs([mesh, box([1.0, 1, 1])], positions, [np.eye(3)] * 2), abs=1e-14)


def test_boxes_of_the_tree_hold_their_triangles(meshes):
    for mesh in meshes:
        m = MeshStore.build([mesh]).arrays
        assert sorted(m.leaf_triangles) == list(range(len(mesh.triangles)))
        for node in range(len(m.child)):
            inside = m.leaf_triangles[m.first[node] : m.first[node] + m.entries[node]]
            offsets = (m.vertices[m.triangles[inside]] - m.centre[node]) @ m.axes[node].T
            assert (np.abs(offsets) <= m.half[node] + 1e-15).all()
            np.testing.assert_allclose(m.axes[node] @ m.axes[node].T, np.eye(3), atol=ROUNDING)
