"""Surfaces moved outward: exactly where that is possible, at least so far everywhere, refused where they cross."""

import numpy as np
import pytest
from mesh_forms import cube
from meshes_by_hand import l_shape, tetrahedron, torus

from comotion_server.meshes import MeshError, TriangleMesh, box, mass_properties, prism
from comotion_server.meshes.offset import moved_out
from comotion_server.meshes.self_crossing import first_crossing

ROUNDING = 1e-15  # of sizes of about 1 m
EVEN = 1e-6  # of the offset: the module's own


def normals_of(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    doubled = np.cross(b - a, c - a)
    return doubled / np.linalg.norm(doubled, axis=1, keepdims=True)


def moves_of_facets(mesh, frame):
    """How far each corner of each facet has moved along the facet's normal (m, 3)."""
    moved = (frame.vertices - mesh.vertices)[mesh.triangles]
    return np.einsum("mi,mki->mk", normals_of(mesh), moved)


def test_a_box_becomes_a_box():
    frame = moved_out(box([1.0, 2.0, 3.0]), 0.01)
    np.testing.assert_allclose(frame.vertices, box([1.02, 2.02, 3.02]).vertices, atol=ROUNDING)


def test_a_prism_becomes_a_prism_about_the_same_inner_circle():
    """All edges of the triangle move out by the offset: the triangle grows about its incentre, by 1 + offset / r."""
    base, height, thickness, offset = 0.3, 0.2, 0.018, 0.002
    mesh = prism(base, height, thickness)
    frame = moved_out(mesh, offset)
    legs = np.hypot(base / 2, height)
    inner = base * height / (base + 2 * legs)
    centre = np.array([0.0, -height / 3 + inner])
    grown = centre + (1 + offset / inner) * (mesh.vertices[:, :2] - centre)
    np.testing.assert_allclose(frame.vertices[:, :2], grown, atol=ROUNDING)
    np.testing.assert_allclose(frame.vertices[:, 2], np.sign(mesh.vertices[:, 2]) * (thickness / 2 + offset))


def test_an_l_shape_keeps_its_notch():
    frame = moved_out(l_shape(), 0.1)
    outline = np.array([[-0.1, -0.1], [2.1, -0.1], [2.1, 1.1], [1.1, 1.1], [1.1, 2.1], [-0.1, 2.1]]) - 0.8
    np.testing.assert_allclose(frame.vertices[:6, :2], outline, atol=ROUNDING)
    np.testing.assert_allclose(frame.vertices[6:, 2], 0.6, atol=ROUNDING)
    assert mass_properties(frame.vertices, frame.triangles).volume == pytest.approx((2.2**2 - 1.0) * 1.2, rel=1e-14)


@pytest.mark.parametrize("mesh", [tetrahedron(), prism(0.3, 0.2, 0.018)], ids=["tetrahedron", "prism"])
def test_corners_of_three_planes_move_all_of_them_exactly(mesh):
    np.testing.assert_allclose(moves_of_facets(mesh, moved_out(mesh, 1e-3)), 1e-3, rtol=1e-12)


def bumpy(rng):
    """A torus whose corners are all pushed about: no corner of six planes has an exact answer."""
    mesh = torus(24, 12)
    return TriangleMesh(mesh.vertices + 0.01 * rng.normal(size=mesh.vertices.shape), mesh.triangles)


def test_corners_of_many_planes_move_each_at_least_so_far():
    mesh, offset = bumpy(np.random.default_rng(1)), 0.01
    moves = moves_of_facets(mesh, moved_out(mesh, offset))
    assert moves.min() >= offset * (1 - EVEN)
    assert moves.max() > offset * 1.01  # there was no exact answer


def test_the_way_of_such_a_corner_is_the_shortest():
    """Against scipy's quadratic programme, corner by corner."""
    from scipy.optimize import minimize

    mesh, offset = bumpy(np.random.default_rng(2)), 0.01
    ways = (moved_out(mesh, offset).vertices - mesh.vertices) / offset
    normals = normals_of(mesh)
    for corner in range(0, len(ways), 29):
        around = normals[(mesh.triangles == corner).any(axis=1)]
        rule = {"type": "ineq", "fun": lambda d, n=around: n @ d - 1.0, "jac": lambda _, n=around: n}
        best = minimize(lambda d: d @ d, ways[corner], jac=lambda d: 2 * d, constraints=rule, method="SLSQP", tol=1e-14)
        assert ways[corner] == pytest.approx(best.x, abs=1e-6)  # what the peer reaches


def test_flat_faces_of_single_precision_stay_flat():
    """Corners in the middle of faces whose facets differ by rounding move straight out."""
    from comotion_server.meshes.repair import repair

    points, facets = cube()
    halves = (points[facets] + np.roll(points[facets], -1, axis=1)) / 2
    corners = [np.stack([points[facets][:, k], halves[:, k], halves[:, k - 1]], axis=1) for k in range(3)]
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    soup = (np.concatenate([*corners, halves]) @ turn.T).astype(np.float32).astype(float)
    mesh = repair(soup.reshape(-1, 3), np.arange(len(soup) * 3).reshape(-1, 3)).mesh
    np.testing.assert_allclose(moves_of_facets(mesh, moved_out(mesh, 0.01)), 0.01, rtol=EVEN)


def notched(width):
    """A block of 3 x 1 x 1 with a notch of this width, 0.5 deep, in its top."""
    half = width / 2
    outline = np.array([[-1.5, 0], [1.5, 0], [1.5, 1], [half, 1], [half, 0.5], [-half, 0.5], [-half, 1], [-1.5, 1]])
    vertices = np.vstack([np.column_stack([outline[:, 0], np.full(8, y), outline[:, 1]]) for y in (0.5, -0.5)])
    quads = [(0, 1, 4, 5), (1, 2, 3, 4), (0, 5, 6, 7)]
    sides = [(i, i + 8, (i + 1) % 8 + 8, (i + 1) % 8) for i in range(8)]
    quads = np.array([q[::-1] for q in quads] + [tuple(i + 8 for i in q) for q in quads] + [q[::-1] for q in sides])
    return TriangleMesh(vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def test_a_notch_may_close_but_for_a_little():
    mesh = notched(0.1)
    assert mass_properties(mesh.vertices, mesh.triangles).volume == pytest.approx(3.0 - 0.05)
    frame = moved_out(mesh, 0.049)
    assert mass_properties(frame.vertices, frame.triangles).volume > 3.0


def test_a_notch_that_would_close_is_refused_by_the_place():
    with pytest.raises(MeshError, match=r"moved out by 0.06 m, the facet at \(.*\) turns over; take a smaller offset"):
        moved_out(notched(0.1), 0.06)


def two_cubes(gap):
    points, facets = cube()
    shifted = np.add(points, [1.0 + gap, 0.0, 0.0])
    return TriangleMesh(np.concatenate([points, shifted]), np.concatenate([facets, np.add(facets, len(points))]))


def test_parts_that_would_meet_are_refused():
    assert moved_out(two_cubes(0.1), 0.04).triangles.shape == (24, 3)
    for offset in (0.05, 0.06):  # they touch, they cross
        with pytest.raises(MeshError, match=r"the facets at \(.*\) and at \(.*\) meet"):
            moved_out(two_cubes(0.1), offset)


def test_a_corner_that_looks_in_opposite_directions_is_refused():
    """Two tetrahedra that stand on each other at their tips."""
    one = tetrahedron()
    other = one.vertices * [1.0, 1.0, -1.0] - [0.0, 0.0, 1.0]
    mirrored = one.triangles[:, ::-1].astype(np.int64) + 3
    mirrored[mirrored == 3] = 0
    mesh = TriangleMesh(np.concatenate([one.vertices, other[1:]]), np.concatenate([one.triangles, mirrored]))
    with pytest.raises(MeshError, match=r"the corner at \(0, 0, -0.5\) has no way out"):
        moved_out(mesh, 0.01)


def test_facets_with_one_corner_in_common_that_pierce_each_other_are_found():
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.3, -1], [0.3, 0.3, 1], [-1, -1, 1], [-1, -1, -1]], float
    )
    assert first_crossing(points, np.array([[0, 1, 2], [0, 3, 4]])) == (0, 1)
    assert first_crossing(points, np.array([[0, 1, 2], [0, 5, 6]])) is None


def test_facets_with_a_side_in_common_that_fold_over_are_found():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 0.0], [0.5, -0.5, 0.0]])
    assert first_crossing(points, np.array([[0, 1, 2], [1, 0, 3]])) == (0, 1)
    assert first_crossing(points, np.array([[0, 1, 2], [1, 0, 4]])) is None
