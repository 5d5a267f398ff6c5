"""A ball of a body on a face, edge or corner of the other one (docs/shapes.md, 5).

A sphere is one ball, a capsule has one at either end. The ball's centre is a point of its body, and all is told of its
distance from a feature of the other body, the *ground*; the gap is the radius less. Legend: D from the ground's centre
to the ball's, V its velocity against the ground's point below it, world; n from the ground to the ball; C the ball's
centre in the ground's frame.
"""

from math import inf
from typing import NamedTuple

from comotion_server.kernels.contacts import BALL_CORNER, BALL_EDGE, BALL_FACE
from comotion_server.kernels.curved_triangles import triangle_gap
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import follow, is_level, neighbour
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.solids import CAPSULE, HALF_LENGTH, MESH, PLANE, SPHERE
from comotion_server.kernels.topology import FLAT
from comotion_server.kernels.vectors import (
    ZERO,
    add,
    along,
    cross,
    dot,
    length,
    rotated,
    rotated_back,
    row,
    scaled,
    sub,
    unit,
)

Vector = tuple[float, float, float]


class Stand(NamedTuple):
    """A ball or line of a body on a feature of the ground, world."""

    n: Vector  # unit, from the ground to the body
    turning: Vector  # its rate of change [1/s]
    arm: Vector  # from the body's centre to the point of the ball or line [m]
    foot: Vector  # from the ground's centre [m]
    far: float  # from there to that point [m]
    margin: float  # how far inside the feature, and the ball or line [m]


@lean_jit
def balls_of(solids, i):
    """How many balls body i stands on."""
    return 2 if solids.kind[i] == CAPSULE else 1


@lean_jit
def arm_of(solids, R, i, ball):
    """From the centre of body i to that of one of its balls [m], world."""
    if solids.kind[i] != CAPSULE:
        return ZERO
    half = solids.size[i, HALF_LENGTH]
    return scaled(rotated(R[i], row(solids.axis, i)), half if ball == 0 else -half)


@lean_jit
def ground_is_b(solids, b):
    """Whether b is the mesh or plane of a pair."""
    return solids.kind[b] == MESH or solids.kind[b] == PLANE


@lean_jit
def _in_cone(m, v, w, n, far):
    """How far [m] a ball at `far` from the vertex v moves along the way to w until that way is nearer."""
    return -far * dot(n, unit(sub(row(m.vertices, w), row(m.vertices, v))))


@lean_jit
def on_corner(m, v, C):
    """(n, foot, far, margin) of a ball at C on a corner; body frame."""
    foot = row(m.vertices, v)
    d = sub(C, foot)
    far, n, margin = length(d), unit(d), inf
    for i in range(m.star_start[v], m.star_start[v + 1]):
        for k in range(3):
            w = m.triangles[m.star[i], k]
            if w != v:
                margin = min(margin, _in_cone(m, v, w, n, far))
    return n, foot, far, margin


@lean_jit
def on_edge(m, v, w, t, other, C):
    """The same on the edge from v to w of triangles t and `other`; also the edge, unit."""
    p, q = row(m.vertices, v), row(m.vertices, w)
    e = unit(sub(q, p))
    s = dot(e, sub(C, p))
    foot = along(p, s, e)
    d = sub(C, foot)
    far, n, margin = length(d), unit(d), min(s, length(sub(q, p)) - s)
    for face in (t, other):
        for k in range(3):
            u = m.triangles[face, k] if face >= 0 else v
            if u != v and u != w:
                way = sub(row(m.vertices, u), p)
                margin = min(margin, -far * dot(n, unit(along(way, -dot(way, e), e))))
    return n, foot, far, margin, e


@lean_jit
def _turning(n, V, spin, e, far):
    """Rate of change of the direction n between points that move by V, square to an edge e that turns with `spin`."""
    across = along(along(V, -dot(n, V), n), -dot(e, V), e)
    return along(scaled(across, 1.0 / far if far > 0.0 else 0.0), -dot(cross(spin, e), n), e)


@lean_jit
def stand_of_ball(solids, contacts, i, body, ground, R, D, velocity, spin, turn):
    """`Stand` of row i.

    D, velocity: centre of the body from and against that of the ground; spin, turn: angular velocities of ground and
    body. The row goes on to the triangle that it is over.
    """
    kind, f, m = contacts.kind[i], contacts.feature[i], solids.meshes
    arm = arm_of(solids, R, body, f[0])
    D, V, margin, e = add(D, arm), add(velocity, cross(turn, arm)), inf, ZERO
    if kind == BALL_FACE and f[1] < 0:
        n = rotated(R[ground], row(solids.normal, ground))
        far = dot(n, D)
        return Stand(n, cross(spin, n), arm, along(D, -far, n), far, inf)
    C = rotated_back(R[ground], D)
    if kind == BALL_FACE:
        far = dot(row(m.normals, f[1]), sub(C, row(m.vertices, m.triangles[f[1], 0])))
        f[1], margin = follow(m, f[1], along(C, -far, row(m.normals, f[1])))
        n = scaled(rotated(R[ground], row(m.normals, f[1])), 1.0 if far >= 0.0 else -1.0)
        far = abs(far)
        return Stand(n, cross(spin, n), arm, along(D, -far, n), far, margin)
    if kind == BALL_EDGE:
        n, foot, far, margin, e = on_edge(m, f[1], f[2], f[3], f[4], C)
        e = rotated(R[ground], e)
    else:
        n, foot, far, margin = on_corner(m, f[1], C)
    n, foot = rotated(R[ground], n), rotated(R[ground], foot)
    if solids.kind[body] == CAPSULE:  # beyond the end of its line
        margin = min(margin, -dot(n, arm) * far / solids.size[body, HALF_LENGTH])
    return Stand(n, _turning(n, sub(V, cross(spin, foot)), spin, e, far), arm, foot, far, margin)


@lean_jit
def _nearest_edge(m, t, P):
    """The corner of triangle t from which the edge starts that is nearest to the point P."""
    best, found = inf, 0
    for k in range(3):
        p = row(m.vertices, m.triangles[t, k])
        e = sub(row(m.vertices, m.triangles[t, (k + 1) % 3]), p)
        w, square = sub(P, p), dot(e, e)
        s = min(max(dot(w, e) / square, 0.0), 1.0) if square > 0.0 else 0.0
        d = along(w, -s, e)
        if dot(d, d) < best:
            best, found = dot(d, d), k
    return found


@lean_jit
def feature_below(m, t, C, r, close):
    """(distance of a ball at C from triangle t, kind of what it is over, its features, margin [m]).

    Features are found up to `close` [m] outside: each one where its own margin says that nothing beside it is nearer.
    """
    a, b, c = corners(m, t)
    far, P, _ = triangle_gap(SPHERE, (r, 0.0, 0.0, 0.0), ZERO, sub(a, C), sub(b, C), sub(c, C))
    P, N = add(C, P), row(m.normals, t)
    n, height = unit(sub(C, P)), dot(N, sub(C, a))
    if is_level(N, n, FLAT) or is_level(scaled(N, -1.0), n, FLAT):
        over, margin = follow(m, t, along(C, -height, N))
        if margin >= -close:
            return far, BALL_FACE, (over, -1, -1, -1), margin
    k = _nearest_edge(m, t, P)
    v, w = m.triangles[t, k], m.triangles[t, (k + 1) % 3]
    for corner in (v, w):
        d = sub(P, row(m.vertices, corner))
        if dot(d, d) <= close * close:
            return far, BALL_CORNER, (corner, -1, -1, -1), on_corner(m, corner, C)[3]
    other = neighbour(m, t, k)
    return far, BALL_EDGE, (v, w, t, other), on_edge(m, v, w, t, other, C)[3]
