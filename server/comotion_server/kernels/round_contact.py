"""Points at which a sphere or capsule touches a mesh or a plane, and their motion (docs/shapes.md, 5).

Balls touch faces, edges and corners; the middle line of a capsule touches edges that it crosses and corners below it.
These are all corners of what the bodies share, as with meshes. D: centre of the body from that of the ground, world.
"""

from math import inf

from comotion_server.kernels.ball_contact import (
    arm_of,
    balls_of,
    feature_below,
    ground_is_b,
    stand_of_ball,
)
from comotion_server.kernels.contacts import BALL_FACE, FULL, LINE_CORNER, LINE_EDGE
from comotion_server.kernels.curved_mesh_gap import box_bound
from comotion_server.kernels.curved_triangles import triangle_gap
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import is_top_corner, is_top_edge, neighbour
from comotion_server.kernels.line_contact import is_along, stand_of_line
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.solids import CAPSULE, HALF_LENGTH, PLANE, RADIUS
from comotion_server.kernels.topology import FLAT
from comotion_server.kernels.vectors import (
    ZERO,
    add,
    along,
    cross,
    dot,
    rotated,
    rotated_back,
    row,
    scaled,
    sub,
)

SAME = 1e-7  # of the smaller body's size: points nearer than this are one
FOUND = 1e-9  # of the same: how far outside a feature a point is still found on it; it stays up to twice that
LINE = -1  # instead of a ball


@lean_jit
def small_size(solids, a, b):
    """Diameter of the smaller body [m]."""
    return 2.0 * min(solids.radius[a], solids.radius[b])


@lean_jit
def _stand(solids, contacts, i, body, ground, R, D, velocity, spin, turn):
    """`Stand` of row i."""
    if contacts.kind[i] >= LINE_EDGE:
        return stand_of_line(solids, contacts, i, body, ground, R, D, velocity, spin, turn)
    return stand_of_ball(solids, contacts, i, body, ground, R, D, velocity, spin, turn)


@lean_jit
def _write(contacts, i, ground_b, at, r):
    """Normal, arms and gap of row i."""
    arm = along(at.arm, -r, at.n)
    if ground_b:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = scaled(at.n, -1.0), arm, at.foot
    else:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = at.n, at.foot, arm
    contacts.gap[i] = at.far - r


@lean_jit
def refresh_round(solids, contacts, i, x, v, R, w):
    """`refresh` of a row of a sphere or capsule on a mesh or a plane."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    ground_b = ground_is_b(solids, b)
    body, ground = (a, b) if ground_b else (b, a)
    D, velocity = sub(row(x, body), row(x, ground)), sub(row(v, body), row(v, ground))
    spin, turn = row(w, ground), row(w, body)
    at = _stand(solids, contacts, i, body, ground, R, D, velocity, spin, turn)
    _write(contacts, i, ground_b, at, solids.size[body, RADIUS])
    V = sub(add(velocity, cross(turn, at.arm)), cross(spin, at.foot))
    inward = sub(cross(turn, cross(turn, at.arm)), cross(spin, cross(spin, at.foot)))
    bias = dot(at.n, inward) + 2.0 * dot(at.turning, V) - at.far * dot(at.turning, at.turning)
    return at.margin + 2.0 * FOUND * small_size(solids, a, b), dot(at.n, V), bias


@lean_jit
def _rise(solids, R, body, ball, n):
    """Sine of the angle by which a ball is the higher end of its capsule along n; 0 for a sphere."""
    if solids.kind[body] != CAPSULE:
        return 0.0
    return dot(n, arm_of(solids, R, body, ball)) / solids.size[body, HALF_LENGTH]


@lean_jit
def _add(solids, contacts, first, count, a, b, x, R, ball, kind, f):
    """A row, to be kept by who raises the count; its `Stand`."""
    i, ground_b = first + count, ground_is_b(solids, b)
    body, ground = (a, b) if ground_b else (b, a)
    contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.kind[i] = a, b, kind
    contacts.feature[i, 0], contacts.feature[i, 1] = ball, f[0]
    contacts.feature[i, 2], contacts.feature[i, 3], contacts.feature[i, 4] = f[1], f[2], f[3]
    D = sub(row(x, body), row(x, ground))
    at = _stand(solids, contacts, i, body, ground, R, D, ZERO, ZERO, ZERO)
    _write(contacts, i, ground_b, at, solids.size[body, RADIUS])
    return at


@lean_jit
def _on_plane(solids, a, b, x, R, reach, angle, level, contacts, first):
    """`manifold` of a capsule and a plane."""
    body, count = a if ground_is_b(solids, b) else b, 0
    for ball in range(balls_of(solids, body)):
        if first + count >= len(contacts.gap):
            return FULL
        at = _add(solids, contacts, first, count, a, b, x, R, ball, BALL_FACE, (-1, -1, -1, -1))
        is_level = abs(_rise(solids, R, body, ball, at.n)) <= angle
        count += 1 if contacts.gap[first + count] <= (level if is_level else reach) else 0
    return count


@lean_jit
def _is_new(contacts, first, count, ground_b, close):
    """Whether the point of the row after `count` rows is none of theirs."""
    arms = contacts.arm_b if ground_b else contacts.arm_a
    p = row(arms, first + count)
    for i in range(first, first + count):
        d = sub(row(arms, i), p)
        if dot(d, d) <= close * close:
            return False
    return True


@lean_jit
def _add_balls(solids, a, b, x, R, t, limits, forced, contacts, first, count):
    """Rows of balls over triangle t: count, or FULL. limits: (reach, angle, level); forced: 1: tops or not."""
    ground_b, size = ground_is_b(solids, b), small_size(solids, a, b)
    body, ground = (a, b) if ground_b else (b, a)
    m, r, (reach, angle, level), D = solids.meshes, solids.size[body, RADIUS], limits, sub(row(x, body), row(x, ground))
    for ball in range(balls_of(solids, body)):
        C = rotated_back(R[ground], add(D, arm_of(solids, R, body, ball)))
        far, kind, f, margin = feature_below(m, t, C, r, FOUND * size)
        if far > max(reach, level) or (forced == 0 and margin < -FOUND * size):
            continue
        if first + count >= len(contacts.gap):
            return FULL
        at = _add(solids, contacts, first, count, a, b, x, R, ball, kind, f)
        rise = _rise(solids, R, body, ball, at.n)
        limit = level if 0.0 < abs(rise) <= angle else reach
        if contacts.gap[first + count] <= limit and (forced == 1 or rise <= max(angle, FLAT)):
            count += 1 if _is_new(contacts, first, count, ground_b, SAME * size) else 0
    return count


@lean_jit
def _add_lines(solids, a, b, x, R, t, limits, forced, contacts, first, count):
    """Rows of a capsule's middle line over the edges and corners of triangle t, likewise."""
    ground_b, size = ground_is_b(solids, b), small_size(solids, a, b)
    body, ground = (a, b) if ground_b else (b, a)
    m, (reach, angle, level) = solids.meshes, limits
    slope, limit = max(angle, FLAT), max(reach, level)
    for k in range(6):
        e = k % 3
        v, w = m.triangles[t, e], m.triangles[t, (e + 1) % 3]
        is_edge = k < 3
        if is_edge and (m.sharp[t, e] == 0 or is_along(solids, body, ground, R, v, w)):
            continue
        if not is_edge and m.sharp[t, e] == 0 and m.sharp[t, (e + 2) % 3] == 0:
            continue
        if first + count >= len(contacts.gap):
            return FULL
        kind, f = (LINE_EDGE, (v, w, t, neighbour(m, t, e))) if is_edge else (LINE_CORNER, (v, -1, -1, -1))
        at = _add(solids, contacts, first, count, a, b, x, R, LINE, kind, f)
        if at.margin < -FOUND * size or contacts.gap[first + count] > (limit if angle > 0.0 else reach):
            continue
        n = rotated_back(R[ground], at.n)
        is_top = is_top_edge(m, t, e, n, slope) if is_edge else is_top_corner(m, v, n, slope)
        if (is_top or forced == 1) and _is_new(contacts, first, count, ground_b, SAME * size):
            count += 1
    return count


@lean_jit
def _add_triangle(solids, a, b, x, R, t, limits, forced, contacts, first, count):
    """All rows over triangle t: count, or FULL."""
    count = _add_balls(solids, a, b, x, R, t, limits, forced, contacts, first, count)
    if count < 0 or (solids.kind[a] != CAPSULE and solids.kind[b] != CAPSULE):
        return count
    return _add_lines(solids, a, b, x, R, t, limits, forced, contacts, first, count)


@lean_jit
def round_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of a sphere or capsule and a mesh, or a capsule and a plane: how many rows, or FULL.

    On a mesh: every point within reach at which both bodies are local tops; if there is none, those nearest.
    """
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        return _on_plane(solids, a, b, x, R, reach, angle, level, contacts, first)
    body, ground = (a, b) if ground_is_b(solids, b) else (b, a)
    m, size, kind, nodes = solids.meshes, solids.size[body], solids.kind[body], work.walk[0][:, 0]
    limit = max(reach, level) if angle > 0.0 and kind == CAPSULE else reach
    limits = (reach, angle, limit)
    D, shape = sub(row(x, body), row(x, ground)), solids.shape[ground]
    C = rotated_back(R[ground], D)
    u = rotated_back(R[ground], rotated(R[body], row(solids.axis, body)))
    nearest, least, count, top = -1, inf, 0, 1
    nodes[0] = m.root[shape]
    while top > 0 and count >= 0:
        top -= 1
        node = nodes[top]
        if box_bound(m, node, kind, size, u, C) > limit:
            continue
        if m.child[node] >= 0:
            nodes[top], nodes[top + 1] = m.child[node], m.child[node] + 1
            top += 2
            continue
        for k in range(m.first[node], m.first[node] + m.entries[node]):
            t = m.leaf_triangles[k]
            p, q, s = corners(m, t)
            far = triangle_gap(kind, size, u, sub(p, C), sub(q, C), sub(s, C))[0]
            if far < least:
                nearest, least = t, far
            if far <= limit and count >= 0:
                count = _add_triangle(solids, a, b, x, R, t, limits, 0, contacts, first, count)
    if count == 0 and least <= reach:
        count = _add_triangle(solids, a, b, x, R, nearest, (reach, 0.0, reach), 1, contacts, first, 0)
    return count
