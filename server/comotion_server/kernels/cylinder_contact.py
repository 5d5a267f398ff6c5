"""Rows of contact between a cylinder and any body that is no mesh, and the motion of all rows of cylinders.

Along the normal of the nearest points each body shows a part (docs/shapes.md, 5): a cylinder a face, its side or a
point of a rim, a capsule its middle line or a ball. Rows are the corners of what two such parts share; where a face
lies flat, points of its rim stand for it. D: centre of b from that of a, world.
"""

from math import atan2, inf, pi

from comotion_server.kernels.body_parts import (
    AHEAD,
    BACK,
    BALL,
    BETWEEN,
    CIRCLE,
    END,
    FACE,
    FREE,
    GROUND,
    LINE,
    MIDDLE,
    PARTS_OF_A_TURN,
    POINT,
    RIM,
    TIP,
    do_cross,
    from_rim,
    meeting,
    part_of,
)
from comotion_server.kernels.contacts import FULL, PARTS
from comotion_server.kernels.curved_points import part_across, some_perpendicular
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.level_faces import follow
from comotion_server.kernels.mixed_impact import round_gap
from comotion_server.kernels.part_motion import bias_of
from comotion_server.kernels.round_contact import FOUND, SAME, small_size
from comotion_server.kernels.solids import CAPSULE, CYLINDER, PLANE
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
)

TIPS = 16  # points of a rim that stand for a face
ALIKE = 0.9  # cosine between normals of one and the same row


@lean_jit
def _meet(solids, contacts, i, D, R):
    """(whether the first part is b's, both parts, their `Meeting`) of row i."""
    a, b, f = contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.feature[i]
    one, other = part_of(solids, R, a, ZERO, f[0], f[1]), part_of(solids, R, b, D, f[2], f[3])
    swapped = other.rank > one.rank
    if swapped:
        one, other = other, one
    return swapped, one, other, meeting(one, other, f[4])


@lean_jit
def _write(contacts, i, D, swapped, one, other, at):
    """Normal, arms and gap of row i."""
    p, q = along(at.p, one.radius, at.n), along(at.q, -other.radius, at.n)
    contacts.gap[i] = dot(at.n, sub(at.q, at.p)) - (one.radius + other.radius)
    if swapped:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = scaled(at.n, -1.0), q, sub(p, D)
    else:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = at.n, p, sub(q, D)


@lean_jit
def _on_face(solids, contacts, i, swapped, D, R, one, other, at):
    """How far [m] a point is inside the face that it is over; it goes on from triangle to triangle."""
    side, margin = 2 if swapped else 0, inf
    body, f = contacts.bodies[i, 1 if swapped else 0], contacts.feature[i]
    if other.axis != ZERO and (other.rank == CIRCLE or f[2 - side] == TIP):
        steep = length(cross(at.n, other.axis))
        margin = other.size * (2.0 * FLAT - steep if other.rank == POINT else steep - 0.5 * FLAT)
    if f[side] == END:
        return min(margin, one.size - length(part_across(sub(at.q, one.place), one.axis)))
    if f[side + 1] < 0:
        return margin
    centre = D if swapped else ZERO
    f[side + 1], inside = follow(solids.meshes, f[side + 1], rotated_back(R[body], sub(at.p, centre)))
    return min(margin, inside)


@lean_jit
def _within(part, p, n, bounded):
    """How far [m] inside a part the point p is; n: the normal out of its body; bounded: its normals are a cone."""
    if part.rank == LINE:
        return part.size - abs(dot(part.axis, sub(p, part.place)))
    if part.rank == CIRCLE and bounded:
        return from_rim(part, p, n)
    return inf


@lean_jit
def _margin(solids, contacts, i, swapped, D, R, one, other, at):
    """How far [m] inside both parts row i is."""
    if one.rank == FACE:
        return _on_face(solids, contacts, i, swapped, D, R, one, other, at)
    which = contacts.feature[i, 4]
    margin = _within(one, at.p, at.n, which == BETWEEN)
    return min(margin, _within(other, at.q, scaled(at.n, -1.0), which == BETWEEN))


@lean_jit
def refresh_parts(solids, contacts, i, x, v, R, w):
    """`refresh` of a row beside a cylinder."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    D, velocity, w_a, w_b = sub(row(x, b), row(x, a)), sub(row(v, b), row(v, a)), row(w, a), row(w, b)
    swapped, one, other, at = _meet(solids, contacts, i, D, R)
    _write(contacts, i, D, swapped, one, other, at)
    margin = _margin(solids, contacts, i, swapped, D, R, one, other, at)
    P, Q = (at.q, sub(at.p, D)) if swapped else (at.p, sub(at.q, D))
    V = sub(add(velocity, cross(w_b, Q)), cross(w_a, P))
    inward = sub(cross(w_b, cross(w_b, Q)), cross(w_a, cross(w_a, P)))
    if swapped:
        V, inward, w_a, w_b = scaled(V, -1.0), scaled(inward, -1.0), w_b, w_a
    bias = dot(at.n, inward) + bias_of(at, one.rank, V, w_a, w_b)
    return margin + 2.0 * FOUND * small_size(solids, a, b), dot(at.n, V), bias


@lean_jit
def try_row(solids, contacts, first, count, bodies, D, R, features):
    """(margin, normal out of a, gap) of the row after `count` rows, to be kept by who raises the count."""
    i = first + count
    contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.kind[i] = bodies[0], bodies[1], PARTS
    for k in range(5):
        contacts.feature[i, k] = features[k]
    swapped, one, other, at = _meet(solids, contacts, i, D, R)
    _write(contacts, i, D, swapped, one, other, at)
    return _margin(solids, contacts, i, swapped, D, R, one, other, at), row(contacts.normal, i), contacts.gap[i]


@lean_jit
def is_new(contacts, first, count, close):
    """Whether the row after `count` rows is none of theirs."""
    i = first + count
    for k in range(first, i):
        d, e = sub(row(contacts.arm_a, k), row(contacts.arm_a, i)), sub(row(contacts.arm_b, k), row(contacts.arm_b, i))
        near = min(dot(d, d), dot(e, e)) <= close * close
        if near and dot(row(contacts.normal, k), row(contacts.normal, i)) > ALIKE:
            return False
    return True


@lean_jit
def _add(solids, contacts, first, count, bodies, D, R, limit, part_a, part_b, which):
    """Such a row, where it lies on both parts and within limit[0]: count, or FULL. limit[1]: 1: wherever it lies."""
    if count < 0 or first + count >= len(contacts.gap):
        return FULL
    size = small_size(solids, bodies[0], bodies[1])
    features = (part_a[0], part_a[1], part_b[0], part_b[1], which)
    margin, _, gap = try_row(solids, contacts, first, count, bodies, D, R, features)
    if (margin < -FOUND * size and limit[1] == 0) or not gap <= limit[0]:
        return count
    return count + 1 if is_new(contacts, first, count, SAME * size) else count


@lean_jit
def shown(solids, R, i, n, slope):
    """(part of body i along its outward normal n, number)."""
    kind, u = solids.kind[i], rotated(R[i], row(solids.axis, i))
    rise = dot(n, u)
    number = 0 if rise > 0.0 else 1
    if kind == PLANE:
        return GROUND, -1
    if kind == CYLINDER:
        if length(cross(n, u)) <= slope:
            return END, number
        return (MIDDLE, 0) if abs(rise) <= slope else (RIM, number)
    if kind == CAPSULE:
        return (MIDDLE, 0) if abs(rise) <= slope else (BALL, number)
    return BALL, 0


@lean_jit
def tip_number(solids, R, i, number, n, k):
    """Number of the k-th of the tips of a face, beginning with that farthest along n."""
    u, axis = rotated(R[i], row(solids.axis, i)), row(solids.axis, i)
    across, e = rotated_back(R[i], part_across(n, u)), some_perpendicular(axis)
    angle = 0.0
    if dot(across, across) > 1e-30:
        angle = atan2(dot(across, cross(axis, e)), dot(across, e)) / (2.0 * pi)
    steps = int(angle * PARTS_OF_A_TURN) + k * (PARTS_OF_A_TURN // TIPS)
    return number + 2 * (steps % PARTS_OF_A_TURN)


@lean_jit
def _add_tips(solids, contacts, first, count, bodies, D, R, limit, side, number, part, n):
    """Tips of a face of bodies[side] over a face `part` of the other one; n: out of the first."""
    i = bodies[side]
    for k in range(TIPS):
        tip = (TIP, tip_number(solids, R, i, number, n, k))
        ones, others = (tip, part) if side == 0 else (part, tip)
        count = _add(solids, contacts, first, count, bodies, D, R, limit, ones, others, 0)
    return count


@lean_jit
def _add_both(solids, contacts, first, count, bodies, D, R, limit, side, kinds, other, which):
    """Rows of parts of bodies[side], of `kinds` with the numbers 0 and 1, with one part of the other body."""
    for number in range(2):
        one = (kinds, number)
        ones, others = (one, other) if side == 0 else (other, one)
        count = _add(solids, contacts, first, count, bodies, D, R, limit, ones, others, which)
    return count


@lean_jit
def _add_crossings(solids, contacts, first, count, bodies, D, R, limit, part_a, part_b):
    """Both crossings of a rim with a line or another rim."""
    one = part_of(solids, R, bodies[0], ZERO, part_a[0], part_a[1])
    other = part_of(solids, R, bodies[1], D, part_b[0], part_b[1])
    if not (do_cross(one, other) if one.rank == CIRCLE else do_cross(other, one)):
        return count
    for which in (AHEAD, BACK):
        count = _add(solids, contacts, first, count, bodies, D, R, limit, part_a, part_b, which)
    return count


@lean_jit
def _end_of_line(solids, i):
    """What is at the ends of the middle line of body i."""
    return RIM if solids.kind[i] == CYLINDER else BALL


@lean_jit
def _over_face(solids, contacts, first, count, bodies, D, R, limit, side, part, face, n):
    """Rows of a part of bodies[side] over a flat face of the other body."""
    if part[0] == END:
        return _add_tips(solids, contacts, first, count, bodies, D, R, limit, side, part[1], face, n)
    if part[0] == MIDDLE:
        kinds = _end_of_line(solids, bodies[side])
        return _add_both(solids, contacts, first, count, bodies, D, R, limit, side, kinds, face, 0)
    ones, others = (part, face) if side == 0 else (face, part)
    return _add(solids, contacts, first, count, bodies, D, R, limit, ones, others, 0)


@lean_jit
def _of_lines(solids, contacts, first, bodies, D, R, limit, slope):
    """Rows of two middle lines."""
    a, b = bodies
    turn, count = cross(rotated(R[a], row(solids.axis, a)), rotated(R[b], row(solids.axis, b))), 0
    if dot(turn, turn) > slope * slope:
        return _add(solids, contacts, first, 0, bodies, D, R, limit, (MIDDLE, 0), (MIDDLE, 0), 0)
    for side in range(2):
        kinds = _end_of_line(solids, bodies[side])
        count = _add_both(solids, contacts, first, count, bodies, D, R, limit, side, kinds, (MIDDLE, 0), FREE)
    return count


@lean_jit
def _of_parts(solids, contacts, first, bodies, D, R, limit, slope, part_a, part_b, n):
    """Rows of what both bodies show along n."""
    count = 0
    if part_a[0] == MIDDLE and part_b[0] == MIDDLE:
        return _of_lines(solids, contacts, first, bodies, D, R, limit, slope)
    if part_b[0] == END or part_b[0] == GROUND:
        count = _over_face(solids, contacts, first, count, bodies, D, R, limit, 0, part_a, part_b, n)
    if part_a[0] == END or part_a[0] == GROUND:
        count = _over_face(solids, contacts, first, count, bodies, D, R, limit, 1, part_b, part_a, scaled(n, -1.0))
    if part_a[0] == END and (part_b[0] == MIDDLE or part_b[0] == END):
        rim = (RIM, part_b[1]) if part_b[0] == END else part_b
        count = _add_crossings(solids, contacts, first, count, bodies, D, R, limit, (RIM, part_a[1]), rim)
    elif part_b[0] == END and part_a[0] == MIDDLE:
        count = _add_crossings(solids, contacts, first, count, bodies, D, R, limit, part_a, (RIM, part_b[1]))
    elif part_a[0] not in (GROUND, END) and part_b[0] not in (GROUND, END):
        count = _add(solids, contacts, first, count, bodies, D, R, limit, part_a, part_b, BETWEEN)
    return count


@lean_jit
def cylinder_manifold(solids, a, b, x, R, reach, angle, level, contacts, first, work):
    """`manifold` of a cylinder and a plane, sphere, capsule or cylinder: how many rows, or FULL."""
    slope, D, bodies = max(angle, FLAT), sub(row(x, b), row(x, a)), (a, b)
    far, n = round_gap(solids, a, b, x, R, inf, work.pairs[0], work.walk)
    part_a, part_b = shown(solids, R, a, n, slope), shown(solids, R, b, scaled(n, -1.0), slope)
    if not far <= reach:
        return 0
    limit = (max(reach, level) if angle > 0.0 else reach), 0
    count = _of_parts(solids, contacts, first, bodies, D, R, limit, slope, part_a, part_b, n)
    if count != 0:
        return count
    part_a, part_b = shown(solids, R, a, n, -1.0), shown(solids, R, b, scaled(n, -1.0), -1.0)
    return _of_parts(solids, contacts, first, bodies, D, R, (limit[0], 1), slope, part_a, part_b, n)
