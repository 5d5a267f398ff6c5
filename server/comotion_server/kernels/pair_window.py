"""The first contact of two meshes within a short window: all pairs of triangles in reach, each with its own time.

Pairs of boxes and of triangles farther apart than the bodies can approach within the window are passed over, likewise
those that the direction of the closest pair keeps apart. A contact that is found shortens the window for the rest.
"""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.boxes import box_gap, divides_a, highest, lowest
from comotion_server.kernels.flight import Bodies, Flights
from comotion_server.kernels.hierarchy import STACK_SIZE
from comotion_server.kernels.impact_query import LONGEST, PAIRS, STEPS
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.mesh_pair import corners, corners_moved, work_space
from comotion_server.kernels.mesh_room import Work
from comotion_server.kernels.motion_bounds import spins_over
from comotion_server.kernels.pair_impact import FREE, NO_TOUCH, STALLED, Touch, pair_impact
from comotion_server.kernels.triangle_distance import closer_points
from comotion_server.kernels.vectors import cross, dot, rotated_back


class Window(NamedTuple):
    """From now on: how far the bodies are told apart, and what they can do meanwhile."""

    begin: float  # local time [s]
    end: float
    speed: float  # two points approach at no more than speed + growth s [m/s]
    growth: float
    tolerance: float  # [m]
    target: float  # gap that steps aim at [m]
    still: float  # a gap that closes no faster than this does not close: it is rounding [m/s]


class Aim(NamedTuple):
    """A direction n that does not turn, and what moves along it."""

    n_a: tuple[float, float, float]  # in the axes of a
    n_b: tuple[float, float, float]  # in the axes of b
    turn_a: tuple[float, float, float]  # n x w of a, so that turn . r = n . (w x r), in the axes of a
    turn_b: tuple[float, float, float]  # likewise of b, in the axes of b
    offset: float  # of the centres along n [m]
    velocity: float  # likewise [m/s]
    bend: float  # least acceleration of any two points along n [m/s2], not above zero


class Found(NamedTuple):
    """What a window gave: until `time` the bodies are apart; then HIT, or STALLED, or nothing."""

    status: int
    time: float  # local [s]
    touch: Touch
    triangle_a: int
    triangle_b: int


@jit
def _states():
    return np.empty((2, 3)), np.empty((2, 3)), np.empty((2, 3, 3)), np.empty((2, 3)), np.empty((2, 3)), np.empty(3)


@jit
def new_work():
    """`Work`, to be used again and again."""
    flights = Flights(
        np.empty(2),
        np.empty((2, 3)),
        np.empty((2, 3)),
        np.empty((2, 3)),
        np.empty((2, 3, 3)),
        np.empty((2, 3)),
        np.empty((2, 3)),
        np.empty((2, 3)),
        np.empty((2, 2)),
        np.empty(2, np.int64),
    )
    bodies = Bodies(
        np.empty((2, 3)),
        np.empty((2, 3, 3)),
        np.empty(2, np.int64),
        np.empty((2, 3)),
        np.empty((2, 3)),
        np.empty(2, np.bool_),
    )
    return Work(
        flights,
        bodies,
        _states(),
        np.empty((3, 3)),
        _states(),
        np.empty((3, 3)),
        np.empty((STACK_SIZE, 2), np.int64),
        work_space(),
    )


@lean_jit
def _reach(window, time):
    """Pairs at this distance [m] or farther at the beginning are not in contact before `time`."""
    s = time - window.begin
    return s * (window.speed + 0.5 * window.growth * s) + window.tolerance


@lean_jit
def _aim(m, shape_a, shape_b, n, relative, spins, R):
    """The fixed direction n as `_passes` needs it: supports of positions and velocities, and the least curvature."""
    bend_a = (spins[0].change + spins[0].rate * spins[0].rate) * 0.5 * m.size[shape_a]
    bend_b = (spins[1].change + spins[1].rate * spins[1].rate) * 0.5 * m.size[shape_b]
    return Aim(
        n,
        rotated_back(R, n),
        cross(n, relative.spin_a),
        rotated_back(R, cross(n, relative.spin_b)),
        dot(n, relative.offset),
        dot(n, relative.velocity),
        min(dot(n, relative.acceleration), 0.0) - bend_a - bend_b,
    )


@lean_jit
def _passes(m, node_a, node_b, aim, span, target):
    """Whether the fixed direction of `aim` keeps two boxes apart by the target for `span` [s]."""
    gap = aim.offset + lowest(m, node_b, aim.n_b) - highest(m, node_a, aim.n_a)
    if gap < target:
        return False
    rate = aim.velocity + lowest(m, node_b, aim.turn_b) - highest(m, node_a, aim.turn_a)
    return gap + span * (rate + 0.5 * span * aim.bend) >= target


@lean_jit
def _pair_passes(corners_a, arms_b, aim, span, target):
    """The same for two triangles, the one of b given by its corners in b's own axes."""
    a0, a1, a2 = corners_a
    b0, b1, b2 = arms_b
    n, m = aim.n_a, aim.n_b
    gap = aim.offset + min(dot(m, b0), dot(m, b1), dot(m, b2)) - max(dot(n, a0), dot(n, a1), dot(n, a2))
    if gap < target:
        return False
    n, m = aim.turn_a, aim.turn_b
    rate = aim.velocity + min(dot(m, b0), dot(m, b1), dot(m, b2)) - max(dot(n, a0), dot(n, a1), dot(n, a2))
    return gap + span * (rate + 0.5 * span * aim.bend) >= target


@lean_jit
def _try_pair(m, flights, bodies, i, j, aim, window, relative, spins, work, counts, found):
    """`found`, or the contact of triangles i of a and j of b if it comes earlier."""
    corners_a, arms_b = corners(m, i), corners(m, j)
    if _pair_passes(corners_a, arms_b, aim, found.time - window.begin, window.target):
        return found
    reach = _reach(window, found.time)
    b0, b1, b2 = corners_moved(m, j, work.R, relative.offset)
    first = closer_points(reach, corners_a[0], corners_a[1], corners_a[2], b0, b1, b2)
    if first[0] >= reach:
        return found
    status, time, touch, steps = pair_impact(
        flights,
        bodies,
        corners_a,
        arms_b,
        window,
        found.time,
        first,
        relative,
        spins,
        work.R,
        work.states_pair,
        work.R_pair,
    )
    counts[PAIRS] += 1
    counts[STEPS] += steps
    counts[LONGEST] = max(counts[LONGEST], steps)
    if status == FREE or (status == found.status and time >= found.time):
        return found
    return Found(status, time, touch, i, j)


@lean_jit
def first_contact(m, flights, bodies, shape_a, shape_b, n, witness_a, witness_b, window, relative, work, counts):
    """`Found` of two bodies over a window: FREE until its end, or the first contact.

    n, witness_a, witness_b: direction and triangles of the closest points at its beginning; relative and work.states,
    work.R: the motion then.
    """
    spins = spins_over(flights, bodies, work.states, window.end - window.begin)
    found = Found(FREE, window.end, NO_TOUCH, witness_a, witness_b)
    aim = _aim(m, shape_a, shape_b, n, relative, spins, work.R)
    found = _try_pair(m, flights, bodies, witness_a, witness_b, aim, window, relative, spins, work, counts, found)
    nodes = work.nodes
    nodes[0, 0], nodes[0, 1] = m.root[shape_a], m.root[shape_b]
    top = 1
    while top > 0 and found.status != STALLED and found.time > window.begin:
        top -= 1
        node_a, node_b = nodes[top, 0], nodes[top, 1]
        reach = _reach(window, found.time)
        if _passes(m, node_a, node_b, aim, found.time - window.begin, window.target):
            continue
        if box_gap(m, node_a, node_b, work.R, relative.offset, reach) >= reach:
            continue
        if m.child[node_a] < 0 and m.child[node_b] < 0:
            for k in range(m.first[node_a], m.first[node_a] + m.entries[node_a]):
                i = m.leaf_triangles[k]
                for l in range(m.first[node_b], m.first[node_b] + m.entries[node_b]):
                    j = m.leaf_triangles[l]
                    if (i != witness_a or j != witness_b) and found.status != STALLED:
                        found = _try_pair(m, flights, bodies, i, j, aim, window, relative, spins, work, counts, found)
        elif divides_a(m, node_a, node_b):
            nodes[top, 0], nodes[top, 1] = m.child[node_a], node_b
            nodes[top + 1, 0], nodes[top + 1, 1] = m.child[node_a] + 1, node_b
            top += 2
        else:
            nodes[top, 0], nodes[top, 1] = node_a, m.child[node_b]
            nodes[top + 1, 0], nodes[top + 1, 1] = node_a, m.child[node_b] + 1
            top += 2
    return found
