"""Parts of bodies that touch cylinders, and where two of them are nearest (docs/shapes.md, 5).

A part is a face, circle, line or point, blown up by a radius: the side of a cylinder is its middle line with its
radius, an edge is a line without. On a circle or line a point may move: T is the unit tangent there, K its rate of
change along it. Points are from the centre of the row's first body, world.
"""

from math import cos, inf, pi, sin, sqrt
from typing import NamedTuple

from comotion_server.kernels.curved_cylinders import closest_of_cylinders
from comotion_server.kernels.curved_kinds import CAPSULE, HALF_LENGTH, PLANE, RADIUS
from comotion_server.kernels.curved_points import part_across, some_perpendicular
from comotion_server.kernels.curved_search import lowest_on_segment
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, rotated, row, scaled, sub, unit

GROUND = 0  # a face of a mesh, or a plane; number: triangle, -1
CORNER = 1  # of a mesh; number: vertex
EDGE = 2  # of a mesh; number: 3 x triangle + which of its corners the edge begins at
BALL = 3  # a sphere, or an end of a capsule: number 0 or 1
MIDDLE = 4  # the middle line of a capsule or cylinder
END = 5  # a face of a cylinder; number 0, or 1 for the one against its axis
RIM = 6  # of such a face
TIP = 7  # a point of a rim; number: of the face + 2 x its angle in parts of a turn

POINT, LINE, CIRCLE, FACE = 0, 1, 2, 3  # ranks of parts
AHEAD, BACK, BETWEEN, FREE = (
    0,
    1,
    2,
    3,
)  # where rims meet: a crossing; within both bodies' cones of normals, or not

PARTS_OF_A_TURN = 2**40
TRIES = 30
PARALLEL = 1e-6  # sine of the angle between tangents below which they do not tell the normal

Vector = tuple[float, float, float]


class Part(NamedTuple):
    """A part of a body."""

    rank: int  # POINT, LINE, CIRCLE or FACE
    place: Vector  # centre of a line or circle, any point of a face [m]
    axis: Vector  # of a line or circle, the normal of a face, out of the body; of a tip that of its face; unit
    size: float  # half a line, radius of a circle and about a tip [m]
    radius: float  # by which it is blown up [m]


class Meeting(NamedTuple):
    """Where two parts are nearest, or cross as seen along n."""

    n: Vector  # unit, from the first one to the second
    p: Vector  # on the first, but for its radius [m]
    T_p: Vector
    K_p: Vector  # [1/m]
    q: Vector
    T_q: Vector
    K_q: Vector


@lean_jit
def end_of(solids, R, i, number):
    """(centre of a face of cylinder i from its own [m], outward normal), world."""
    u = rotated(R[i], row(solids.axis, i))
    up = u if number == 0 else scaled(u, -1.0)
    return scaled(up, solids.size[i, HALF_LENGTH]), up


@lean_jit
def _tip(solids, R, i, number):
    """(from the centre [m], normal of its face) of a tip."""
    axis = row(solids.axis, i)
    e, angle = some_perpendicular(axis), 2.0 * pi * (number // 2) / PARTS_OF_A_TURN
    out = add(scaled(e, cos(angle)), scaled(cross(axis, e), sin(angle)))
    place, up = end_of(solids, R, i, number % 2)
    return along(place, solids.size[i, RADIUS], rotated(R[i], out)), up


@lean_jit
def part_of(solids, R, i, centre, kind, number):
    """`Part` of body i, whose centre is there."""
    m, r = solids.meshes, solids.size[i, RADIUS]
    if kind == GROUND:
        if solids.kind[i] == PLANE:
            return Part(FACE, centre, rotated(R[i], row(solids.normal, i)), inf, 0.0)
        p = rotated(R[i], row(m.vertices, m.triangles[number, 0]))
        return Part(FACE, add(centre, p), rotated(R[i], row(m.normals, number)), inf, 0.0)
    if kind == CORNER:
        return Part(POINT, add(centre, rotated(R[i], row(m.vertices, number))), ZERO, 0.0, 0.0)
    if kind == EDGE:
        t, k = number // 3, number % 3
        p, q = row(m.vertices, m.triangles[t, k]), row(m.vertices, m.triangles[t, (k + 1) % 3])
        half = rotated(R[i], scaled(sub(q, p), 0.5))
        middle = add(centre, rotated(R[i], scaled(add(p, q), 0.5)))
        return Part(LINE, middle, unit(half), length(half), 0.0)
    if kind == TIP:
        place, up = _tip(solids, R, i, number)
        return Part(POINT, add(centre, place), up, r, 0.0)
    place, up = end_of(solids, R, i, number)
    if kind == BALL:
        return Part(POINT, add(centre, place) if solids.kind[i] == CAPSULE else centre, up, 0.0, r)
    if kind == MIDDLE:
        return Part(LINE, centre, up, solids.size[i, HALF_LENGTH], r)
    return Part(FACE if kind == END else CIRCLE, add(centre, place), up, r, 0.0)


@lean_jit
def _on_circle(part, out):
    """(point, T, K) at the direction `out` from a circle's centre."""
    return along(part.place, part.size, out), cross(part.axis, out), scaled(out, -1.0 / part.size)


@lean_jit
def _outward(part, p):
    """The direction from a circle's axis to a point."""
    across = unit(part_across(sub(p, part.place), part.axis))
    return across if across != ZERO else some_perpendicular(part.axis)


@lean_jit
def _moved(part, p, step):
    """(point, T, K) a step [m] along a line or circle from its point p."""
    if part.rank == LINE:
        s = dot(part.axis, sub(p, part.place)) + step
        return along(part.place, s, part.axis), part.axis, ZERO
    out, angle = _outward(part, p), step / part.size
    turned = add(scaled(out, cos(angle)), scaled(cross(part.axis, out), sin(angle)))
    return _on_circle(part, unit(turned))


@lean_jit
def _crossings(circle, other, which):
    """A point over which a circle's line and another line or circle cross as seen along its axis."""
    C = part_across(sub(other.place, circle.place), circle.axis)
    sign = 1.0 if which == AHEAD else -1.0
    if other.rank == LINE:
        u = part_across(other.axis, circle.axis)
        square, half = dot(u, u), dot(C, u)
        if square == 0.0:
            return other.place
        root = sqrt(max(half * half - square * (dot(C, C) - circle.size * circle.size), 0.0))
        return along(other.place, (sign * root - half) / square, other.axis)
    far = length(C)
    if far == 0.0:
        return add(circle.place, scaled(some_perpendicular(circle.axis), circle.size))
    s = 0.5 * (far * far + circle.size**2 - other.size**2) / far
    e, aside = scaled(C, 1.0 / far), sqrt(max(circle.size**2 - s * s, 0.0))
    return along(along(circle.place, s, e), sign * aside, cross(circle.axis, e))


@lean_jit
def do_cross(circle, other):
    """Whether a circle and another line or circle cross as seen along its axis."""
    C = part_across(sub(other.place, circle.place), circle.axis)
    if other.rank == LINE:
        u = part_across(other.axis, circle.axis)
        square, half = dot(u, u), dot(C, u)
        return half * half > square * (dot(C, C) - circle.size * circle.size)
    return abs(circle.size - other.size) < length(C) < circle.size + other.size


@lean_jit
def _start(circle, other, which):
    """Points from which the nearest ones of a circle and a line or circle are looked for."""
    if which <= BACK:
        P = _crossings(circle, other, which)
        return P, P
    D = sub(other.place, circle.place)
    if other.rank == LINE:
        t = lowest_on_segment(circle.size, 0.0, circle.axis, D, scaled(other.axis, other.size), -1.0, 1.0)
        P = along(other.place, t * other.size, other.axis)
        return P, P
    _, p, q = closest_of_cylinders(circle.size, 0.0, circle.axis, other.size, 0.0, other.axis, D)
    return add(circle.place, p), add(circle.place, q)


@lean_jit
def _nearest(circle, other, which):
    """(p, T, K, q, T, K) where the distance of a circle and a line or circle is stationary, by Newton's method."""
    p, q = _start(circle, other, which)
    p, T_p, K_p = _moved(circle, p, 0.0)
    q, T_q, K_q = _moved(other, q, 0.0)
    for _ in range(TRIES):
        d, c = sub(q, p), dot(T_p, T_q)
        f, g = dot(d, T_p), dot(d, T_q)
        A, B = dot(d, K_p) - 1.0, dot(d, K_q) + 1.0
        det = A * B + c * c
        if det == 0.0:
            break
        s, t = (c * g - B * f) / det, -(A * g + c * f) / det
        far = max(abs(s), abs(t))
        part = min(1.0, 0.5 * circle.size / far) if far > 0.0 else 1.0
        p, T_p, K_p = _moved(circle, p, part * s)
        q, T_q, K_q = _moved(other, q, part * t)
        if far <= 1e-15 * circle.size:
            break
    return p, T_p, K_p, q, T_q, K_q


@lean_jit
def _rims_meet(circle, other, which):
    """`Meeting` of a circle and a line or circle. The normal points out of the cylinder whose rim the circle is."""
    p, T_p, K_p, q, T_q, K_q = _nearest(circle, other, which)
    d, product = sub(q, p), cross(T_p, T_q)
    if other.radius > 0.0:
        n = unit(d)
    elif length(product) > PARALLEL:
        n = unit(product)
    else:
        n = unit(along(d, -dot(d, T_p), T_p))
    if other.radius == 0.0 and dot(n, circle.axis) - dot(n, K_p) * circle.size < 0.0:
        n = scaled(n, -1.0)
    return Meeting(n, p, T_p, K_p, q, T_q, K_q)


@lean_jit
def _lines_meet(one, other):
    """`Meeting` of two lines that are not parallel."""
    u, v, D = one.axis, other.axis, sub(other.place, one.place)
    slant, product = dot(u, v), cross(u, v)
    square = dot(product, product)
    s, t = (dot(D, u) - slant * dot(D, v)) / square, (slant * dot(D, u) - dot(D, v)) / square
    n = scaled(product, (1.0 if dot(product, D) >= 0.0 else -1.0) / length(product))
    return Meeting(n, along(one.place, s, u), u, ZERO, along(other.place, t, v), v, ZERO)


@lean_jit
def meeting(one, other, which):
    """`Meeting` of two parts; rank of the first at least that of the second."""
    if one.rank == FACE:
        n, q, T, K = one.axis, other.place, ZERO, ZERO
        if other.rank == CIRCLE:
            across = unit(part_across(n, other.axis))
            q, T, K = _on_circle(other, scaled(across, -1.0) if across != ZERO else some_perpendicular(other.axis))
        return Meeting(n, along(q, -dot(n, sub(q, one.place)), n), ZERO, ZERO, q, T, K)
    if other.rank != POINT:
        return _rims_meet(one, other, which) if one.rank == CIRCLE else _lines_meet(one, other)
    q = other.place
    if one.rank == CIRCLE:
        p, T, K = _on_circle(one, _outward(one, q))
    else:
        p, T, K = _moved(one, q, 0.0)
    return Meeting(unit(sub(q, p)), p, T, K, q, ZERO, ZERO)


@lean_jit
def from_rim(part, p, n):
    """How far [m] inside the cone of a rim's normals the direction n out of its cylinder is."""
    return part.size * min(dot(n, part.axis), dot(n, _outward(part, p)))
