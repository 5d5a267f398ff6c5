"""Rows of contact of two meshes, or of a mesh and a plane, on their way: see `contact_motion`."""

from math import inf
from typing import NamedTuple

from comotion_server.kernels.contact_overlap import crossing, foot
from comotion_server.kernels.contacts import CORNER_FACE, CROSSING_A, EDGES, FACE_CORNER, POINTS
from comotion_server.kernels.flat_contact import ON_FEATURE, smaller_size
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import follow
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.vectors import (
    ZERO,
    add,
    along,
    cross,
    cross_exactly,
    dot,
    length,
    rotated,
    rotated_back,
    row,
    scaled,
    sub,
    unit,
)

KEPT = 2.0  # times how far outside a feature points are found: how far outside they stay

Vector = tuple[float, float, float]


class Geometry(NamedTuple):
    """A contact in world axes, from the centre of a."""

    n: Vector  # unit, from a to b
    turning: Vector  # its rate of change [1/s]
    p: Vector  # on a [m]
    q: Vector  # on b [m]
    margin: float  # how far inside its features it lies [m]


class Pair(NamedTuple):
    """Two bodies at one time, world."""

    a: int
    b: int
    offset: Vector  # of the centre of b from that of a [m]
    velocity: Vector  # likewise [m/s]
    spin_a: Vector  # [rad/s]
    spin_b: Vector


@lean_jit
def _of_a(m, pair, R, v):
    """Vertex v of body a."""
    return rotated(R[pair.a], row(m.vertices, v))


@lean_jit
def _of_b(m, pair, R, v):
    """Vertex v of body b."""
    return add(rotated(R[pair.b], row(m.vertices, v)), pair.offset)


@lean_jit
def _face(solids, body, R, t):
    """(outward unit normal in the world, a point of the face in the body's axes) of triangle t, or of the plane."""
    if solids.kind[body] == PLANE:
        return rotated(R[body], row(solids.normal, body)), ZERO
    m = solids.meshes
    return rotated(R[body], row(m.normals, t)), row(m.vertices, m.triangles[t, 0])


@lean_jit
def _corner_on_face(solids, contacts, i, pair, R):
    """A corner of a on a face of b, which it may cross from triangle to triangle."""
    m, b = solids.meshes, pair.b
    p, t, margin = _of_a(m, pair, R, contacts.feature[i, 0]), contacts.feature[i, 2], inf
    if t >= 0:
        t, margin = follow(m, t, rotated_back(R[b], sub(p, pair.offset)))
        contacts.feature[i, 2] = t
    face, point = _face(solids, b, R, t)
    n = scaled(face, -1.0)
    q = foot(p, n, n, add(rotated(R[b], point), pair.offset))
    return Geometry(n, cross(pair.spin_b, n), p, q, margin)


@lean_jit
def _face_under_corner(solids, contacts, i, pair, R):
    """The same the other way round."""
    m, a = solids.meshes, pair.a
    q, t, margin = _of_b(m, pair, R, contacts.feature[i, 2]), contacts.feature[i, 0], inf
    if t >= 0:
        t, margin = follow(m, t, rotated_back(R[a], q))
        contacts.feature[i, 0] = t
    n, point = _face(solids, a, R, t)
    return Geometry(n, cross(pair.spin_a, n), foot(q, n, n, rotated(R[a], point)), q, margin)


@lean_jit
def _from_ends(s, u):
    """Distance [m] of the point at s in [0, 1] of an edge u from its nearer end, negative outside."""
    return min(s, 1.0 - s) * length(u)


@lean_jit
def _two_edges(solids, contacts, i, pair, R):
    """Two edges with the normal of both; where they cross in a face, it points as that of the face does.

    Bodies that lie flat on each other may tilt either way, and one edge goes on touching the other whichever it is.
    """
    m, kind, f = solids.meshes, contacts.kind[i], contacts.feature[i]
    a0, b0 = _of_a(m, pair, R, f[0]), _of_b(m, pair, R, f[2])
    u, v = sub(_of_a(m, pair, R, f[1]), a0), sub(_of_b(m, pair, R, f[3]), b0)
    product = cross_exactly(u, v)
    n = unit(product)
    turning = add(cross(cross(pair.spin_a, u), v), cross(u, cross(pair.spin_b, v)))
    if kind != EDGES:
        body, sign = (pair.a, 1.0) if kind == CROSSING_A else (pair.b, -1.0)
        face, _ = _face(solids, body, R, f[4])
        sign = sign if dot(n, face) > 0.0 else -sign
        n, turning = scaled(n, sign), scaled(turning, sign)
    turning = scaled(along(turning, -dot(n, turning), n), 1.0 / length(product))
    s, t, _ = crossing(a0, u, b0, v, n)
    p, q, margin = along(a0, s, u), along(b0, t, v), min(_from_ends(s, u), _from_ends(t, v))
    return Geometry(n, turning, p, q, margin)


@lean_jit
def _two_points(solids, contacts, i, pair, R):
    """A corner against a corner, or against an edge."""
    m, f = solids.meshes, contacts.feature[i]
    p, q, margin, e, spin = _of_a(m, pair, R, f[0]), _of_b(m, pair, R, f[2]), inf, ZERO, ZERO
    if f[3] >= 0:
        u, spin = sub(_of_b(m, pair, R, f[3]), q), pair.spin_b
        s, e = dot(u, sub(p, q)) / dot(u, u), unit(u)
        q, margin = along(q, s, u), _from_ends(s, u)
    elif f[1] >= 0:
        u, spin = sub(_of_a(m, pair, R, f[1]), p), pair.spin_a
        s, e = dot(u, sub(q, p)) / dot(u, u), unit(u)
        p, margin = along(p, s, u), _from_ends(s, u)
    d = sub(q, p)
    n, gap = unit(d), length(d)
    velocity = _relative_velocity(pair, p, q)
    across = along(along(velocity, -dot(n, velocity), n), -dot(e, velocity), e)
    turning = along(scaled(across, 1.0 / gap if gap > 0.0 else 0.0), -dot(cross(spin, e), n), e)
    return Geometry(n, turning, p, q, margin)


@lean_jit
def _relative_velocity(pair, p, q):
    """Velocity of the point q of b against the point p of a."""
    return sub(add(pair.velocity, cross(pair.spin_b, sub(q, pair.offset))), cross(pair.spin_a, p))


@lean_jit
def refresh_flat(solids, contacts, i, x, v, R, w):
    """`refresh` of a row of two meshes, or of a mesh and a plane."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    pair = Pair(a, b, sub(row(x, b), row(x, a)), sub(row(v, b), row(v, a)), row(w, a), row(w, b))
    kind = contacts.kind[i]
    if kind == CORNER_FACE:
        found = _corner_on_face(solids, contacts, i, pair, R)
    elif kind == FACE_CORNER:
        found = _face_under_corner(solids, contacts, i, pair, R)
    elif kind == POINTS:
        found = _two_points(solids, contacts, i, pair, R)
    else:
        found = _two_edges(solids, contacts, i, pair, R)
    n, turning, arm_b = found.n, found.turning, sub(found.q, pair.offset)
    gap, velocity = dot(n, sub(found.q, found.p)), _relative_velocity(pair, found.p, found.q)
    inward_a = cross(pair.spin_a, cross(pair.spin_a, found.p))
    inward_b = cross(pair.spin_b, cross(pair.spin_b, arm_b))
    bias = dot(n, sub(inward_b, inward_a)) + 2.0 * dot(turning, velocity) - gap * dot(turning, turning)
    contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i], contacts.gap[i] = n, found.p, arm_b, gap
    return found.margin + KEPT * ON_FEATURE * smaller_size(solids, a, b), dot(n, velocity), bias
