"""The contact time of a mesh with a plane: never late, never missed (docs/time_of_impact.md, 3, with one direction).

The half space beyond a plane is convex, so the only direction that counts is the plane's normal, fixed in the plane's
body, and only the corners of the mesh matter: the gap is the least of the functions f(s) = n(s) . D(s) of the corners,
D from the plane's origin to the corner. Their derivatives at s = 0 are known exactly up to the second, and the third is
bounded over a window. One step lasts until the first of them could come down to the target gap; the mesh's tree passes
over what cannot.

Everything is told in the axes of the pair's first body, from its centre, as in `motion_bounds`; n points away from the
solid side. `side` is 1 where the plane is body b, else 0.
"""

from math import inf
from typing import NamedTuple

from comotion_server.kernels.boxes import lowest
from comotion_server.kernels.contact_plane import lowest_corner
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
from comotion_server.kernels.motion_bounds import Spin, first_root, relate, spins_over, take_over
from comotion_server.kernels.pair_impact import Touch, come_down
from comotion_server.kernels.pair_impact_bounds import AHEAD, across, unit_jerk
from comotion_server.kernels.time_of_impact import TURN, write_findings
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
)

Vector = tuple[float, float, float]


class Fall(NamedTuple):
    """The plane's normal, and the motion of the mesh's centre against the plane: f and its derivatives."""

    n: Vector  # unit normal, in the axes of a
    n_mesh: Vector  # in the axes of the mesh
    turn: Vector  # n' [1/s], in the axes of a
    bend: Vector  # n'' [1/s2]
    spin: Vector  # angular velocity of the mesh [rad/s], in the axes of a
    change: Vector  # angular acceleration of the mesh [rad/s2]
    centre: Vector  # from the plane's origin to the centre of the mesh [m]
    velocity: Vector  # its first derivative, without turning of the axes [m/s]
    acceleration: Vector  # its second one [m/s2]
    spin_mesh: Spin  # bounds over a window
    spin_plane: Spin


@lean_jit
def fall_of(relative, spins, R, normal, side):
    """`Fall`, the plane's normal given in its body's axes."""
    if side == 0:
        n, n_mesh = normal, rotated_back(R, normal)
        sign, w, change, spin, growth = 1.0, relative.spin_a, relative.change_a, relative.spin_b, relative.change_b
        spin_plane, spin_mesh = spins
    else:
        n = rotated(R, normal)
        n_mesh, sign = n, -1.0
        w, change, spin, growth = relative.spin_b, relative.change_b, relative.spin_a, relative.change_a
        spin_mesh, spin_plane = spins
    turn = cross(w, n)
    return Fall(
        n,
        n_mesh,
        turn,
        add(cross(change, n), cross(w, turn)),
        spin,
        growth,
        scaled(relative.offset, sign),
        scaled(relative.velocity, sign),
        scaled(relative.acceleration, sign),
        spin_mesh,
        spin_plane,
    )


@lean_jit
def corner_line(fall, r):
    """(f0, f1, f2) of the corner at r (in the axes of a) from the centre of the mesh."""
    v = cross(fall.spin, r)
    D, V = add(fall.centre, r), add(fall.velocity, v)
    A = add(fall.acceleration, add(cross(fall.change, r), cross(fall.spin, v)))
    return (
        dot(fall.n, D),
        dot(fall.n, V) + dot(fall.turn, D),
        dot(fall.n, A) + 2.0 * dot(fall.turn, V) + dot(fall.bend, D),
    )


@lean_jit
def third_bound(fall, radius, horizon):
    """(J, k): bounds of |f'''| [m/s3] of all corners, and of how far their f'' differ from the centre's [m/s2].

    With |n'| <= W, |n''| <= W' + W^2 and |n'''| <= W'' + 3 W W' + W^3 of the plane's rotation, as for points at unit
    distance; where the plane does not turn, a mesh about a fixed axis moves its corners only by n's part across it.
    """
    mesh, plane = fall.spin_mesh, fall.spin_plane
    second, third = mesh.change + mesh.rate * mesh.rate, unit_jerk(mesh)
    if plane.rate == 0.0:
        part = radius * across(mesh, fall.n)
        return part * third, part * second
    pull = length(fall.acceleration)
    speed = length(fall.velocity) + pull * horizon
    extent = length(fall.centre) + radius + speed * horizon
    speed += mesh.rate * radius
    bend = plane.change + plane.rate * plane.rate
    J = radius * third + 3.0 * plane.rate * (pull + radius * second) + 3.0 * bend * speed + unit_jerk(plane) * extent
    return J, radius * (second + 2.0 * plane.rate * mesh.rate + bend)


@lean_jit
def line_time(line, J, target, horizon):
    """How long [s] f surely stays above the target, or above where it is, or half of it; at most `horizon`."""
    f0, f1, f2 = line
    floor = target if f0 > target else (f0 if f1 > 0.0 else 0.5 * f0)
    if f0 - floor + horizon * (f1 + 0.5 * horizon * min(f2 - J * horizon / 3.0, 0.0)) >= 0.0:
        return horizon
    window = min(horizon, AHEAD * first_root(f0 - floor, f1, f2))
    return min(window, first_root(f0 - floor, f1, f2 - J * window / 3.0))


@lean_jit
def _turning_time(fall, horizon):
    """How long [s] both bodies together turn no farther than directions are worth something."""
    rate = fall.spin_mesh.rate + fall.spin_plane.rate
    return TURN / rate if rate > 0.0 else horizon


class Step(NamedTuple):
    """What the corners allow."""

    time: float  # for which they are surely above the plane [s]
    gap: float  # of the corner that is lowest, of those that close where they have come down to the target [m]
    closing: float  # speed at which it closes [m/s]
    arm: Vector  # of that corner from the centre of the mesh, in the axes of a [m]
    met: int  # 1: it has come down to the target and closes


@lean_jit
def _with_corner(step, fall, r, J, target, still, extent):
    """The `Step` that one more corner leaves."""
    line = corner_line(fall, r)
    time = min(step.time, line_time(line, J, target, step.time)) if line[0] > 0.0 else 0.0
    met = 1 if -line[1] > still and come_down(line[0], target, extent) else 0
    if met > step.met or (met == step.met and line[0] < step.gap):
        return Step(time, line[0], -line[1], r, met)
    return Step(time, step.gap, step.closing, step.arm, step.met)


@lean_jit
def first_step(m, shape, fall, R, side, target, still, horizon, nodes):
    """`Step` of a whole mesh over the next `horizon` [s]."""
    J, spread = third_bound(fall, 0.5 * m.size[shape], horizon)
    f0, f1, f2 = corner_line(fall, ZERO)
    # a corner adds n . r to f0 and (n x w + n') . r to f1
    rise = add(cross(fall.n, fall.spin), fall.turn)
    rise_mesh = rise if side == 1 else rotated_back(R, rise)
    extent = length(fall.centre) + m.size[shape]
    step = Step(horizon, inf, 0.0, ZERO, 0)
    nodes[0, 0] = m.root[shape]
    top = 1
    while top > 0:
        top -= 1
        node = nodes[top, 0]
        low = f0 + lowest(m, node, fall.n_mesh)
        least = (low, f1 + lowest(m, node, rise_mesh), f2 - spread)
        if low > step.gap and low > target and line_time(least, J, target, step.time) >= step.time:
            continue
        if m.child[node] >= 0:
            child = m.child[node]
            first = lowest(m, child, fall.n_mesh) <= lowest(m, child + 1, fall.n_mesh)  # the lower one is next
            nodes[top, 0], nodes[top + 1, 0] = (child + 1, child) if first else (child, child + 1)
            top += 2
            continue
        for k in range(m.first[node], m.first[node] + m.entries[node]):
            for c in range(3):
                r = row(m.vertices, m.triangles[m.leaf_triangles[k], c])
                r = r if side == 1 else rotated(R, r)
                step = _with_corner(step, fall, r, J, target, still, extent)
    return step


@lean_jit
def _touch(step, fall, relative, side):
    """`Touch` of the corner of a step with its foot on the plane."""
    if side == 1:
        return Touch(step.gap, step.closing, step.arm, along(step.arm, -step.gap, fall.n), scaled(fall.n, -1.0))
    corner = add(relative.offset, step.arm)
    return Touch(step.gap, step.closing, along(corner, -step.gap, fall.n), corner, fall.n)


@lean_jit
def _sphere_step(fall, radius, tolerance, horizon):
    """How long [s] the sphere about the mesh surely stays above the tolerance; zero where it hardly is now."""
    f0, f1, f2 = corner_line(fall, ZERO)
    if f0 - radius <= 2.0 * tolerance:
        return 0.0
    J, _ = third_bound(fall, 0.0, horizon)
    return line_time((f0 - radius, f1, f2), J, tolerance, horizon)


@lean_jit
def advance_plane(
    m, all_flights, all_bodies, shape, normal, side, a, b, end, key, tolerance, budget, memory, findings, work, counts
):
    """Follow a mesh and a plane from the proven time in `memory` to the first contact.

    shape: of the mesh; normal: of the plane, in its body's axes; side: 1 where the plane is body b, else 0. All else
    is as in `time_of_impact.advance`, also how it ends; of `memory` time and target are used.
    """
    begin, now = memory[TIME], memory[TIME]
    flights, bodies, states, R = work.flights, work.bodies, work.states, work.R
    take_over(all_flights, all_bodies, a, b, flights, bodies)
    radius = 0.5 * m.size[shape]
    limit = counts[QUERIES] + counts[STEPS] + budget
    while now < end:
        memory[TIME] = now
        if now >= key:
            return LATER
        if counts[QUERIES] + counts[STEPS] >= limit:
            return SPENT
        relative = relate(flights, bodies, now, states, R)
        fall = fall_of(relative, spins_over(flights, bodies, states, end - now), R, normal, side)
        apart = _sphere_step(fall, radius, tolerance, end - now)
        if apart > 0.0:
            if memory[TARGET] == 0.0:
                memory[TARGET] = 0.5 * tolerance
            now = end if apart >= end - now else now + apart
            continue
        if memory[TARGET] == 0.0:
            gap = dot(fall.n, fall.centre) + lowest_corner(m, shape, fall.n_mesh, work.nodes)
            memory[TARGET] = min(0.5 * tolerance, gap)
        counts[STEPS] += 1
        horizon = min(end - now, _turning_time(fall, end - now))
        fall = fall_of(relative, spins_over(flights, bodies, states, horizon), R, normal, side)
        still = STILL * (length(row(states[1], 0)) + length(row(states[1], 1)) + fall.spin_mesh.rate * radius)
        still += STILL * fall.spin_plane.rate * (length(fall.centre) + radius)
        step = first_step(m, shape, fall, R, side, memory[TARGET], still, horizon, work.nodes)
        if not step.gap > 0.0:
            return OVERLAPS if now == begin else STALLS
        moves = now + step.time > now
        if step.met == 1 or (not moves and step.gap <= tolerance and step.closing > still):
            write_findings(states, _touch(step, fall, relative, side), now, findings)
            return TOUCHES if now == begin else MEETS
        if not moves:
            return STALLS
        now = end if step.time >= end - now else now + step.time
    memory[TIME] = end
    return NONE
