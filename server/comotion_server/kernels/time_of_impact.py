"""The contact time of two meshes on flights: never late, never missed (docs/time_of_impact.md).

From a proven time on: the first meeting of the bounding spheres, then steps from the distance, then windows, in which
every pair of triangles within reach gets a contact time of its own. A window always covers a least time, so a query
that starts at a touching pair leaves it in a few. The query can stop at any proven time and be taken up again.
"""

from math import inf

from comotion_server.kernels.flight import ATTITUDE_TOLERANCE
from comotion_server.kernels.impact_query import (
    CLOSING,
    CONTACT_TIME,
    GAP,
    KNOWN,
    LATER,
    MEETS,
    NONE,
    NORMAL,
    OVERLAPS,
    PAIRS,
    POINT_A,
    POINT_B,
    QUERIES,
    SPENT,
    STALLS,
    STEPS,
    STILL,
    TARGET,
    TIME,
    TOUCHES,
    WIDTH,
    WINDOWS,
    distance_left,
    note_distance,
)
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.mesh_pair import closest_points
from comotion_server.kernels.motion_bounds import approach_line, covering_time, relate, settle, sphere_time, take_over
from comotion_server.kernels.pair_impact import FREE, STALLED
from comotion_server.kernels.pair_window import Window, first_contact
from comotion_server.kernels.vectors import ZERO, along, length, rotated, row

FEW, MANY = 40, 160  # pairs of triangles in a window: with fewer the next one is wider, with more it is narrower
NARROWEST, WIDEST = 2.0**-10, 2.0**20
DRIFT = 0.02  # of the target: what attitudes found leg by leg may have drifted from their flights at a window
LEFT = 0.5  # of a distance: while more of it is left than this, it is not asked for again
TURN = 0.5  # [rad] that both bodies together turn in a window at most; beyond it directions lose their worth


@lean_jit
def write_findings(states, touch, time, findings):
    """The contact in the world frame, and when the gap would be zero if it went on closing as it does."""
    x, _, rotation, _, _, _ = states
    findings[CONTACT_TIME] = time + touch.gap / touch.closing
    findings[GAP], findings[CLOSING] = touch.gap, touch.closing
    findings[POINT_A : POINT_A + 3] = along(row(x, 0), 1.0, rotated(rotation[0], touch.point_a))
    findings[POINT_B : POINT_B + 3] = along(row(x, 0), 1.0, rotated(rotation[0], touch.point_b))
    findings[NORMAL : NORMAL + 3] = rotated(rotation[0], touch.normal)


@lean_jit
def advance(
    m,
    all_flights,
    all_bodies,
    shape_a,
    shape_b,
    a,
    b,
    end,
    key,
    tolerance,
    near,
    budget,
    memory,
    witness,
    findings,
    work,
    counts,
):
    """Follow bodies a and b, of shapes shape_a and shape_b, from the proven time in `memory` to the first contact.

    end: of the flights' common interval, local time [s]; key: time at which it is enough to know that nothing came
    before; tolerance: gap that counts as contact [m]; near: distance below which windows begin [m]; budget: distance
    queries and steps of triangle pairs. In and out: memory (MEMORY,), witness (2,) int64, triangles to begin with (over
    all shapes; -1: none), counts (COUNTS,) int64. Out: findings (FINDINGS,), after MEETS and TOUCHES alone.
    Returns how it ended; until memory[TIME] the bodies are surely apart:
      NONE      apart until `end`, and at `end`
      MEETS     at memory[TIME] the gap has come down to the target, to rounding, and closes
      TOUCHES   the same, at the time the query began at
      OVERLAPS  the surfaces intersect at the time the query began at
      LATER     memory[TIME] has reached `key`
      SPENT     the budget is used up
      STALLS    no step is possible any more within the precision of numbers
    """
    begin, now = memory[TIME], memory[TIME]
    flights, bodies = work.flights, work.bodies
    take_over(all_flights, all_bodies, a, b, flights, bodies)
    radius_a, radius_b = 0.5 * m.size[shape_a], 0.5 * m.size[shape_b]
    legs = 0
    limit = counts[QUERIES] + counts[STEPS] + budget
    while now < end:
        memory[TIME] = now
        if now >= key:
            return LATER
        if counts[QUERIES] + counts[STEPS] >= limit:
            return SPENT
        relative = relate(flights, bodies, now, work.states, work.R)
        legs += settle(flights, bodies, now, work.states)
        reach = radius_a + radius_b + tolerance
        if length(relative.offset) > reach + near:
            if memory[TARGET] == 0.0:
                memory[TARGET] = 0.5 * tolerance
            span = sphere_time(relative, reach)
            now = max(now + span, now) if span < inf else inf
            continue
        n, distance = ZERO, distance_left(memory, relative.offset, work.R, radius_a, radius_b)
        if distance <= max(near, LEFT * memory[KNOWN]):
            counts[QUERIES] += 1
            distance, _, _, n, witness[0], witness[1] = closest_points(
                m, shape_a, shape_b, work.R, relative.offset, inf, witness[0], witness[1], work.walk
            )
            if not distance > 0.0:
                return OVERLAPS if now == begin else STALLS
            note_distance(memory, distance, relative.offset, work.R)
        if memory[TARGET] == 0.0:
            memory[TARGET] = min(0.5 * tolerance, distance)
        speed, growth, rate, rate_growth = approach_line(flights, bodies, relative, work.states, radius_a, radius_b)
        if distance > near:
            now += covering_time(distance - tolerance, speed, growth)
            continue
        if legs * ATTITUDE_TOLERANCE * (radius_a + radius_b) > DRIFT * memory[TARGET]:
            take_over(all_flights, all_bodies, a, b, flights, bodies)
            relative = relate(flights, bodies, now, work.states, work.R)
            legs = settle(flights, bodies, now, work.states)
        span = min(covering_time(memory[WIDTH] * near, speed, growth), covering_time(TURN, rate, rate_growth))
        still = STILL * (speed + length(row(work.states[1], 0)) + length(row(work.states[1], 1)))
        window = Window(now, min(now + span, end), speed, growth, tolerance, memory[TARGET], still)
        counts[WINDOWS] += 1
        before = counts[PAIRS]
        found = first_contact(
            m, flights, bodies, shape_a, shape_b, n, witness[0], witness[1], window, relative, work, counts
        )
        if found.status == STALLED or not window.end > now:
            return STALLS
        if found.status != FREE:
            witness[0], witness[1] = found.triangle_a, found.triangle_b
            memory[TIME] = found.time
            relate(flights, bodies, found.time, work.states, work.R)
            write_findings(work.states, found.touch, found.time, findings)
            return TOUCHES if found.time == begin else MEETS
        now = window.end
        pairs = counts[PAIRS] - before
        if pairs < FEW:
            memory[WIDTH] = min(2.0 * memory[WIDTH], WIDEST)
        elif pairs > MANY:
            memory[WIDTH] = max(0.5 * memory[WIDTH], NARROWEST)
    memory[TIME] = end
    return NONE
