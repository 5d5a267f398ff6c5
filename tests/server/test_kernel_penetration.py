"""P8: overlaps of a known depth; who is inside."""

import numpy as np
import pytest
from meshes_by_hand import in_l_shape, l_shape, tetrahedron, torus
from triangle_families import turn

from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.penetration import overlap_depth
from comotion_server.kernels.ray import way_out, winding_number
from comotion_server.meshes import box, prism
from comotion_server.meshes.mesh_store import MeshStore

ROUNDING = 1e-12  # [m]: poses are applied twice to bodies of size about 1
UP = np.array([0.0, 0.0, 1.0])


def about(axis, angle):
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


ALONG_X_EDGE, ALONG_Y_EDGE = about([1, 0, 0], np.pi / 4), about([0, 1, 0], np.pi / 4)
UPRIGHT = about([0, 1, 0], np.pi / 2)
FLAT = np.eye(3)


def depth(a, b, offset, rotation_a=FLAT, rotation_b=FLAT, direction=UP, frame=FLAT, at=(0.0, 0.0, 0.0)):
    """Overlap of b at `offset` from a, the whole scene turned by `frame` and moved to `at`."""
    store = MeshStore.build([a, b])
    m, (shape_a, shape_b) = store.arrays, store.shape_of_mesh
    at = np.array(at)
    poses = (at, frame @ rotation_a, at + frame @ np.array(offset, dtype=float), frame @ rotation_b)
    back = (poses[2], poses[3], poses[0], poses[1])
    forth = overlap_depth(m, shape_a, shape_b, *poses, frame @ direction)
    assert overlap_depth(m, shape_b, shape_a, *back, -frame @ direction) == pytest.approx(forth, abs=ROUNDING)
    return forth


CUBE, SMALL, FLOE = box([1.0, 1.0, 1.0]), box([0.5, 0.5, 0.5]), prism(0.3, 0.2, 0.018)


@pytest.mark.parametrize(
    ("a", "b", "offset", "turns", "expected"),
    [
        pytest.param(CUBE, SMALL, [0.1, 0.05, 0.7], (FLAT, FLAT), 0.05, id="small box in a face"),
        pytest.param(CUBE, CUBE, [0.3, 0.2, 0.95], (FLAT, FLAT), 0.05, id="equal boxes, shifted"),
        pytest.param(CUBE, CUBE, [0.0, 0.0, 0.95], (FLAT, FLAT), 0.05, id="equal boxes, sides coplanar"),
        pytest.param(CUBE, CUBE, [0.3, 0.0, 0.95], (FLAT, FLAT), 0.05, id="equal boxes, one side coplanar"),
        pytest.param(CUBE, FLOE, [0.1, 0.1, 0.505], (FLAT, FLAT), 0.004, id="prism in a face"),
        pytest.param(CUBE, FLOE, [0.0, 0.0, 0.505], (FLAT, UPRIGHT), 0.145, id="prism on edge"),
        pytest.param(CUBE, tetrahedron(), [0.1, 0.2, 0.97], (FLAT, FLAT), 0.03, id="apex in a face"),
        pytest.param(CUBE, tetrahedron(), [0.0, 0.0, 0.97], (FLAT, FLAT), 0.03, id="apex on a diagonal"),
        pytest.param(
            CUBE, CUBE, [0.0, 0.0, 2**0.5 - 0.01], (ALONG_X_EDGE, ALONG_Y_EDGE), 0.01, id="edge across edge, centred"
        ),
        pytest.param(
            CUBE, CUBE, [0.12, 0.07, 2**0.5 - 0.01], (ALONG_X_EDGE, ALONG_Y_EDGE), 0.01, id="edge across edge"
        ),
        pytest.param(box([2.0, 2.0, 0.1]), box([2.0, 2.0, 0.1]), [0, 0, 0.3], (FLAT, UPRIGHT), 0.75, id="plates"),
        pytest.param(CUBE, CUBE, [0.3, 0.2, 1.0 - 1e-9], (FLAT, FLAT), 1e-9, id="tiny"),
        pytest.param(CUBE, SMALL, [0.05, 0.02, 0.0], (FLAT, FLAT), 0.75, id="nested"),
        pytest.param(CUBE, SMALL, [0.0, 0.0, 1.0], (FLAT, FLAT), 0.0, id="apart"),
    ],
)
def test_overlap_of_known_depth(a, b, offset, turns, expected, rng):
    assert depth(a, b, offset, *turns) == pytest.approx(expected, abs=ROUNDING)
    assert depth(a, b, offset, *turns, frame=turn(rng)) == pytest.approx(expected, abs=ROUNDING)
    assert depth(a, b, offset, *turns, at=(1e3, -1e3, 1e3)) == pytest.approx(expected, abs=1e3 * ROUNDING)


def test_depth_is_the_distance_to_the_plane_of_the_face_that_the_ray_finds():
    slanted = np.array([0.6, 0.0, 0.8])
    assert depth(CUBE, SMALL, [0.0, 0.05, 0.7], direction=slanted) == pytest.approx(0.05, abs=ROUNDING)


def test_without_a_direction_the_origins_give_one():
    assert depth(CUBE, SMALL, [0.0, 0.0, 0.7], direction=np.zeros(3)) == pytest.approx(0.05, abs=ROUNDING)
    assert depth(CUBE, SMALL, [0.0, 0.0, 0.0], direction=np.zeros(3)) == pytest.approx(0.75, abs=ROUNDING)


NEAR = 1e-6 * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])


def inside(m, point, direction):
    stack = np.empty((STACK_SIZE, 2), np.int64)
    return way_out(m, 0, tuple(point.tolist()), tuple(direction.tolist()), stack)


def test_inside_of_a_body_that_is_not_convex(rng):
    m = MeshStore.build([l_shape()]).arrays
    for _ in range(500):
        point = rng.uniform(-1.2, 1.6, size=3) * [1, 1, 0.5]
        if rng.random() < 0.5:
            point = np.round(point * 4) / 4 + [0.2, 0.2, 0.0]  # rays along edges, diagonals and faces
        if len({in_l_shape(point + shift) for shift in NEAR}) > 1:
            continue  # on the surface
        direction = turn(rng)[0] if rng.random() < 0.5 else np.eye(3)[rng.integers(3)]
        assert (inside(m, point, direction) >= 0) == in_l_shape(point)


def test_way_out_of_a_torus_ends_at_the_first_wall(rng):
    m = MeshStore.build([torus(48, 24)]).arrays
    assert inside(m, np.array([-1.0, 0.01, 0.0]), np.array([1.0, 0.0, 0.0])) == pytest.approx(0.3, abs=0.01)
    assert inside(m, np.array([0.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])) < 0
    for _ in range(100):
        point = rng.uniform(-1.5, 1.5, size=3) * [1, 1, 0.3]
        off_tube = np.hypot(np.hypot(*point[:2]) - 1.0, point[2])
        if abs(off_tube - 0.3) > 0.01:
            assert (inside(m, point, turn(rng)[0]) >= 0) == (off_tube < 0.3)


def test_winding_number_counts_the_surface_once(rng):
    m = MeshStore.build([l_shape()]).arrays
    for _ in range(100):
        point = tuple(rng.uniform(-1.2, 1.6, size=3).tolist())
        assert winding_number(m, 0, point) == pytest.approx(float(in_l_shape(point)), abs=1e-12)
