"""Points at which a ball of a body touches a mesh or a plane, and their motion (docs/shapes.md, 5).

A sphere is one ball, a capsule has one at either end. The ball's centre is a point of its body, and all is told of its
distance from a feature of the other body, the *ground*; the gap is the radius less. Legend: D from the ground's centre
to the ball's, V its velocity against the ground's point below it, world; n from the ground to the ball.
"""

from math import inf
from typing import NamedTuple

from comotion_server.kernels.contacts import BALL_CORNER, BALL_EDGE, BALL_FACE
from comotion_server.kernels.curved_mesh_gap import box_bound, curved_mesh_gap
from comotion_server.kernels.curved_triangles import triangle_gap
from comotion_server.kernels.features import FACE, VERTEX, feature_at
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import follow, is_level, is_top_corner, is_top_edge, neighbour
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.solids import CAPSULE, HALF_LENGTH, MESH, PLANE, RADIUS, SPHERE
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

FULL = -1
SAME = 1e-7  # of the smaller body's size: points nearer than this are one
OUTSIDE = 2e-9  # of the same: how far outside a feature a point stays on it

Vector = tuple[float, float, float]


class Stand(NamedTuple):
    """A ball on a feature of the ground, world."""

    n: Vector  # unit, from the ground to the ball
    turning: Vector  # its rate of change [1/s]
    foot: Vector  # from the ground's centre [m]
    far: float  # from there to the ball's centre [m]
    margin: float  # how far inside the feature [m]


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
def _room(solids, a, b):
    """How far outside a feature a point still lies on it [m]."""
    return OUTSIDE * 2.0 * min(solids.radius[a], solids.radius[b])


@lean_jit
def _in_cone(m, v, w, n, far):
    """How far [m] a ball at `far` from the vertex v moves along the way to w until that way is nearer."""
    return -far * dot(n, unit(sub(row(m.vertices, w), row(m.vertices, v))))


@lean_jit
def _on_corner(m, v, C):
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
def _on_edge(m, v, w, t, other, C):
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
def _stand(solids, contacts, i, ground, R, spin, D, V_at, room):
    """`Stand` of row i; V_at: velocity of the ball's centre against the ground's, which turns with `spin`."""
    kind, f = contacts.kind[i], contacts.feature[i]
    if kind == BALL_FACE:
        margin, n, far = inf, ZERO, 0.0
        if f[1] < 0:
            n = rotated(R[ground], row(solids.normal, ground))
            far = dot(n, D)
        else:
            m, C = solids.meshes, rotated_back(R[ground], D)
            far = dot(row(m.normals, f[1]), sub(C, row(m.vertices, m.triangles[f[1], 0])))
            f[1], margin = follow(m, f[1], along(C, -far, row(m.normals, f[1])))
            n = rotated(R[ground], row(m.normals, f[1]))
        return Stand(n, cross(spin, n), along(D, -far, n), far, margin + room)
    m, C = solids.meshes, rotated_back(R[ground], D)
    if kind == BALL_EDGE:
        n, foot, far, margin, e = _on_edge(m, f[1], f[2], f[3], f[4], C)
        e = rotated(R[ground], e)
    else:
        n, foot, far, margin = _on_corner(m, f[1], C)
        e = ZERO
    n, foot = rotated(R[ground], n), rotated(R[ground], foot)
    V = sub(V_at, cross(spin, foot))
    across = along(along(V, -dot(n, V), n), -dot(e, V), e)
    turning = along(scaled(across, 1.0 / far if far > 0.0 else 0.0), -dot(cross(spin, e), n), e)
    return Stand(n, turning, foot, far, margin + room)


@lean_jit
def _write(contacts, i, ground_b, arm, n, foot, far, r):
    """Normal, arms and gap of row i."""
    ball = along(arm, -r, n)
    if ground_b:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = scaled(n, -1.0), ball, foot
    else:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = n, foot, ball
    contacts.gap[i] = far - r


@lean_jit
def refresh_ball(solids, contacts, i, x, v, R, w):
    """`refresh` of a row of a ball on a face, edge or corner."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    ground_b = ground_is_b(solids, b)
    ball, ground = (a, b) if ground_b else (b, a)
    arm, spin, turn = arm_of(solids, R, ball, contacts.feature[i, 0]), row(w, ground), row(w, ball)
    D = add(sub(row(x, ball), row(x, ground)), arm)
    velocity = add(sub(row(v, ball), row(v, ground)), cross(turn, arm))
    at = _stand(solids, contacts, i, ground, R, spin, D, velocity, _room(solids, a, b))
    _write(contacts, i, ground_b, arm, at.n, at.foot, at.far, solids.size[ball, RADIUS])
    V = sub(velocity, cross(spin, at.foot))
    inward = sub(cross(turn, cross(turn, arm)), cross(spin, cross(spin, at.foot)))
    bias = dot(at.n, inward) + 2.0 * dot(at.turning, V) - at.far * dot(at.turning, at.turning)
    return at.margin, dot(at.n, V), bias


@lean_jit
def _add_plane(solids, a, b, x, R, reach, contacts, first):
    """`manifold` of balls and a plane."""
    ground_b = ground_is_b(solids, b)
    body, ground = (a, b) if ground_b else (b, a)
    n, count = rotated(R[ground], row(solids.normal, ground)), 0
    for ball in range(balls_of(solids, body)):
        arm, r = arm_of(solids, R, body, ball), solids.size[body, RADIUS]
        D = add(sub(row(x, body), row(x, ground)), arm)
        far = dot(n, D)
        if far - r > reach:
            continue
        i = first + count
        if i >= len(contacts.gap):
            return FULL
        contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.kind[i] = a, b, BALL_FACE
        contacts.feature[i, :] = -1
        contacts.feature[i, 0] = ball
        _write(contacts, i, ground_b, arm, n, along(D, -far, n), far, r)
        count += 1
    return count


@lean_jit
def _is_met(contacts, first, count, ground_b, p, close):
    """Whether a point of the ground [m], from its centre, world, is one of the rows already."""
    arms = contacts.arm_b if ground_b else contacts.arm_a
    for i in range(first, first + count):
        d = sub(row(arms, i), p)
        if dot(d, d) <= close * close:
            return True
    return False


@lean_jit
def _note(solids, a, b, ball, arm, R, C, t, P, n, nearest, contacts, first, count):
    """Write the row of a ball at C over the point P of triangle t, if it is a contact of its own: count, or FULL.

    C, P and n, unit, from P to the ball: in the frame of the ground. The nearest point of all is one in any case.
    """
    ground_b = ground_is_b(solids, b)
    body, ground = (a, b) if ground_b else (b, a)
    m, r = solids.meshes, solids.size[body, RADIUS]
    feature, k = feature_at(m, solids.shape[ground], t, P)
    v, w = m.triangles[t, k], m.triangles[t, (k + 1) % 3]
    level = feature == FACE or is_level(row(m.normals, t), n, FLAT)
    if not (level or nearest):
        if not (is_top_corner(m, v, n, FLAT) if feature == VERTEX else is_top_edge(m, t, k, n, FLAT)):
            return count
    i, f = first + count, (t, -1, -1, -1)
    if level:
        kind, n = BALL_FACE, row(m.normals, t)
        far = dot(n, sub(C, row(m.vertices, m.triangles[t, 0])))
        P = along(C, -far, n)
    elif feature == VERTEX:
        kind, f = BALL_CORNER, (v, -1, -1, -1)
        n, P, far, _ = _on_corner(m, v, C)
    else:
        kind, f = BALL_EDGE, (v, w, t, neighbour(m, t, k))
        n, P, far, _, _ = _on_edge(m, v, w, t, f[3], C)
    foot = rotated(R[ground], P)
    if _is_met(contacts, first, count, ground_b, foot, SAME * 2.0 * min(solids.radius[a], solids.radius[b])):
        return count
    if i >= len(contacts.gap):
        return FULL
    contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.kind[i] = a, b, kind
    contacts.feature[i, 0], contacts.feature[i, 1] = ball, f[0]
    contacts.feature[i, 2], contacts.feature[i, 3], contacts.feature[i, 4] = f[1], f[2], f[3]
    _write(contacts, i, ground_b, arm, rotated(R[ground], n), foot, far, r)
    return count + 1


@lean_jit
def ball_manifold(solids, a, b, x, R, reach, contacts, first, work):
    """`manifold` of a sphere and a mesh, or a capsule and a plane: how many rows, or FULL.

    On a mesh: the nearest point, and every other one within reach at which the surface is a local top.
    """
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        return _add_plane(solids, a, b, x, R, reach, contacts, first)
    body, ground = (a, b) if ground_is_b(solids, b) else (b, a)
    m, size, nodes, gaps = solids.meshes, solids.size[body], work.walk[0][:, 0], work.walk[1]
    D, u, shape = sub(row(x, body), row(x, ground)), row(solids.axis, body), solids.shape[ground]
    C = rotated_back(R[ground], D)
    gap, _, _, _, t = curved_mesh_gap(
        m, shape, ZERO, R[ground], SPHERE, size, u, D, R[body], 2.0 * reach, -1, nodes, gaps
    )
    if not gap <= reach:
        return 0
    p, q, s = corners(m, t)
    _, P, n = triangle_gap(SPHERE, size, u, sub(p, C), sub(q, C), sub(s, C))
    n = scaled(n, -1.0)
    count = _note(solids, a, b, 0, ZERO, R, C, t, add(C, P), n, True, contacts, first, 0)
    top = 1
    nodes[0] = m.root[shape]
    while top > 0 and count >= 0:
        top -= 1
        node = nodes[top]
        if box_bound(m, node, SPHERE, size, u, C) > reach:
            continue
        if m.child[node] >= 0:
            nodes[top], nodes[top + 1] = m.child[node], m.child[node] + 1
            top += 2
            continue
        for k in range(m.first[node], m.first[node] + m.entries[node]):
            t = m.leaf_triangles[k]
            p, q, s = corners(m, t)
            far, P, n = triangle_gap(SPHERE, size, u, sub(p, C), sub(q, C), sub(s, C))
            if far <= reach and count >= 0:
                n = scaled(n, -1.0)
                count = _note(solids, a, b, 0, ZERO, R, C, t, add(C, P), n, False, contacts, first, count)
    return count
