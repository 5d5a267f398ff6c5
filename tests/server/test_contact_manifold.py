"""Contact points of two bodies: known polygons, normals and counts."""

from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest
from contact_forms import (
    GAP,
    REACH,
    UPRIGHT,
    Touching,
    area,
    centred_cube,
    clipped,
    ell,
    extruded,
    slab,
    turn,
)
from mesh_forms import sphere, torus

from comotion_mock_cfd.body_forms import floe_mesh
from comotion_server.kernels.contact_manifold import gap_of_pair
from comotion_server.kernels.contacts import (
    CORNER_FACE,
    CROSSING_A,
    CROSSING_B,
    EDGES,
    FACE_CORNER,
    FULL,
    POINTS,
    new_contacts,
)
from comotion_server.meshes import box

ROUNDING = 1e-14  # of coordinates of size 1 after two rotations
PLACES = 1e-12  # crossings of edges at not too small angles amplify rounding
NOISE = 3e-6  # of a direction between two points as close as GAP: rounding over gap, with a margin

CUBE, UP = centred_cube(), np.array([0.0, 0.0, 1.0])
FLOOR = slab(1)
ON_EDGE, ON_CORNER = turn([1, 0, 0], pi / 4), turn([1, -1, 0], acos(1 / sqrt(3)))
HALVES = {"face": 0.5, "edge": sqrt(0.5), "corner": sqrt(0.75)}
ATTITUDES = {"face": turn(UP, 0.3), "edge": turn(UP, 0.3) @ ON_EDGE, "corner": ON_CORNER}
COUNTS = {"face": 4, "edge": 2, "corner": 1}


@pytest.mark.parametrize("floor", ["box", "plane", "jittered"])
@pytest.mark.parametrize("on", ["face", "edge", "corner"])
@pytest.mark.parametrize("cube_first", [True, False])
def test_a_cube_on_a_floor_touches_with_its_lowest_corners(floor, on, cube_first):
    ground = {"box": FLOOR, "plane": UP, "jittered": slab(24)}[floor]
    height, place = HALVES[on] + GAP, np.array([0.12, -0.07, 0.0])
    forms, x, R = [CUBE, ground], [place + height * UP, np.zeros(3)], [ATTITUDES[on], UPRIGHT]
    if not cube_first:
        forms, x, R = forms[::-1], x[::-1], R[::-1]
    both = Touching(forms, x, R)
    assert both.count == COUNTS[on]
    np.testing.assert_array_equal(both.column("normal"), np.tile(-UP if cube_first else UP, (both.count, 1)))
    assert set(both.column("kind")) == {CORNER_FACE if cube_first else FACE_CORNER}
    np.testing.assert_allclose(both.column("gap"), GAP, atol=ROUNDING)
    corners = CUBE[0] @ ATTITUDES[on].T
    lowest = corners[corners[:, 2] < corners[:, 2].min() + 1e-9]
    cube_arm, floor_arm = ("arm_a", "arm_b") if cube_first else ("arm_b", "arm_a")
    found = both.column(cube_arm)
    distance = np.linalg.norm(found[:, None] - lowest[None], axis=2)
    assert distance.min(axis=1).max() < ROUNDING
    assert set(distance.argmin(axis=1)) == set(range(COUNTS[on]))
    feet = found + place + [0.0, 0.0, height]
    feet[:, 2] = 0.0
    np.testing.assert_allclose(both.column(floor_arm), feet, atol=ROUNDING)


def test_a_cube_on_seven_thousand_jittered_triangles_has_the_normal_of_the_face_and_four_corners():
    """Lines within the face leave no trace, wherever the cube stands."""
    floor = slab(60)
    both = Touching([CUBE, floor], [[0.0, 0.0, 0.5 + GAP], [0, 0, 0]], [turn(UP, 0.3), UPRIGHT])
    for step in range(40):
        both.x[0, :2] = [0.031 * step - 0.6, 0.017 * step - 0.4]
        assert both.again() == 4
        np.testing.assert_array_equal(both.column("normal"), np.tile(-UP, (4, 1)))
        assert set(both.column("feature")[:, 0]) == {0, 1, 2, 3}


def test_two_hexagons_side_by_side_have_the_normal_of_their_faces():
    """The edges of their lids are as near, or nearer by rounding: a worse direction."""
    side, upright = 0.5, np.array([cos(pi / 6), sin(pi / 6), 0.0])
    hexagon, rng = floe_mesh(side, 0.5 * side), np.random.default_rng(3)
    for _ in range(40):
        R = turn(rng.normal(size=3), rng.uniform(0.0, pi))
        for k in range(6):
            n = R @ turn(UP, k * pi / 3) @ upright
            both = Touching([hexagon, hexagon], [np.zeros(3), (sqrt(3.0) * side + GAP) * n], [R, R])
            assert both.count == 4
            np.testing.assert_allclose(both.column("normal"), np.tile(n, (4, 1)), atol=ROUNDING)


@pytest.mark.parametrize("seed", range(6))
def test_the_patch_of_two_prisms_is_the_overlap_of_their_faces(seed):
    rng = np.random.default_rng(seed)
    for _ in range(10):
        outlines = []
        for _ in range(2):
            angles = np.sort(rng.uniform(0.0, 2.0 * pi, rng.integers(3, 9)))
            outlines.append(np.c_[np.cos(angles), np.sin(angles)] * rng.uniform(0.5, 1.5))
        below, above = (extruded(o, 0.3) for o in outlines)
        angle, shift = rng.uniform(0.0, 2.0 * pi), rng.uniform(-0.4, 0.4, 2)
        R = turn(UP, angle)
        expected = clipped(outlines[0], outlines[1] @ R[:2, :2].T + shift)
        both = Touching([below, above], [np.zeros(3), [*shift, 0.3 + GAP]], [UPRIGHT, R])
        if len(expected) == 0:
            assert both.count == 0
            continue
        np.testing.assert_allclose(both.points[:, 2], 0.3, atol=ROUNDING)
        assert abs(area(both.points[:, :2]) - area(expected)) < PLACES
        distance = np.linalg.norm(both.points[:, None, :2] - expected[None], axis=2)
        assert distance.min(axis=1).max() < PLACES  # every corner is one of the overlap, and no corner is missing
        assert distance.min(axis=0).max() < 1e-6
        assert set(both.column("kind")) <= {CORNER_FACE, FACE_CORNER, CROSSING_A, CROSSING_B}


def test_cubes_flush_with_each_other_touch_in_four_corners():
    both = Touching([CUBE, CUBE], [np.zeros(3), [0, 0, 1 + GAP]], [UPRIGHT, UPRIGHT])
    np.testing.assert_allclose(sorted(map(tuple, both.points)), [(x, y, 0.5) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
    turned = Touching([CUBE, CUBE], [np.zeros(3), [0, 0, 1 + GAP]], [UPRIGHT, turn(UP, pi / 4)])
    assert turned.count == 8
    assert abs(area(turned.points[:, :2]) - (2 * sqrt(2) - 2)) < PLACES


def test_boxes_on_a_grid_touch_in_the_rectangle_stretch_or_point_that_they_share(rng):
    """Half-integer shifts of integer boxes, turned or not: flush sides, shared edges and corners of all sorts."""
    seen = set()
    for case in range(400):
        sizes, Q = rng.integers(1, 4, (2, 3)).astype(float), turn(rng.normal(size=3), 1.0) if case % 2 else UPRIGHT
        axis, shift = case % 3, rng.integers(-6, 7, 3) * 0.5
        shift[axis] = 0.5 * sizes[:, axis].sum() + GAP
        others = [k for k in range(3) if k != axis]
        low = np.maximum(-0.5 * sizes[0], shift - 0.5 * sizes[1])[others]
        high = np.minimum(0.5 * sizes[0], shift + 0.5 * sizes[1])[others]
        forms = [(b.vertices, b.triangles) for b in map(box, sizes)]
        both = Touching(forms, [np.zeros(3), Q @ shift], [Q, Q])
        expected = 0 if (high < low).any() else 2 ** int((high > low).sum())
        seen.add(expected)
        assert both.count == expected
        if expected:
            points, normals = both.points @ Q, both.column("normal") @ Q
            np.testing.assert_allclose(normals, np.tile(np.eye(3)[axis], (expected, 1)), atol=NOISE)
            np.testing.assert_allclose(points[:, others].min(axis=0), low, atol=PLACES)
            np.testing.assert_allclose(points[:, others].max(axis=0), high, atol=PLACES)
    assert seen == {0, 1, 2, 4}


def test_a_bridge_on_two_supports_touches_in_one_patch_over_both():
    """One normal: the outer corners of both feet say all that all eight say."""
    outline = [(-2, 0), (-1, 0), (-1, 1), (1, 1), (1, 0), (2, 0), (2, 2), (-2, 2)]
    bridge = extruded(outline, 1.0, [(0, 1, 2), (0, 2, 7), (7, 2, 3), (7, 3, 6), (3, 5, 6), (3, 4, 5)])
    flat = turn([1, 0, 0], pi / 2)  # its feet look down to -z
    both = Touching([bridge, slab(8, 6.0)], [[0.0, 0.0, GAP], [0, 0, 0]], [flat, UPRIGHT])
    assert both.count == 4
    np.testing.assert_array_equal(both.column("normal")[0], -UP)
    np.testing.assert_allclose(sorted(np.abs(both.points[:, 0])), [2, 2, 2, 2], atol=ROUNDING)


def test_an_l_in_the_notch_of_an_l_touches_in_two_patches():
    """Interlocked, each leg's end in the other's notch: along x at both ends, along y between the legs."""
    both = Touching([ell(), ell()], [np.zeros(3), [1 + GAP, 2 * GAP, 0.25]], [UPRIGHT, turn(UP, pi)])
    assert both.count == 8
    normals = both.column("normal")
    for axis, gap, low, high in ((0, GAP, -1, 1), (1, 2 * GAP, 0, 1)):
        rows = np.abs(normals[:, axis]) > 0.5
        assert rows.sum() == 4
        np.testing.assert_allclose(normals[rows, axis], 1.0, atol=ROUNDING)
        np.testing.assert_allclose(both.column("gap")[rows], gap, atol=ROUNDING)
        along = both.points[rows, 1 - axis]
        np.testing.assert_allclose([along.min(), along.max()], [low, high], atol=2 * GAP + PLACES)
        np.testing.assert_allclose(np.unique(np.round(both.points[rows, 2], 12)), [0.25, 1.0])


def test_two_edges_touch_in_one_point_and_parallel_ones_in_the_ends_of_their_overlap():
    crossed = [ON_EDGE, turn([0, 1, 0], pi / 4)]
    both = Touching([CUBE, CUBE], [[0.1, 0.2, 2 * sqrt(0.5) + GAP], np.zeros(3)], crossed)
    assert list(both.column("kind")) == [EDGES]
    np.testing.assert_allclose(both.column("normal"), [-UP], atol=ROUNDING)
    np.testing.assert_allclose(both.points, [[-0.1, 0.0, -sqrt(0.5)]], atol=PLACES)
    both = Touching([CUBE, CUBE], [[0.3, 0, 2 * sqrt(0.5) + GAP], np.zeros(3)], [ON_EDGE, ON_EDGE])
    assert list(both.column("kind")) == [POINTS, POINTS]
    np.testing.assert_allclose(both.column("normal"), [-UP, -UP], atol=NOISE)
    np.testing.assert_allclose(sorted(both.points[:, 0]), [-0.5, 0.2], atol=PLACES)


def test_a_corner_on_a_corner_touches_along_the_line_between_them():
    aside = np.array([0.6, 0.0, 0.8]) * GAP  # seen from below the corners lie beside each other
    both = Touching([CUBE, CUBE], [2 * sqrt(0.75) * UP + aside, np.zeros(3)], [ON_CORNER, ON_CORNER])
    assert list(both.column("kind")) == [POINTS]
    np.testing.assert_allclose(both.column("normal"), [[-0.6, 0.0, -0.8]], atol=NOISE)


def touching_tori():
    """Linked rings of 24 x 24 vertices that touch with the four facets around an inner and an outer vertex."""
    ring = torus(24)
    both = Touching([ring, ring], np.zeros((2, 3)), [UPRIGHT, turn([1, 0, 0], pi / 2)])
    witness = np.array([-1, -1])
    low, high = 3.0, 6.0
    while high - low > 1e-12:
        both.x[1, 0] = 0.5 * (low + high)
        gap = gap_of_pair(both.solids, 0, 1, both.x, both.R, np.inf, witness, both.work)
        low, high = (both.x[1, 0], high) if gap > GAP else (low, both.x[1, 0])
    both.x[1, 0] = low
    both.count = both.again()
    return both


def test_linked_tori_touch_with_four_facets_at_once():
    both = touching_tori()
    normals, counts = np.unique(np.round(both.column("normal"), 9), axis=0, return_counts=True)
    assert list(counts) == [4, 4, 4, 4]
    slope = sin(pi / 12) / 2  # facets of the innermost ring: width 2 sin(pi/24) in both senses
    assert np.ptp(np.abs(normals), axis=0).max() < 1e-8
    assert np.abs(normals[:, 1:] / normals[:, :1]).max() < 2 * slope
    assert both.column("gap").max() < REACH
    assert abs(both.column("gap").min() - GAP) < 2e-12


@pytest.mark.parametrize("on", ["face", "edge", "corner"])
def test_numbering_does_not_matter(on, rng):
    """Vertices, triangles and their corners in another order: the same rows in another order at most."""
    floor = slab(6)
    x, R = [[0.12, -0.07, HALVES[on] + GAP], [0, 0, 0]], [ATTITUDES[on], UPRIGHT]
    expected = Touching([CUBE, floor], x, R).sorted_rows()
    for _ in range(5):
        forms = []
        for vertices, triangles in (CUBE, floor):
            new = rng.permutation(len(vertices))
            moved = np.empty_like(vertices)
            moved[new] = vertices
            rolled = np.array([np.roll(new[t], rng.integers(3)) for t in rng.permutation(triangles)])
            forms.append((moved, rolled))
        np.testing.assert_allclose(Touching(forms, x, R).sorted_rows(), expected, atol=PLACES)


def test_a_mirror_image_touches_in_the_mirror_image(rng):
    flip = np.diag([-1.0, 1.0, 1.0])
    below, above = slab(5), centred_cube()
    mirrored = [(v @ flip, t[:, ::-1]) for v, t in (below, above)]
    for _ in range(5):
        R, shift = turn(UP, rng.uniform(0, 6)), rng.uniform(-2.2, 2.2, 2)
        x = np.array([np.zeros(3), [*shift, 0.5 + GAP]])
        one = Touching([below, above], x, [UPRIGHT, R])
        other = Touching(mirrored, x @ flip, [UPRIGHT, flip @ R @ flip])
        assert one.count == other.count
        for name in ("arm_a", "arm_b"):
            ones, others = one.column(name) @ flip, other.column(name)
            assert np.linalg.norm(ones[:, None] - others[None], axis=2).min(axis=1).max() < PLACES


def test_exchanged_bodies_touch_the_other_way_round():
    R, x = turn(UP, 0.7), np.array([[0.3, 0.2, 1 + GAP], np.zeros(3)])
    one = Touching([CUBE, CUBE], x, [R, UPRIGHT])
    other = Touching([CUBE, CUBE], x[::-1], [UPRIGHT, R])
    assert one.count == other.count
    np.testing.assert_allclose(one.column("normal"), -other.column("normal"), atol=ROUNDING)
    difference = np.linalg.norm(one.column("arm_a")[:, None] - other.column("arm_b")[None], axis=2)
    assert difference.min(axis=1).max() < PLACES


def test_a_scene_a_thousand_kilometres_away_has_the_same_contacts():
    """Poses there are multiples of 2^-33 m; the gap is rounded to one, everything else stays."""
    x = np.array([[0.125, -0.0625, 0.5 + 2.0**-30], [0, 0, 0]])
    R = [turn(UP, 0.3), UPRIGHT]
    near = Touching([CUBE, slab(6)], x, R)
    away = np.array([1048576.0, -1048576.0, 1048576.0])
    far = Touching([CUBE, slab(6)], x + away, R)
    np.testing.assert_array_equal(near.sorted_rows(), far.sorted_rows())


@pytest.mark.parametrize("ground", [UP, slab(4)], ids=["plane", "mesh"])
def test_a_tilt_within_the_angle_is_level_and_beyond_it_is_not(ground):
    """Tilted by 1e-7: the far corners are 1e-7 above the floor, beyond the reach."""
    tilt = 1e-7
    height = 0.5 * (sin(tilt) + cos(tilt)) + GAP
    pose = [[0.1, 0.2, height], [0, 0, 0]], [turn([1, 0, 0], tilt), UPRIGHT]
    assert Touching([CUBE, ground], *pose).count == 2
    assert Touching([CUBE, ground], *pose, angle=1e-6, level=2e-6).count == 4
    assert Touching([CUBE, ground], *pose, angle=1e-6, level=5e-8).count == 2
    steep = [[0.1, 0.2, 0.5 * (sin(1e-4) + cos(1e-4)) + GAP], [0, 0, 0]], [turn([1, 0, 0], 1e-4), UPRIGHT]
    assert Touching([CUBE, ground], *steep, angle=1e-6, level=1e-3).count == 2


def test_bodies_out_of_reach_have_no_contacts():
    for other, height in ((UP, 0.5), (FLOOR, 0.5)):
        pose = [[0.0, 0.0, height + 2 * REACH], [0, 0, 0]], [UPRIGHT, UPRIGHT]
        assert Touching([CUBE, other], *pose).count == 0
        assert Touching([CUBE, other], *pose, angle=1e-6, level=1e-6).count == 0


def test_too_little_room_is_said():
    both = Touching([CUBE, FLOOR], [[0, 0, 0.5 + GAP], [0, 0, 0]], [UPRIGHT, UPRIGHT], room=3)
    assert both.count == FULL
    both.contacts = new_contacts(4)
    assert both.again() == 4


def test_a_meshed_ball_touches_a_plane_with_one_corner():
    ball = sphere(4)
    R = turn([1, 2, 3], 0.3)
    height = -(ball[0] @ R.T)[:, 2].min() + GAP
    both = Touching([UP, ball], [[0, 0, 0], [0.3, 0.1, height]], [UPRIGHT, R])
    assert both.count == 1
    np.testing.assert_allclose(both.column("normal"), [UP], atol=ROUNDING)


@pytest.mark.parametrize("seed", range(4))
def test_bodies_that_touch_anyhow_always_have_a_contact_at_their_least_gap(seed):
    """Random attitudes, moved together along a line until the gap is GAP: edges and corners in general position."""
    rng = np.random.default_rng(seed)
    forms = [(torus(8), ell()), (ell(), ell()), (centred_cube(), sphere(1)), (sphere(2), torus(12))][seed]
    both = Touching(forms, np.zeros((2, 3)), [UPRIGHT, UPRIGHT])
    witness, touched = np.array([-1, -1]), 0
    for _ in range(40):
        both.R[:] = turn(rng.normal(size=3), rng.uniform(0, 3)), turn(rng.normal(size=3), rng.uniform(0, 3))
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        travel = 20.0
        for _ in range(200):  # steps as long as the gap never pass a contact
            both.x[1] = travel * way
            gap = gap_of_pair(both.solids, 0, 1, both.x, both.R, np.inf, witness, both.work)
            if gap < 2 * GAP:
                break
            travel -= gap - GAP
        if gap >= 2 * GAP:  # through the hole of the ring
            continue
        touched += 1
        both.count = both.again()
        assert both.count >= 1
        assert both.column("gap").min() == pytest.approx(gap, rel=1e-5)
        feet = both.points + both.column("gap")[:, None] * both.column("normal")
        np.testing.assert_allclose(feet, both.column("arm_b") + both.x[1] - both.x[0], atol=1e-12)
    assert touched > 20


def test_the_gap_from_a_plane_is_that_of_the_lowest_corner(rng):
    both = Touching([UP, sphere(3)], [[0, 0, -1.0], [0, 0, 2.0]], [UPRIGHT, UPRIGHT])
    for _ in range(20):
        both.R[:] = turn(rng.normal(size=3), 1.0), turn(rng.normal(size=3), 2.0)
        both.x[:] = rng.normal(size=(2, 3))
        heights = (both.solids.meshes.vertices @ both.R[1].T + both.x[1] - both.x[0]) @ both.R[0, :, 2]
        for limit, exact in ((np.inf, True), (heights.min() - 0.1, False)):
            gap = gap_of_pair(both.solids, 0, 1, both.x, both.R, limit, np.array([-1, -1]), both.work)
            assert gap >= min(limit, heights.min()) - ROUNDING
            assert gap <= heights.min() + ROUNDING
            assert not exact or abs(gap - heights.min()) < ROUNDING


def test_planes_never_meet():
    both = Touching([UP, -UP], [[0, 0, 0], [0, 0, 1.0]], [UPRIGHT, UPRIGHT])
    assert both.count == 0
    assert gap_of_pair(both.solids, 0, 1, both.x, both.R, np.inf, np.array([-1, -1]), both.work) == np.inf
