"""Eight boxes or triangles at a time: every bound is one, and most are as good as the distance."""

import numpy as np
import pytest
from meshes_by_hand import l_shape, needles, torus
from triangle_families import FAMILIES, turn

from comotion_server.kernels.lane_tree import SIZE
from comotion_server.kernels.lanes import AXES, CENTRE, CORNERS, HALF, LANES, ROWS, box_bounds
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.kernels.triangle_lanes import triangle_bounds
from comotion_server.meshes import TriangleMesh, box
from comotion_server.meshes.mesh_store import MeshStore

ROUNDING = 4e-15  # of the extent: of a bound, which is a difference of coordinates
TIGHT = 1e-9  # relative: the quick closest features are not to the last digit


def corners(triangle):
    return map(tuple, triangle.reshape(3, 3).tolist())


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_triangle_bounds_hold_and_are_mostly_tight(family, rng):
    tight = apart = 0
    for _ in range(100):
        block, bounds = rng.normal(size=(1, ROWS, LANES)), np.empty(LANES)
        one, other = (triangle.ravel() for triangle in family(rng))
        lane, swapped = rng.integers(LANES), rng.integers(2)
        block[0, CORNERS:, lane] = one if swapped else other
        triangle_bounds(block, 0, other if swapped else one, bounds)
        truth = triangle_points(*corners(one), *corners(other))[0]
        extent = max(np.abs(one).max(), np.abs(other).max())
        assert bounds[lane] <= truth + ROUNDING * extent
        if truth > 0.01 * extent:
            apart, tight = apart + 1, tight + (bounds[lane] >= truth * (1 - TIGHT))
    assert tight >= 0.9 * apart


def random_box(rng):
    half = rng.exponential(size=3) * (rng.random(3) < 0.8)  # some are flat
    return np.hstack([2 * rng.normal(size=3), turn(rng).ravel(), half, half.sum()])


def surface(box_row):
    """The faces of a box as twelve triangles (12, 3, 3)."""
    mesh = box([1.0, 1.0, 1.0])
    placed = 2 * mesh.vertices * box_row[HALF:SIZE] @ box_row[AXES:HALF].reshape(3, 3) + box_row[CENTRE:AXES]
    return placed[mesh.triangles]


def test_box_bounds_hold(rng):
    positive = close = 0
    for _ in range(60):
        one, others = random_box(rng), [random_box(rng) for _ in range(LANES)]
        normal, bounds = turn(rng)[:1], np.empty(LANES)
        block = np.zeros((1, ROWS, LANES))
        block[0, :SIZE] = np.array(others).T[:SIZE]
        box_bounds(block, 0, one, normal, 0, bounds)
        for lane in rng.integers(LANES, size=2):
            truth = min(
                triangle_points(*corners(a.ravel()), *corners(b.ravel()))[0]
                for a in surface(one)
                for b in surface(others[lane])
            )
            if bounds[lane] > 0.0:
                assert bounds[lane] <= truth + ROUNDING * 20
            positive, close = positive + (truth > 0.1), close + (bounds[lane] > 0.5 * truth > 0.05)
    assert close > 0.9 * positive


def test_bound_along_the_given_direction_is_used():
    block, bounds = np.zeros((1, ROWS, LANES)), np.empty(LANES)
    block[0, AXES : AXES + 9] = np.eye(3).reshape(9, 1)
    one = np.hstack([[-3.0, -4.0, 0.0], np.eye(3).ravel(), np.zeros(3), 0.0])
    for normal, truth in (([0.6, 0.8, 0.0], 5.0), ([0.0, 0.0, 1.0], 5.0)):
        box_bounds(block, 0, one, np.array([normal]), 0, bounds)
        np.testing.assert_allclose(bounds, truth, rtol=ROUNDING)


@pytest.mark.parametrize("kind", ["torus", "l_shape", "needles", "one", "flat", "point"])
def test_lane_tree_holds_every_triangle_once_inside_all_its_boxes(kind, rng):
    mesh = {
        "torus": lambda: torus(30, 10),
        "l_shape": l_shape,
        "needles": lambda: needles(rng, 50),
        "one": lambda: TriangleMesh(rng.normal(size=(3, 3)), np.array([[0, 1, 2]])),
        "flat": lambda: TriangleMesh(np.outer(np.arange(12.0), [1.0, 0.0, 0.0]), np.arange(12).reshape(-1, 3)),
        "point": lambda: TriangleMesh(np.ones((9, 3)), np.arange(9).reshape(-1, 3)),
    }[kind]()
    m = MeshStore.build([box([1.0, 1.0, 1.0]), mesh]).arrays

    def below(slot):
        if m.link[slot] < 0:
            found = [~m.link[slot]]
            stored = m.block[slot // LANES, CORNERS:, slot % LANES].reshape(3, 3)
            np.testing.assert_array_equal(stored, m.vertices[m.triangles[found[0]]])
        else:
            node = m.link[slot]
            found = [t for lane in range(m.used[node]) for t in below(LANES * node + lane)]
        np.testing.assert_array_equal(m.block[slot // LANES, :SIZE, slot % LANES], m.box[slot, :SIZE])
        offsets = (m.vertices[m.triangles[found]] - m.box[slot, :AXES]) @ m.box[slot, AXES:HALF].reshape(3, 3).T
        assert (np.abs(offsets) <= m.box[slot, HALF:SIZE] + 1e-15).all()
        return found

    assert sorted(below(m.top[1])) == list(range(12, 12 + len(mesh.triangles)))
