"""Contact points of cylinders at any pose and velocity, against differences of gaps written down anew."""

import numpy as np
import pytest
from contact_forms import extruded
from moving_forms import FIRST, SECOND, Flight, line_gap, unit

from comotion_server.kernels.body_parts import (
    AHEAD,
    BACK,
    BALL,
    BETWEEN,
    CORNER,
    EDGE,
    END,
    GROUND,
    MIDDLE,
    PARTS_OF_A_TURN,
    RIM,
    TIP,
)
from comotion_server.kernels.contacts import PARTS, new_contacts
from comotion_server.kernels.cylinder_contact import refresh_parts
from comotion_server.kernels.solids import CAPSULE, CYLINDER, HALF_LENGTH, MESH, PLANE, RADIUS, Solids
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mesh_store import MeshStore

R, HALF = 0.3, 0.7
STEP, SHORT = 0.002, 0.0005  # the second where curves are near each other, and their normal turns fast
# Central differences of eighth order: rounding leaves some 1e-15 / step and 1e-15 / step^2.
ALLOWED = 2e-11, 2e-8
NORMAL = unit(np.array([0.3, -0.5, 0.8]))
MESH_FORM = extruded([(-1, -0.8), (1.2, -1), (0.9, 1.1), (-0.7, 0.6)], 1.3)
SIGNS = np.array([1.0, -1.0])


def solids_of(*kinds):
    """`Solids` of two bodies among MESH, PLANE, CAPSULE and CYLINDER (about x)."""
    m = MeshStore.build([TriangleMesh(*MESH_FORM)]).arrays
    kind, size, axis = np.array(kinds), np.zeros((2, 4)), np.tile([1.0, 0.0, 0.0], (2, 1))
    size[:, RADIUS], size[:, HALF_LENGTH] = R, HALF
    shape, radius = np.where(kind == MESH, 0, -1), np.where(kind == PLANE, np.inf, 2.0)
    core = np.where(kind == CAPSULE, HALF, np.hypot(R, HALF))
    near, normal = np.full(2, np.inf), np.tile(NORMAL, (2, 1))
    return Solids(m, kind, shape, normal, radius, near, size, axis, core, np.ones(1, dtype=bool))


def axis_points(flight):
    """Both ends of the middle line as functions of time."""
    return [lambda t, s=s: flight.point(np.array([s * HALF, 0.0, 0.0]), t) for s in SIGNS]


def rim(flight, end):
    """A point of a rim as a function of time and angle."""

    def point(t, angle):
        return flight.point(np.array([SIGNS[end] * HALF, R * np.cos(angle), R * np.sin(angle)]), t)

    return point


def plane_gap(point, flight, body_point, normal):
    """Height of a moving point over a moving plane."""

    def height(t):
        origin = flight.point(body_point, t)
        return (point(t) - origin) @ (flight.point(body_point + normal, t) - origin)

    return height


def newton_step(f, at, h=1e-3):
    """From `at` (k,) towards a stationary point of f, by differences."""
    eye = np.eye(len(at)) * h
    slope = [(8 * (f(at + e) - f(at - e)) - (f(at + 2 * e) - f(at - 2 * e))) / (12 * h) for e in eye]
    curve = [[(f(at + e + g) - f(at + e - g) - f(at - e + g) + f(at - e - g)) / (4 * h * h) for g in eye] for e in eye]
    return -np.linalg.solve(curve, slope)


def stationary(distance, start):
    """The distance at its stationary point near `start` (k,), a function of time."""

    def value(t):
        at, step = np.array(start, dtype=float), np.ones(1)
        while np.abs(step).max() > 1e-9:
            step = newton_step(lambda point: distance(t, point), at)
            at = at + step
        return distance(t, at)

    return value


def lowest(point, flight, normal):
    """Least height of a rim over a plane, from three of its points: the heights of a circle are c + A sin."""

    def height(t):
        h = [plane_gap(at_angle(point, a), flight, np.zeros(3), normal)(t) for a in (0, np.pi / 2, np.pi)]
        middle = 0.5 * (h[0] + h[2])
        return middle - np.hypot(h[0] - middle, h[1] - middle)

    return height


def check(solids, contacts, flights, distance, radii=0.0, h=STEP):
    """Gap, opening and bias of row 0 against differences; whether slow enough for them."""
    state = [np.array([getattr(f, name) for f in flights]) for name in ("x", "v", "R", "w")]
    _, opening, bias = refresh_parts(solids, contacts, 0, *state)
    a, b = flights
    n, arm_a, arm_b = (getattr(contacts, name)[0] for name in ("normal", "arm_a", "arm_b"))
    acceleration = b.a + np.cross(b.alpha, arm_b) - a.a - np.cross(a.alpha, arm_a)
    gaps = np.array([distance(k * h) - radii for k in range(-4, 5)])
    slope, curve = FIRST @ gaps / h, SECOND @ gaps / h**2
    steep = 1.0 + abs(curve) ** 0.5
    assert abs(abs(contacts.gap[0]) - abs(gaps[4])) < 1e-12 * steep
    np.testing.assert_allclose(b.x + arm_b - a.x - arm_a, contacts.gap[0] * n, atol=1e-12 * steep**2)
    if steep * h >= 0.02:  # else too fast for these differences
        return False
    sign = np.sign(contacts.gap[0] * gaps[4])
    assert abs(sign * opening - slope) < ALLOWED[0] * steep**2
    assert abs(sign * (n @ acceleration + bias) - curve) < ALLOWED[1] * steep**2
    return True


def at_random(rng, apart=(2, 1, -1)):
    return Flight(rng, [0, 0, 0]), Flight(rng, apart)


def set_row(contacts, swapped, one, other, which=0):
    features = (*other, *one, which) if swapped else (*one, *other, which)
    contacts.bodies[0], contacts.kind[0], contacts.feature[0] = (0, 1), PARTS, features


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("part", [TIP, RIM])
def test_on_a_plane(part, swapped, rng):
    solids, contacts = solids_of(*((CYLINDER, PLANE) if swapped else (PLANE, CYLINDER))), new_contacts(1)
    for end in (0, 1) * 20:
        flights = at_random(rng)
        plane, body = flights[::-1] if swapped else flights
        angle = rng.integers(PARTS_OF_A_TURN)
        set_row(contacts, swapped, (GROUND, -1), (part, end + 2 * angle if part == TIP else end))
        if part == RIM:
            distance = lowest(rim(body, end), plane, NORMAL)
        else:
            distance = plane_gap(at_angle(rim(body, end), tip_angle(angle)), plane, np.zeros(3), NORMAL)
        check(solids, contacts, flights, distance)


def at_angle(curve, angle):
    """A point of a curve as a function of time."""
    return lambda t: curve(t, angle)


def tip_angle(number):
    """The angle of a tip as `rim` has it: tips of a cylinder about x are counted from -z towards +y."""
    turned = 2.0 * np.pi * number / PARTS_OF_A_TURN
    e = np.array([0.0, 0.0, -1.0])
    at = np.cos(turned) * e + np.sin(turned) * np.cross([1.0, 0.0, 0.0], e)
    return np.arctan2(at[2], at[1])


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("part", [END, RIM, MIDDLE])
def test_a_ball(part, swapped, rng):
    kinds = (CYLINDER, CAPSULE)
    solids, contacts, seen = solids_of(*(kinds[::-1] if swapped else kinds)), new_contacts(1), 0
    for end in (0, 1) * 20:
        flights = at_random(rng)
        body, other = flights[::-1] if swapped else flights
        ball = axis_points(other)[1 - end]
        set_row(contacts, swapped, (part, end), (BALL, 1 - end))
        if part == END:
            up = np.array([SIGNS[end], 0.0, 0.0])
            distance, radii = plane_gap(ball, body, HALF * up, up), R
        elif part == MIDDLE:
            distance, radii = line_gap(ball, *axis_points(body)), 2.0 * R
        else:
            distance, radii = circle_gap(ball, body, end), R
        if distance(0.0) > 0.3 if part != END else True:
            seen += check(solids, contacts, flights, distance, radii)
    assert seen > 15


def circle_gap(point, flight, end):
    """Distance of a moving point from a rim."""

    def distance(t):
        origin, at = flight.point(np.zeros(3), t), point(t)
        u = flight.point(np.array([1.0, 0.0, 0.0]), t) - origin
        z = u @ (at - origin)
        return np.hypot(z - SIGNS[end] * HALF, np.linalg.norm(at - origin - z * u) - R)

    return distance


def brought_near(body, other, one, curve, s, far, rng):
    """Moves `other` so that its curve at s is `far` from a point of the rim `one`: the rim's angle, or None.

    None where the curves are nearly parallel, or the rim is not nearest there.
    """
    angle, h = rng.uniform(0.0, 2.0 * np.pi), 1e-6
    u, v = unit(one(0.0, angle + h) - one(0.0, angle - h)), unit(curve(0.0, s + h) - curve(0.0, s - h))
    n = np.cross(u, v)
    up = body.R @ [1.0, 0.0, 0.0]
    out = np.cross(u, up)
    n, sine = unit(n) * np.sign(n @ (up + out)), np.linalg.norm(n)
    if sine < 0.5 or n @ up < 0.1 or n @ out < 0.1:
        return None
    other.x = other.x + one(0.0, angle) + far * n - curve(0.0, s)
    return angle


def check_curves(solids, contacts, flights, swapped, curve, radii, rng):
    """Checks row 0, of a rim and another curve that are near each other; whether it is where they are."""
    body, other = flights[::-1] if swapped else flights
    one, s = rim(body, 0), rng.uniform(-0.5, 0.5)
    angle = brought_near(body, other, one, curve(other), s, radii + 0.1, rng)
    if angle is None:
        return False
    state = [np.array([getattr(f, name) for f in flights]) for name in ("x", "v", "R", "w")]
    refresh_parts(solids, contacts, 0, *state)
    arm = contacts.arm_b[0] if swapped else contacts.arm_a[0]
    if np.linalg.norm(body.x + arm - one(0.0, angle)) > 1e-6:
        return False
    distance = stationary(lambda t, at: np.linalg.norm(curve(other)(t, at[1]) - one(t, at[0])), (angle, s))
    return check(solids, contacts, flights, distance, radii, SHORT)


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("line", [MIDDLE, EDGE])
def test_rim_and_line(line, swapped, rng):
    kinds = (CYLINDER, CAPSULE if line == MIDDLE else MESH)
    solids, contacts, seen = solids_of(*(kinds[::-1] if swapped else kinds)), new_contacts(1), set()
    p, q = solids.meshes.vertices[solids.meshes.triangles[0, :2]] if line == EDGE else np.array([[0, 0, 0], [1, 0, 0]])
    curve = lambda flight: lambda t, s: flight.point(0.5 * (p + q) + s * unit(q - p), t)
    for which in (AHEAD, BACK, BETWEEN) * 40:
        set_row(contacts, swapped, (RIM, 0), (line, 0), which)
        if check_curves(solids, contacts, at_random(rng), swapped, curve, R if line == MIDDLE else 0.0, rng):
            seen.add(which)
    assert len(seen) == 3


def test_rim_and_rim(rng):
    solids, contacts, seen = solids_of(CYLINDER, CYLINDER), new_contacts(1), set()
    for which in (AHEAD, BACK, BETWEEN) * 40:
        set_row(contacts, 0, (RIM, 0), (RIM, 1), which)
        if check_curves(solids, contacts, at_random(rng), 0, lambda flight: rim(flight, 1), 0.0, rng):
            seen.add(which)
    assert len(seen) == 3


def corner(solids, flight, v):
    """A vertex of a mesh as a function of time."""
    return lambda t: flight.point(solids.meshes.vertices[v], t)


def lines_gap(p, q, c, d):
    """Distance of two moving lines."""
    return lambda t: abs(unit(np.cross(q(t) - p(t), d(t) - c(t))) @ (c(t) - p(t)))


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("part", [CORNER, EDGE, MIDDLE])
def test_the_side(part, swapped, rng):
    kinds = (CYLINDER, CYLINDER if part == MIDDLE else MESH)
    solids, contacts, seen = solids_of(*(kinds[::-1] if swapped else kinds)), new_contacts(1), 0
    for _ in range(40):
        flights = at_random(rng)
        body, other = flights[::-1] if swapped else flights
        set_row(contacts, swapped, (MIDDLE, 0), (part, 0))
        ends = [corner(solids, other, v) for v in solids.meshes.triangles[0, :2]]
        if part == CORNER:
            distance = line_gap(corner(solids, other, 0), *axis_points(body))
        else:
            distance = lines_gap(*axis_points(body), *(axis_points(other) if part == MIDDLE else ends))
        if distance(0.0) > 0.3:
            seen += check(solids, contacts, flights, distance, 2.0 * R if part == MIDDLE else R)
    assert seen > 15


@pytest.mark.parametrize("swapped", [False, True])
def test_a_corner_on_a_face(swapped, rng):
    solids, contacts = solids_of(*((MESH, CYLINDER) if swapped else (CYLINDER, MESH))), new_contacts(1)
    up = np.array([-1.0, 0.0, 0.0])
    for v in range(8):
        flights = at_random(rng)
        body, other = flights[::-1] if swapped else flights
        set_row(contacts, swapped, (END, 1), (CORNER, v))
        check(solids, contacts, flights, plane_gap(corner(solids, other, v), body, HALF * up, up))
