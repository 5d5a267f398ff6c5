"""Contact points at other poses and velocities, against differences of gaps that are written down anew."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from contact_forms import GAP, UPRIGHT, Touching, centred_cube, ell, extruded, slab, solids_of, turn
from moving_forms import FIRST, SECOND, Flight, line_gap, unit

from comotion_server.kernels.contact_motion import refresh
from comotion_server.kernels.contacts import (
    CORNER_FACE,
    CROSSING_A,
    CROSSING_B,
    EDGES,
    FACE_CORNER,
    POINTS,
    new_contacts,
)
from comotion_server.kernels.flat_contact import ON_FEATURE
from comotion_server.kernels.flat_motion import KEPT

# Central differences of eighth order, with rates about 1. The directions of two edges or points change faster than
# those of faces, so their steps are shorter; what rounding then leaves is 1e-15 / step^k.
STEPS = {CORNER_FACE: 0.01, FACE_CORNER: 0.01, CROSSING_A: 0.002, CROSSING_B: 0.002, EDGES: 0.002, POINTS: 0.002}
ALLOWED = {0.01: (1e-12, 1e-9), 0.002: (1e-11, 1e-8)}  # for first and second derivatives of size 1
ROUNDING = 1e-12

UP = np.array([0.0, 0.0, 1.0])
MESHES = [
    extruded([(-1, -0.8), (1.2, -1), (0.9, 1.1), (-0.7, 0.6)], 1.3),
    extruded([(0, 0), (1, 0.2), (0.3, 0.9)], 0.7),
]


def face_gap(face, outward, point):
    """Height of a point over the plane of three moving points, on the side of `outward`."""

    def gap(t):
        a, b, c = (corner(t) for corner in face)
        n = unit(np.cross(b - a, c - a))
        return (n @ (point(t) - a)) * np.sign(n @ outward)

    return gap


def edges_gap(a0, a1, b0, b1):
    """Distance of two moving lines, positive along edge of a x edge of b."""
    return lambda t: unit(np.cross(a1(t) - a0(t), b1(t) - b0(t))) @ (b0(t) - a0(t))


class Case:
    """Any features of two meshes in any pose: a row of contacts, and its gap as a function of time."""

    def __init__(self, kind, rng):
        self.solids, self.contacts = solids_of(MESHES), new_contacts(1)
        self.flights = Flight(rng, [0, 0, 0]), Flight(rng, [2, 1, -1])
        m = self.solids.meshes
        edge_a, edge_b = rng.permutation(8)[:2], 8 + rng.permutation(6)[:2]
        face_a, face_b = rng.integers(12), 12 + rng.integers(8)
        self.feature, self.gap = {
            CORNER_FACE: lambda: self.over_face(1, face_b, 0, edge_a[0], (edge_a[0], -1, face_b, -1, -1)),
            FACE_CORNER: lambda: self.over_face(0, face_a, 1, edge_b[0], (face_a, -1, edge_b[0], -1, -1)),
            EDGES: lambda: ((*edge_a, *edge_b, -1), edges_gap(*self.pair(0, edge_a), *self.pair(1, edge_b))),
            CROSSING_A: lambda: self.crossing(0, m.triangles[face_a][:2], face_a, edge_b),
            CROSSING_B: lambda: self.crossing(1, m.triangles[face_b][:2], face_b, edge_a),
            POINTS: lambda: self.points(rng.integers(3), edge_a, edge_b),
        }[kind]()
        self.contacts.bodies[0], self.contacts.kind[0], self.contacts.feature[0] = (0, 1), kind, self.feature

    def moving(self, body, body_point):
        return lambda t: self.flights[body].point(body_point, t)

    def vertex(self, body, v):
        return self.moving(body, self.solids.meshes.vertices[v])

    def pair(self, body, edge):
        return self.vertex(body, edge[0]), self.vertex(body, edge[1])

    def outward(self, body, face):
        return self.flights[body].R @ self.solids.meshes.normals[face]

    def over_face(self, body, face, other, v, feature):
        corners = [self.vertex(body, c) for c in self.solids.meshes.triangles[face]]
        return feature, face_gap(corners, self.outward(body, face), self.vertex(other, v))

    def crossing(self, body, rim, face, edge):
        """Bodies that lie flat on each other tilt: the gap is that of the two edges, as the face's normal sees it."""
        ends = (*rim, *edge) if body == 0 else (*edge, *rim)
        (p0, p1), (q0, q1) = self.pair(0, ends[:2]), self.pair(1, ends[2:])
        along = np.cross(p1(0.0) - p0(0.0), q1(0.0) - q0(0.0)) @ self.outward(body, face)
        sign = np.sign(along) * (1.0 if body == 0 else -1.0)
        gap = edges_gap(p0, p1, q0, q1)
        return (*ends, face), lambda t: sign * gap(t)

    def points(self, which, edge_a, edge_b):
        if which == 0:
            p, q = self.vertex(0, edge_a[0]), self.vertex(1, edge_b[0])
            return (edge_a[0], -1, edge_b[0], -1, -1), lambda t: np.linalg.norm(q(t) - p(t))
        if which == 1:
            return (edge_a[0], -1, *edge_b, -1), line_gap(self.vertex(0, edge_a[0]), *self.pair(1, edge_b))
        return (*edge_a, edge_b[0], -1, -1), line_gap(self.vertex(1, edge_b[0]), *self.pair(0, edge_a))

    def refreshed(self):
        state = [np.array([getattr(f, name) for f in self.flights]) for name in ("x", "v", "R", "w")]
        return refresh(self.solids, self.contacts, 0, *state)


@pytest.mark.parametrize("kind", [CORNER_FACE, FACE_CORNER, EDGES, CROSSING_A, CROSSING_B, POINTS])
def test_gap_and_its_derivatives_are_those_of_the_moving_features(kind, rng):
    seen = 0
    for _ in range(60):
        case = Case(kind, rng)
        _, opening, bias = case.refreshed()
        a, b = case.flights
        n, arm_a, arm_b = (getattr(case.contacts, name)[0] for name in ("normal", "arm_a", "arm_b"))
        acceleration = b.a + np.cross(b.alpha, arm_b) - a.a - np.cross(a.alpha, arm_a)
        step = STEPS[kind]
        gaps = np.array([case.gap(k * step) for k in range(-4, 5)])
        slope, curve = FIRST @ gaps / step, SECOND @ gaps / step**2
        steep = 1.0 + abs(curve) ** 0.5  # nearly parallel edges turn fast
        assert abs(case.contacts.gap[0] - gaps[4]) < ROUNDING * steep
        assert abs(np.linalg.norm(n) - 1.0) < ROUNDING
        np.testing.assert_allclose(b.x + arm_b - a.x - arm_a, gaps[4] * n, atol=ROUNDING * steep**2)
        if steep * step < 0.04:  # else too fast for these differences
            seen += 1
            assert abs(opening - slope) < ALLOWED[step][0] * steep**2
            assert abs(n @ acceleration + bias - curve) < ALLOWED[step][1] * steep**2
    assert seen > 30


PLACED = {
    "cube on slab": ([slab(6), centred_cube()], [[0, 0, 0], [0.3, 0.2, 0.5 + GAP]], [UPRIGHT, turn(UP, 0.3)]),
    "cube over the border": ([slab(6), centred_cube()], [[0, 0, 0], [1.9, 0.2, 0.5 + GAP]], [UPRIGHT, turn(UP, 0.3)]),
    "cube on cube": ([centred_cube()] * 2, [[0, 0, 0], [0, 0, 1 + GAP]], [UPRIGHT, turn(UP, 0.3)]),
    "flush": ([centred_cube()] * 2, [[0, 0, 0], [0, 0, 1 + GAP]], [UPRIGHT, UPRIGHT]),
    "notch": ([ell(), ell()], [[0, 0, 0], [1 + GAP, 2 * GAP, 0.25]], [UPRIGHT, turn(UP, pi)]),
    "edges": (
        [centred_cube()] * 2,
        [[0.1, 0.2, sqrt(2) + GAP], [0, 0, 0]],
        [turn([1, 0, 0], pi / 4), turn([0, 1, 0], pi / 4)],
    ),
    "parallel edges": ([centred_cube()] * 2, [[0.3, 0, sqrt(2) + GAP], [0, 0, 0]], [turn([1, 0, 0], pi / 4)] * 2),
    "plane": ([UP, centred_cube()], [[0, 0, 0], [0.3, 0.2, 0.5 + GAP]], [UPRIGHT, turn(UP, 0.3)]),
    "cube on plane": ([centred_cube(), UP], [[0.3, 0.2, 0.5 + GAP], [0, 0, 0]], [turn(UP, 0.3), UPRIGHT]),
}


@pytest.mark.parametrize("name", PLACED)
def test_at_the_same_pose_a_row_stays_what_it_is(name):
    both = Touching(*PLACED[name])
    assert both.count > 0
    before = {field: both.column(field).copy() for field in ("normal", "arm_a", "arm_b", "gap", "feature")}
    zero = np.zeros((2, 3))
    for i in range(both.count):
        margin, opening, bias = refresh(both.solids, both.contacts, i, both.x, zero, both.R, zero)
        assert margin > 0.0
        assert (opening, bias) == (0.0, 0.0)
    for field, values in before.items():
        noise = 2e-6 if field == "normal" and name == "parallel edges" else ROUNDING
        np.testing.assert_allclose(both.column(field), values, atol=noise, err_msg=field)


def test_a_turn_of_the_whole_scene_turns_the_rows(rng):
    """Both bodies on one rigid motion: nothing opens, and bias balances the accelerations of that motion."""
    for name, placed in PLACED.items():
        both = Touching(*placed)
        spin, Q = rng.normal(size=3), turn(rng.normal(size=3), 1.0)
        normals = both.column("normal") @ Q.T
        x, R, w = both.x @ Q.T, np.array([Q @ r for r in both.R]), np.array([spin, spin])
        v = np.cross(w, x)
        for i in range(both.count):
            _, opening, bias = refresh(both.solids, both.contacts, i, x, v, R, w)
            n, arm_a, arm_b = both.contacts.normal[i], both.contacts.arm_a[i], both.contacts.arm_b[i]
            np.testing.assert_allclose(n, normals[i], atol=2e-6 if name == "parallel edges" else ROUNDING)
            assert abs(opening) < ROUNDING
            centres = np.cross(spin, v[1]) - np.cross(spin, v[0])  # of the motion; no angular acceleration
            assert abs(n @ centres + bias) < 20 * ROUNDING
            assert both.contacts.gap[i] == pytest.approx(np.linalg.norm(x[1] + arm_b - x[0] - arm_a), abs=1e-15)


def slide(both, i, moves):
    """Margins of row i with body b moved by each of `moves`."""
    zero, x = np.zeros((2, 3)), both.x.copy()
    for move in moves:
        both.x[1] = x[1] + move
        yield refresh(both.solids, both.contacts, i, both.x, zero, both.R, zero)[0]
    both.x[:] = x


def test_a_corner_keeps_its_face_across_triangles_until_the_border():
    both = Touching(*PLACED["cube on slab"])
    allowed = KEPT * ON_FEATURE * sqrt(3)
    for i in range(both.count):
        corner, start = both.points[i].copy(), both.contacts.feature[i, 0]
        moves = [(s, 0.0, 0.0) for s in np.linspace(0.0, 2.0, 401)]
        for (s, _, _), margin in zip(moves, slide(both, i, moves), strict=True):
            inside = 2.0 - corner[0] - s
            assert (margin > 0.0) == (inside > -allowed)
            if inside < 0.0:
                assert margin == pytest.approx(inside + allowed, abs=ROUNDING)
            np.testing.assert_array_equal(both.contacts.normal[i], UP)
        assert both.contacts.feature[i, 0] != start
        list(slide(both, i, [(s, 0, 0) for s in np.linspace(2.0, 0.0, 3)]))
        assert both.contacts.feature[i, 0] == start  # back where it was, over many triangles at once


@pytest.mark.parametrize("name", ["edges", "cube on cube", "parallel edges"])
def test_points_on_edges_have_the_distance_to_the_nearest_end_as_margin(name):
    both = Touching(*PLACED[name])
    allowed = KEPT * ON_FEATURE * sqrt(3)
    m = both.solids.meshes
    for i in range(both.count):
        f = both.contacts.feature[i]
        edges = [(f[k], f[k + 1], side) for side, k in enumerate((0, 2)) if f[k + 1] >= 0 and f[k] >= 0]
        for margin in slide(both, i, [(0.0, 0.0, 0.0), (0.03, 0.0, 0.0)]):
            expected = inf
            for start, end, side in edges:
                arm = (both.contacts.arm_a, both.contacts.arm_b)[side][i]
                ends = m.vertices[[start, end]] @ both.R[side].T
                expected = min(expected, *np.linalg.norm(ends - arm, axis=1))
            assert margin == pytest.approx(expected + allowed, abs=1e-9)


def test_a_plane_has_no_border():
    for name in ("plane", "cube on plane"):
        both = Touching(*PLACED[name])
        assert list(slide(both, 0, [(1e6, 1e6, 0.0)])) == [inf]
