"""Contact points of balls and capsules at any pose and velocity, against differences of gaps written down anew."""

import numpy as np
import pytest
from contact_forms import extruded, turn
from moving_forms import FIRST, SECOND, Flight, line_gap, unit

from comotion_server.kernels.contact_motion import refresh
from comotion_server.kernels.contacts import (
    BALL_CORNER,
    BALL_EDGE,
    BALL_FACE,
    CORES,
    LINE_CORNER,
    LINE_EDGE,
    new_contacts,
)
from comotion_server.kernels.solids import CAPSULE, HALF_LENGTH, MESH, PLANE, RADIUS, Solids
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mesh_store import MeshStore

R, HALF = 0.3, 0.7
STEP = 0.002
# Central differences of eighth order: rounding leaves some 1e-15 / step and 1e-15 / step^2.
ALLOWED = 2e-11, 2e-8
NORMAL = unit(np.array([0.3, -0.5, 0.8]))
MESH_FORM = extruded([(-1, -0.8), (1.2, -1), (0.9, 1.1), (-0.7, 0.6)], 1.3)


def solids_of(*kinds):
    """`Solids` of two bodies among MESH, PLANE and CAPSULE (about x)."""
    m = MeshStore.build([TriangleMesh(*MESH_FORM)]).arrays
    kind, size, axis = np.array(kinds), np.zeros((2, 4)), np.tile([1.0, 0.0, 0.0], (2, 1))
    size[:, RADIUS], size[:, HALF_LENGTH] = R, HALF
    shape, radius = np.where(kind == MESH, 0, -1), np.where(kind == PLANE, np.inf, 2.0)
    core = np.where(kind == CAPSULE, HALF, 0.0)
    return Solids(m, kind, shape, np.tile(NORMAL, (2, 1)), radius, np.full(2, np.inf), size, axis, core)


def ends(flight):
    return [lambda t, s=s: flight.point(np.array([s * HALF, 0.0, 0.0]), t) for s in (1.0, -1.0)]


def lines_gap(p0, p1, q0, q1):
    """Distance of two moving lines."""
    return lambda t: abs(unit(np.cross(p1(t) - p0(t), q1(t) - q0(t))) @ (q0(t) - p0(t)))


def ground_gap(kind, m, ground, balls, ball, rng):
    """(features, distance as a function of time) of a random feature of the ground."""
    corner = lambda v: lambda t: ground.point(m.vertices[v], t)
    v, w = rng.permutation(8)[:2]
    if kind == BALL_FACE:
        f = rng.integers(12)
        n = m.normals[f]
        height = lambda t: (
            (balls[ball](t) - corner(m.triangles[f][0])(t)) @ (ground.point(n, t) - ground.point(0 * n, t))
        )
        return (ball, f, -1, -1, -1), lambda t: abs(height(t))
    if kind == BALL_CORNER:
        return (ball, v, -1, -1, -1), lambda t: np.linalg.norm(balls[ball](t) - corner(v)(t))
    if kind == BALL_EDGE:
        return (ball, v, w, 0, 1), line_gap(balls[ball], corner(v), corner(w))
    if kind == LINE_CORNER:
        return (-1, v, -1, -1, -1), line_gap(corner(v), *balls)
    return (-1, v, w, 0, 1), lines_gap(*balls, corner(v), corner(w))


def core_gap(one, other, flights):
    """The distance of balls or middle lines of two capsules as a function of time."""
    a, b = ends(flights[0]), ends(flights[1])
    if one < 0 and other < 0:
        return lines_gap(*a, *b)
    if one < 0:
        return line_gap(b[other], *a)
    if other < 0:
        return line_gap(a[one], *b)
    return lambda t: np.linalg.norm(b[other](t) - a[one](t))


def check(solids, contacts, flights, distance, radii):
    """Gap, opening and bias of row 0 against differences; whether slow enough for them."""
    state = [np.array([getattr(f, name) for f in flights]) for name in ("x", "v", "R", "w")]
    _, opening, bias = refresh(solids, contacts, 0, *state)
    a, b = flights
    n, arm_a, arm_b = (getattr(contacts, name)[0] for name in ("normal", "arm_a", "arm_b"))
    acceleration = b.a + np.cross(b.alpha, arm_b) - a.a - np.cross(a.alpha, arm_a)
    gaps = np.array([distance(k * STEP) - radii for k in range(-4, 5)])
    slope, curve = FIRST @ gaps / STEP, SECOND @ gaps / STEP**2
    steep = 1.0 + abs(curve) ** 0.5
    assert abs(contacts.gap[0] - gaps[4]) < 1e-12 * steep
    np.testing.assert_allclose(b.x + arm_b - a.x - arm_a, gaps[4] * n, atol=1e-12 * steep**2)
    if steep * STEP >= 0.02:  # else too fast for these differences
        return False
    assert abs(opening - slope) < ALLOWED[0] * steep**2
    assert abs(n @ acceleration + bias - curve) < ALLOWED[1] * steep**2
    return True


@pytest.mark.parametrize("ground_is_a", [True, False])
@pytest.mark.parametrize("kind", [BALL_FACE, BALL_EDGE, BALL_CORNER, LINE_EDGE, LINE_CORNER])
def test_on_a_mesh(kind, ground_is_a, rng):
    solids, contacts, seen = solids_of(*((MESH, CAPSULE) if ground_is_a else (CAPSULE, MESH))), new_contacts(1), 0
    for _ in range(60):
        flights = Flight(rng, [0, 0, 0]), Flight(rng, [2, 1, -1])
        ground, body = flights if ground_is_a else flights[::-1]
        ball = int(rng.integers(2))
        feature, distance = ground_gap(kind, solids.meshes, ground, ends(body), ball, rng)
        contacts.bodies[0], contacts.kind[0], contacts.feature[0] = (0, 1), kind, feature
        if distance(0.0) > 0.3:
            seen += check(solids, contacts, flights, distance, R)
    assert seen > 20


def test_on_a_plane(rng):
    solids, contacts = solids_of(CAPSULE, PLANE), new_contacts(1)
    for ball in (0, 1) * 20:
        flights = Flight(rng, [2, 1, -1]), Flight(rng, [0, 0, 0])
        contacts.bodies[0], contacts.kind[0], contacts.feature[0] = (0, 1), BALL_FACE, (ball, -1, -1, -1, -1)
        plane = flights[1]
        far = (ends(flights[0])[ball](0.0) - plane.x) @ (plane.R @ NORMAL)
        if far <= 0.1:
            continue

        def distance(t, flights=flights, ball=ball):
            origin = flights[1].point(np.zeros(3), t)
            return (ends(flights[0])[ball](t) - origin) @ (flights[1].point(NORMAL, t) - origin)

        check(solids, contacts, flights, distance, R)


@pytest.mark.parametrize(("one", "other"), [(0, 1), (-1, 0), (1, -1), (-1, -1)])
def test_on_each_other(one, other, rng):
    solids, contacts, seen = solids_of(CAPSULE, CAPSULE), new_contacts(1), 0
    for _ in range(60):
        flights = Flight(rng, [0, 0, 0]), Flight(rng, [2, 1, -1])
        contacts.bodies[0], contacts.kind[0], contacts.feature[0] = (0, 1), CORES, (one, other, -1, -1, -1)
        distance = core_gap(one, other, flights)
        if distance(0.0) > 0.3:
            seen += check(solids, contacts, flights, distance, 2.0 * R)
    assert seen > 20


def test_turned_capsules_have_their_ends_where_the_test_has_them():
    flight = Flight(np.random.default_rng(1), [0, 0, 0])
    flight.x, flight.R = np.zeros(3), turn([0, 0, 1], np.pi / 2)
    np.testing.assert_allclose([end(0.0) for end in ends(flight)], [[0, HALF, 0], [0, -HALF, 0]], atol=1e-15)
