"""The contact time of a round shape with a mesh, a plane or another one: never late, never missed (docs/shapes.md, 4).

The pair is told in the axes of one body, the *frame*: the mesh or plane where there is one. There that body stands
still, and the centre c of the other one, the *round* body, moves by c1 s + c2 s^2 / 2, give or take error s^2 / 2. A
spin about the axis of a capsule or cylinder moves nothing: what turns is the axis, and with it the core, the segment or
solid cylinder that the body is without its radius.

Along a direction n that is fixed in the frame, the gap of two convex pieces is at least
  L(s) = gap + n . c1 s + (n . c2 - error - bend) s^2 / 2 - (sigma(n + s n x turn) - sigma(n)),
sigma the support of the core, which is convex, so L is concave: where it is above a floor at 0 and at s, it is in
between. A step lasts until the first triangle of the mesh (or the whole frame, where that is convex) could come down to
the target by the best of these directions: that of the closest points, the triangle's normal, and those that turn with
a capsule or cylinder (`line_time`, `face_time`).
"""

from math import inf
from typing import NamedTuple

from comotion_server.kernels.by_shapes import by_cylinders
from comotion_server.kernels.curved_gap import curved_gap
from comotion_server.kernels.curved_mesh_gap import box_bound, curved_mesh_gap
from comotion_server.kernels.curved_triangles import triangle_gap
from comotion_server.kernels.impact_query import (
    LATER,
    MEETS,
    NONE,
    OVERLAPS,
    QUERIES,
    SPENT,
    STALLS,
    STEPS,
    STILL,
    TARGET,
    TIME,
    TOUCHES,
)
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.line_time import line_time as time_beside
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.motion_bounds import relate, sphere_time, spins_over, take_over
from comotion_server.kernels.pair_impact import Touch, come_down
from comotion_server.kernels.plane_impact import line_time
from comotion_server.kernels.solids import CYLINDER, HALF_LENGTH, MESH, PLANE, RADIUS, SPHERE
from comotion_server.kernels.time_of_impact import TURN, write_findings
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, rotated, row, scaled, sub

Vector = tuple[float, float, float]

WORTH = 0.2  # of the target: a gap along a triangle's normal below it may be rounding
LEVEL = 4e-16  # sine of the angle to a plane below which a core lies in it
CLOSE = 1e-9  # relative: how near to its end a step comes
TRIES = 200  # to find the end of a step
FAR = 0.1  # of the bodies' radii: beyond it the spheres about them say enough


class Course(NamedTuple):
    """The motion of the round body in the frame, and its core."""

    centre: Vector  # [m]
    velocity: Vector  # [m/s]
    pull: Vector  # [m/s2] of the centre, but for `error`
    turn: Vector  # [rad/s] of the core
    axis: Vector  # unit
    kind: int
    size: tuple[float, float, float, float]  # its lengths [m]
    error: float  # [m/s2]
    arm: float  # radius of the core about the centre [m]
    bend: float  # how large the second derivatives of points of the core may be [m/s2]
    speed: float  # no point moves faster than speed + growth s [m/s]
    growth: float
    horizon: float  # [s] for which this holds


class Step(NamedTuple):
    """How far it is safe to go."""

    time: float  # [s]
    gap: float  # of the nearest piece, of those that close where they have come down to the target [m]
    closing: float  # speed at which it closes [m/s]
    foot: Vector  # on the frame's body [m]
    n: Vector  # from there to the round body
    met: int  # 1: it has come down to the target and closes


@lean_jit
def _rank(kind):
    return 2 if kind in (MESH, PLANE) else (0 if kind == SPHERE else 1)


@lean_jit
def frame_is_b(solids, a, b):
    """Whether the frame is b's."""
    return _rank(solids.kind[b]) > _rank(solids.kind[a])


@lean_jit
def axis_of(solids, i):
    """Normal of a plane, axis of what is round; body frame."""
    return row(solids.normal if solids.kind[i] == PLANE else solids.axis, i)


@lean_jit
def _support(course, n):
    """Greatest n . r of points r of the core, n of any length."""
    if course.kind == SPHERE:
        return 0.0
    most = course.size[HALF_LENGTH] * abs(dot(n, course.axis))
    return most + course.size[RADIUS] * length(cross(n, course.axis)) if course.kind == CYLINDER else most


@lean_jit
def _rim(course):
    """The radius that is not of the core [m]."""
    return 0.0 if course.kind == CYLINDER else course.size[RADIUS]


@lean_jit
def _turned(kind, u, spin, w):
    """(core's angular velocity, bounds of its size and rate of change) from the body's `Spin` and w; u: axis."""
    if kind == SPHERE:
        return ZERO, 0.0, 0.0
    if kind in (MESH, PLANE):
        return w, spin.rate, spin.change
    turn = cross(u, cross(w, u))
    return turn, spin.rate, spin.change + spin.rate * spin.rate


@lean_jit
def _course(solids, frame, i, relative, spins, R, horizon):
    """`Course` of body i in the axes of body `frame` over the next `horizon` [s], at most."""
    kind, size = solids.kind[i], solids.size[i]
    u, v = rotated(R, row(solids.axis, i)), axis_of(solids, frame)
    phi, rate_f, change_f = _turned(solids.kind[frame], v, spins[0], relative.spin_a)
    omega, rate_g, change_g = _turned(kind, u, spins[1], relative.spin_b)
    rate = rate_f + rate_g
    if rate * horizon > TURN:
        horizon = TURN / rate
    c, A = relative.offset, relative.acceleration
    velocity = sub(relative.velocity, cross(phi, c))
    fastest = length(relative.velocity) + length(A) * horizon
    far = length(c) + fastest * horizon
    error = (change_f + 3.0 * rate_f * rate_f) * far + 2.0 * rate_f * fastest
    arm = solids.core[i]
    bend = (change_f + change_g + rate_f * rate_g + rate * rate) * arm
    turn = sub(omega, phi)
    speed, growth = length(velocity) + length(turn) * arm, length(A) + error + bend
    lengths = (size[0], size[1], size[2], size[3])
    return Course(c, velocity, A, turn, u, kind, lengths, error, arm, bend, speed, growth, horizon)


@lean_jit
def _slope(course, n):
    """Least speed at which the gap along n opens of all points of the core that are nearest along it."""
    opening = dot(n, course.velocity)
    if course.kind == SPHERE:
        return opening
    u, way = course.axis, cross(n, course.turn)
    rise, change = dot(n, u), dot(way, u)
    opening -= course.size[HALF_LENGTH] * (abs(change) if abs(rise) <= LEVEL else (change if rise > 0.0 else -change))
    if course.kind == CYLINDER:
        across, moved = cross(n, u), cross(way, u)
        far = length(across)
        opening -= course.size[RADIUS] * (dot(across, moved) / far if far > LEVEL else length(moved))
    return opening


@lean_jit
def _rise(course, n, still, way, s):
    """How much L has grown after s; still: sigma(n), way: n x turn."""
    q = min(dot(n, course.pull) - course.error - course.bend, 0.0)
    return s * (dot(n, course.velocity) + 0.5 * q * s) - (_support(course, along(n, s, way)) - still)


@lean_jit
def _time_along(course, n, gap, opening, down, target, horizon):
    """How long [s] the gap along n stays above the target or, where it is `down`, above where it is or half of it.

    At most `horizon`.
    """
    if course.kind == SPHERE:
        return line_time((gap, opening, dot(n, course.pull) - course.error), 0.0, target, horizon)
    drop = (target if gap > target and not down else (gap if opening > 0.0 else 0.5 * gap)) - gap
    still, way = _support(course, n), cross(n, course.turn)
    if _rise(course, n, still, way, horizon) >= drop:
        return horizon
    low, high = horizon, horizon
    while _rise(course, n, still, way, low) < drop:
        high = low
        low *= 0.125
        if low < 1e-30 * horizon:
            return 0.0
    f_low, f_high = _rise(course, n, still, way, low) - drop, _rise(course, n, still, way, high) - drop
    for k in range(TRIES):
        if high - low <= CLOSE * low:
            break
        s = 0.5 * (low + high) if k % 3 == 2 else low + (high - low) * f_low / (f_low - f_high)
        if not low < s < high:
            s = 0.5 * (low + high)
        f = _rise(course, n, still, way, s) - drop
        if f >= 0.0:
            low, f_low = s, f
        else:
            high, f_high = s, f
    return low


@lean_jit
def _opening(course, n, foot, gap):
    """Speed at which the gap opens between the closest points."""
    arm = sub(along(foot, gap + _rim(course), n), course.centre)
    return dot(n, add(course.velocity, cross(course.turn, arm)))


@lean_jit
def _no_time(*_):
    """There are no faces."""
    return 0.0


_face_time = by_cylinders(_no_time, "face_time.face_time")


@lean_jit
def _with_piece(solids, step, course, n, gap, foot, slack, other, piece, rim, endless, target, still):
    """The `Step` that one more convex piece leaves.

    n, gap, foot: of its closest points; other: one more direction, with the gap `slack` along it; piece: its corners,
    which the middle line of a capsule or cylinder passes by at a distance above `rim`; endless: 1: a plane.
    """
    slope, extent = _slope(course, n), length(course.centre) + course.arm + course.size[RADIUS]
    opening = slope if endless == 1 or course.kind == SPHERE else _opening(course, n, foot, gap)
    down, time = come_down(gap, target, extent), 0.0
    if gap > 0.0:
        time = _time_along(course, n, gap, slope, down, target, step.time)
        if time < step.time and slack > WORTH * target:
            time = max(time, _time_along(course, other, slack, _slope(course, other), down, target, step.time))
        if time < step.time and endless == 0 and course.kind != SPHERE:
            p, q, r = piece
            time = max(time, time_beside(course, p, q, r, rim, down, target, step.time))
            if time < step.time:
                around = rim - course.size[RADIUS]
                time = max(time, _face_time(solids, course, n, p, q, r, around, down, target, step.time))
    met = 1 if -opening > still and down else 0
    time = min(time, step.time)
    if met > step.met or (met == step.met and gap < step.gap):
        return Step(time, gap, -opening, foot, n, met)
    return Step(time, step.gap, step.closing, step.foot, step.n, step.met)


@lean_jit
def _with_triangle(solids, step, t, course, target, still):
    """The same for a triangle of a mesh."""
    m = solids.meshes
    p, q, r = corners(m, t)
    c, N = course.centre, row(m.normals, t)
    gap, P, n = triangle_gap(course.kind, course.size, course.axis, sub(p, c), sub(q, c), sub(r, c))
    height = dot(N, sub(c, p))
    if height < 0.0:
        N, height = scaled(N, -1.0), -height
    slack = height - _support(course, N) - _rim(course)
    piece, rim = (p, q, r), course.size[RADIUS]
    return _with_piece(solids, step, course, scaled(n, -1.0), gap, add(c, P), slack, N, piece, rim, 0, target, still)


@lean_jit
def _mesh_step(solids, frame, course, target, tolerance, still, nodes):
    """`Step` from a whole mesh."""
    step = Step(course.horizon, inf, 0.0, ZERO, ZERO, 0)
    m = solids.meshes
    nodes[0, 0] = m.root[solids.shape[frame]]
    top = 1
    while top > 0:
        top -= 1
        node = nodes[top, 0]
        far = box_bound(m, node, course.kind, course.size, course.axis, course.centre)
        if far > tolerance and step.time * (course.speed + 0.5 * course.growth * step.time) <= far - target:
            continue
        child = m.child[node]
        if child < 0:
            for k in range(m.first[node], m.first[node] + m.entries[node]):
                step = _with_triangle(solids, step, m.leaf_triangles[k], course, target, still)
            continue
        one = box_bound(m, child, course.kind, course.size, course.axis, course.centre)
        other = box_bound(m, child + 1, course.kind, course.size, course.axis, course.centre)
        nodes[top, 0], nodes[top + 1, 0] = (child, child + 1) if other < one else (child + 1, child)
        top += 2
    return step


@lean_jit
def _shape_step(solids, frame, course, target, still, identity):
    """`Step` from a body that is no mesh."""
    gap, p, _, n = curved_gap(
        solids.kind[frame],
        solids.size[frame],
        axis_of(solids, frame),
        ZERO,
        identity,
        course.kind,
        course.size,
        course.axis,
        course.centre,
        identity,
    )
    step = Step(course.horizon, inf, 0.0, ZERO, ZERO, 0)
    half, rim, endless = ZERO, course.size[RADIUS], 1 if solids.kind[frame] == PLANE else 0
    if endless == 0:
        half, rim = scaled(axis_of(solids, frame), solids.size[frame, HALF_LENGTH]), rim + solids.size[frame, RADIUS]
    end = scaled(half, -1.0)
    return _with_piece(solids, step, course, n, gap, p, 0.0, n, (half, end, half), rim, endless, target, still)


@lean_jit
def _gap_now(solids, frame, course, identity, witness, work):
    """The gap [m]."""
    if solids.kind[frame] == MESH:
        gap, _, _, _, witness[0] = curved_mesh_gap(
            solids.meshes,
            solids.shape[frame],
            ZERO,
            identity,
            course.kind,
            course.size,
            course.axis,
            course.centre,
            identity,
            inf,
            witness[0],
            work.walk[0][:, 0],
            work.walk[1],
        )
        return gap
    return _shape_step(solids, frame, course, 0.0, 0.0, identity).gap


@lean_jit
def _touch(step, swapped):
    """`Touch` of the piece that is met, as seen from the pair's first body."""
    far = along(step.foot, step.gap, step.n)
    if swapped:
        return Touch(step.gap, step.closing, far, step.foot, scaled(step.n, -1.0))
    return Touch(step.gap, step.closing, step.foot, far, step.n)


@lean_jit
def advance_curved(
    solids, all_flights, all_bodies, a, b, end, key, tolerance, budget, memory, witness, findings, work, counts
):
    """As `time_of_impact.advance`, for a sphere, capsule or cylinder and a mesh, a plane or another one of them.

    Of `memory` time and target are used; witness: a triangle of the mesh.
    """
    begin, now = memory[TIME], memory[TIME]
    flights, bodies, states, R, identity = work.flights, work.bodies, work.states, work.R, work.R_pair
    swapped = frame_is_b(solids, a, b)
    frame, i = (b, a) if swapped else (a, b)
    take_over(all_flights, all_bodies, frame, i, flights, bodies)
    identity[:] = 0.0
    identity[0, 0] = identity[1, 1] = identity[2, 2] = 1.0
    radius = solids.radius[i] if solids.kind[frame] == PLANE else solids.radius[frame] + solids.radius[i]
    limit = counts[QUERIES] + counts[STEPS] + budget
    while now < end:
        memory[TIME] = now
        if now >= key:
            return LATER
        if counts[QUERIES] + counts[STEPS] >= limit:
            return SPENT
        relative = relate(flights, bodies, now, states, R)
        if solids.kind[frame] != PLANE and length(relative.offset) > (1.0 + FAR) * radius + tolerance:
            if memory[TARGET] == 0.0:
                memory[TARGET] = 0.5 * tolerance
            span = sphere_time(relative, radius + tolerance)
            now = max(now + span, now) if span < inf else inf
            continue
        counts[STEPS] += 1
        spins = spins_over(flights, bodies, states, end - now)
        course = _course(solids, frame, i, relative, spins, R, end - now)
        if course.horizon < end - now:
            spins = spins_over(flights, bodies, states, course.horizon)
            course = _course(solids, frame, i, relative, spins, R, course.horizon)
        if memory[TARGET] == 0.0:
            counts[QUERIES] += 1
            memory[TARGET] = min(0.5 * tolerance, _gap_now(solids, frame, course, identity, witness, work))
        still = length(row(states[1], 0)) + length(row(states[1], 1)) + spins[1].rate * solids.radius[i]
        still = STILL * (still + spins[0].rate * (length(course.centre) + solids.radius[i]))
        if solids.kind[frame] == MESH:
            step = _mesh_step(solids, frame, course, memory[TARGET], tolerance, still, work.nodes)
        else:
            step = _shape_step(solids, frame, course, memory[TARGET], still, identity)
        if not step.gap > 0.0:
            return OVERLAPS if now == begin else STALLS
        moves = now + step.time > now
        if step.met == 1 or (not moves and step.gap <= tolerance and step.closing > still):
            write_findings(states, _touch(step, swapped), now, findings)
            return TOUCHES if now == begin else MEETS
        if not moves:
            return STALLS
        now = end if step.time >= end - now else now + step.time
    memory[TIME] = end
    return NONE
