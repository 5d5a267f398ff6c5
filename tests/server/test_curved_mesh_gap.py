"""Meshes against curved shapes: convex ones proven by weak duality, pipes by points all over the triangles."""

import mpmath as mp
import numpy as np
import pytest
from curved_truth import CAPSULE, CYLINDER, DIGITS, PIPE, PLANE, SPHERE, Posed, dot, outside, reach, to_pipe, vector
from meshes_by_hand import torus
from scipy.spatial.transform import Rotation

from comotion_server.kernels.curved_mesh_gap import curved_mesh_gap
from comotion_server.kernels.mesh_pair import STACK
from comotion_server.meshes import TriangleMesh, box
from comotion_server.meshes.mesh_store import MeshStore

ROUNDING = 1e-14  # of the size of what is measured
SIZES = {
    PLANE: (0.0, 0.0, 0.0, 0.0),
    SPHERE: (0.5, 0.0, 0.0, 0.0),
    CAPSULE: (0.3, 0.7, 0.0, 0.0),
    CYLINDER: (0.4, 0.6, 0.0, 0.0),
}
OPEN, CLOSED = (0.8, 1.0, 1.2, 0.0), (0.8, 1.0, 1.2, 1.0)
Z, ORIGIN, NO_TURN = (0.0, 0.0, 1.0), np.zeros(3), np.eye(3)


def stored(*meshes):
    return MeshStore.build(meshes).arrays


def ask(arrays, x, R, other, *, mesh=0, limit=np.inf, witness=-1):
    room = np.empty(STACK, np.int64), np.empty(STACK)
    distance, p, q, n, triangle = curved_mesh_gap(arrays, mesh, x, R, *other.arguments, limit, witness, *room)
    return distance, np.array(p), np.array(q), np.array(n), triangle


def at_random(rng, kind, spread, size=None):
    x, R = spread * rng.normal(size=3), Rotation.random(random_state=rng).as_matrix()
    return Posed(kind, size or SIZES[kind], Z, x, R)


def single_triangle(rng):
    return TriangleMesh(rng.normal(size=(3, 3)), np.array([[0, 1, 2]], dtype=np.uint32))


def placed(mesh, x, R):
    """The corners in arithmetic of 50 digits."""
    turn = mp.matrix([[mp.mpf(float(c)) for c in row] for row in R])
    return [turn * vector(v) + vector(x) for v in mesh.vertices]


def assert_convex_proven(mesh, x, R, other):
    """A convex mesh: its corners, and the direction, show the distance."""
    distance, p, q, n, _ = ask(stored(mesh), x, R, other)
    if distance <= 0.0:
        return False
    with mp.workdps(DIGITS):
        direction = -other.u if other.kind == PLANE else vector(n) / mp.norm(vector(n))
        far = max(dot(direction, v) for v in placed(mesh, x, R))
        lower = dot(direction, vector(other.x)) - reach(other, -direction) - far
        upper = mp.norm(vector(q) - vector(p)) + outside(other, q)
    rounding = ROUNDING * (np.linalg.norm(other.x - x) + mesh.size + sum(other.size))
    assert float(lower) >= distance - rounding
    assert abs(float(upper) - distance) <= rounding
    return True


@pytest.mark.parametrize("kind", SIZES)
def test_a_triangle_and_a_box(kind):
    rng, apart = np.random.default_rng(kind), 0
    while apart < 30:
        R = Rotation.random(random_state=rng).as_matrix()
        mesh = single_triangle(rng) if apart % 2 else box([1.0, 0.4, 2.0])
        apart += assert_convex_proven(mesh, 0.1 * rng.normal(size=3), R, at_random(rng, kind, 2.0))


@pytest.mark.parametrize("kind", SIZES)
@pytest.mark.parametrize("x", [(0.0, 0.0, 3.0), (1.3, 0.0, 0.0), (1.3, 0.9, 0.0), (1.3, 0.9, 2.0)])
def test_level_with_a_box(kind, x):
    for R in (NO_TURN, Rotation.from_euler("y", 90, degrees=True).as_matrix()):
        other = Posed(kind, SIZES[kind], Z, np.array([*x[:2], -x[2]] if kind == PLANE else x), R)
        assert_convex_proven(box([1.0, 0.4, 2.0]), ORIGIN, NO_TURN, other)


@pytest.mark.parametrize("kind", [*SIZES, PIPE])
def test_the_walk_finds_the_least_of_all_triangles(kind):
    rng, mesh = np.random.default_rng(kind), torus(14, 9)
    single = stored(*(TriangleMesh(mesh.vertices[t], np.array([[0, 1, 2]], np.uint32)) for t in mesh.triangles))
    arrays = stored(mesh)
    for turn in range(8):
        other = at_random(rng, kind, 2.0, OPEN if kind == PIPE else None)
        truth = min(ask(single, ORIGIN, NO_TURN, other, mesh=k)[0] for k in range(len(mesh.triangles)))
        found = ask(arrays, ORIGIN, NO_TURN, other)
        assert found[0] == pytest.approx(truth, abs=ROUNDING * 10)
        assert ask(arrays, ORIGIN, NO_TURN, other, witness=turn)[0] == found[0]
        short = ask(arrays, ORIGIN, NO_TURN, other, limit=0.5 * abs(found[0]))[0]
        assert min(0.5 * abs(found[0]), found[0]) <= short <= found[0]


def test_what_passes_through_a_triangle_overlaps():
    flat = TriangleMesh(np.array([[-3.0, -3, 0], [3, -3, 0], [0, 4, 0]]), np.array([[0, 1, 2]], np.uint32))
    arrays, on_x = stored(flat), Rotation.from_euler("y", 90, degrees=True).as_matrix()
    for kind, size in [*list(SIZES.items())[1:], (PIPE, OPEN), (PIPE, CLOSED)]:
        for R in (NO_TURN, on_x, Rotation.from_euler("xy", [30, 50], degrees=True).as_matrix()):
            assert ask(arrays, ORIGIN, NO_TURN, Posed(kind, size, Z, np.array([0.0, 0.1, 0.1]), R))[0] <= 0.0


def points_of(mesh, fine):
    weights = [(i / fine, j / fine) for i in range(fine + 1) for j in range(fine + 1 - i)]
    corners = mesh.vertices[mesh.triangles]
    return np.array([a + s * (b - a) + t * (c - a) for a, b, c in corners for s, t in weights])


def nearest_to_pipe(pipe, points):
    """The distances of many points from the rectangles that a pipe turns about its axis, in double precision."""
    inner, outer, half, caps = pipe.size
    P, u = points - pipe.x, pipe.R @ np.array(pipe.axis)
    z = P @ u
    rho = np.linalg.norm(P - np.outer(z, u), axis=1)
    beyond = np.maximum(np.abs(z) - half, 0.0)
    wall = np.hypot(np.maximum(np.maximum(inner - rho, rho - outer), 0.0), beyond)
    ends = np.hypot(np.maximum(rho - outer, 0.0), np.abs(np.abs(z) - half)) if caps else np.inf
    return np.minimum(wall, ends)


@pytest.mark.parametrize("size", [OPEN, CLOSED], ids=["open", "closed"])
@pytest.mark.parametrize("scale", [0.3, 1.0])
def test_triangles_and_boxes_about_a_pipe(size, scale):
    rng, apart, fine = np.random.default_rng(7), 0, 40
    while apart < 25:
        pipe = at_random(rng, PIPE, 0.7 if scale < 1.0 else 1.5, size)
        mesh = single_triangle(rng) if apart % 2 else box([1.0, 0.4, 2.0])
        mesh = TriangleMesh(scale * mesh.vertices, mesh.triangles)
        distance, p, q, n, _ = ask(stored(mesh), ORIGIN, NO_TURN, pipe)
        if distance <= 0.0:
            continue
        apart += 1
        sampled = nearest_to_pipe(pipe, points_of(mesh, fine))
        assert sampled.min() >= distance - ROUNDING * 10  # nothing is nearer ...
        assert sampled.min() <= distance + 3.0 * scale / fine  # ... and all is about as near as the grid is fine
        with mp.workdps(DIGITS):
            assert float(to_pipe(pipe, vector(p) - vector(pipe.x))) == pytest.approx(distance, abs=ROUNDING * 10)
        assert np.allclose(q - p, distance * n, atol=ROUNDING * 10)


def test_scaled_by_a_power_of_two_everything_scales_bit_by_bit():
    rng, mesh = np.random.default_rng(8), torus(7, 5)
    for kind, size in [*SIZES.items(), (PIPE, OPEN), (PIPE, CLOSED)]:
        for s in (2.0**-20, 2.0**13):
            other = at_random(rng, kind, 2.0, size)
            large = Posed(kind, (*(s * v for v in size[:3]), size[3]), Z, s * other.x, other.R)
            one = ask(stored(mesh), ORIGIN, NO_TURN, other)
            two = ask(stored(TriangleMesh(s * mesh.vertices, mesh.triangles)), ORIGIN, NO_TURN, large)
            assert [s * one[0], *(s * one[1]), *(s * one[2]), *one[3]] == [two[0], *two[1], *two[2], *two[3]]
