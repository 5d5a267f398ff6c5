"""Other ways to find a contact time, on the same flights and with the same distance: conservative advancement, P10."""

from math import inf
from time import perf_counter

import ipctk
import numpy as np

from comotion_server.kernels.impact_query import FINDINGS, MEETS, QUERIES, TIME, new_memory
from comotion_server.kernels.jit import jit
from comotion_server.kernels.mesh_pair import closest_points
from comotion_server.kernels.motion_bounds import approach_line, covering_time, relate, settle, take_over
from comotion_server.kernels.time_of_impact import advance
from comotion_server.kernels.vectors import add, cross, dot, sub

MOST_QUERIES = 100_000


@jit
def advance_conservatively(m, all_flights, all_bodies, shape_b, end, tolerance, witness, work):
    """(time, distance queries) of plain conservative advancement: step by distance / speed until the gap is small."""
    take_over(all_flights, all_bodies, 0, 1, work.flights, work.bodies)
    flights, bodies, now = work.flights, work.bodies, 0.0
    for query in range(MOST_QUERIES):
        relative = relate(flights, bodies, now, work.states, work.R)
        settle(flights, bodies, now, work.states)
        d, _, _, _, witness[0], witness[1] = closest_points(
            m, 0, shape_b, work.R, relative.offset, inf, witness[0], witness[1], work.walk
        )
        if d <= tolerance:
            return now, query + 1
        radius_a, radius_b = 0.5 * m.size[0], 0.5 * m.size[shape_b]
        speed, growth, _, _ = approach_line(flights, bodies, relative, work.states, radius_a, radius_b)
        now += covering_time(d - 0.5 * tolerance, speed, growth)
        if now >= end:
            return inf, query + 1
    return now, MOST_QUERIES


@jit
def advance_by_prediction(m, all_flights, all_bodies, shape_b, end, tolerance, parts, witness, work):
    """(time, distance queries) of the paper's rule: by the predicted time / N until the gap is small (P9, P10).

    The prediction is distance / approach speed of the last sub-step; at first the closing speed of the closest points.
    A pair that does not approach, or not within the interval, is dropped.
    """
    take_over(all_flights, all_bodies, 0, 1, work.flights, work.bodies)
    flights, bodies, now = work.flights, work.bodies, 0.0
    before, approach, step = inf, 0.0, 0.0
    for query in range(MOST_QUERIES):
        relative = relate(flights, bodies, now, work.states, work.R)
        settle(flights, bodies, now, work.states)
        d, p, q, n, witness[0], witness[1] = closest_points(
            m, 0, shape_b, work.R, relative.offset, inf, witness[0], witness[1], work.walk
        )
        if d <= tolerance:
            return now, query + 1
        if before == inf:
            velocity_b = add(relative.velocity, cross(relative.spin_b, sub(q, relative.offset)))
            approach = dot(n, sub(cross(relative.spin_a, p), velocity_b))
        else:
            approach = (before - d) / step
        if not approach > 0.0 or d / approach > end - now:
            return inf, query + 1
        step = d / approach / parts
        before = d
        now += step
    return now, MOST_QUERIES


@jit
def repeat_ours(m, flights, bodies, shape_b, end, tolerance, near, work, counts, repeats):
    """(time, distance queries) of our own query, asked `repeats` times from the beginning."""
    findings, found = np.empty(FINDINGS), inf
    for _ in range(repeats):
        memory, witness = new_memory(1)
        counts[:] = 0
        limits = (end, inf, tolerance, near, 1_000_000)
        status = advance(m, flights, bodies, 0, shape_b, 0, 1, *limits, memory[0], witness[0], findings, work, counts)
        found = memory[0, TIME] if status == MEETS else inf
    return found, counts[QUERIES]


@jit
def repeat_conservative(m, flights, bodies, shape_b, end, tolerance, work, repeats):
    """The same of conservative advancement."""
    answer = (inf, 0)
    for _ in range(repeats):
        answer = advance_conservatively(m, flights, bodies, shape_b, end, tolerance, np.full(2, -1), work)
    return answer


@jit
def repeat_prediction(m, flights, bodies, shape_b, end, tolerance, parts, work, repeats):
    """The same of the paper's rule."""
    answer = (inf, 0)
    for _ in range(repeats):
        answer = advance_by_prediction(m, flights, bodies, shape_b, end, tolerance, parts, np.full(2, -1), work)
    return answer


class Ipctk:
    """Linear vertex-face and edge-edge queries, one call each, as the corners (k, 3, 3) of `exact_motion` say."""

    def __init__(self, name):
        if name == "tight inclusion":
            self.ccd = ipctk.TightInclusionCCD(tolerance=1e-6, conservative_rescaling=0.8, max_iterations=10_000)
        else:
            self.ccd = ipctk.AdditiveCCD(conservative_rescaling=0.9, max_iterations=10_000)

    def run(self, queries, hit, contact, seconds):
        """Answers as many queries as it can in `seconds`; how many, and in which time."""
        face, edges = self.ccd.point_triangle_ccd, self.ccd.edge_edge_ccd
        begin = perf_counter()
        for k, (is_face, points) in enumerate(queries):
            hit[k], contact[k] = face(*points) if is_face else edges(*points)
            if perf_counter() - begin > seconds:
                break
        return k + 1, perf_counter() - begin


def ipctk_queries(a, b, velocity_a, velocity_b):
    """Their arguments: vertex, face or two edges, at times 0 and 1."""
    made = []
    for k in range(len(a)):
        is_face = bool((b[k, 0] == b[k, 1]).all())
        start = [b[k, 0], *a[k]] if is_face else [a[k, 0], a[k, 1], b[k, 0], b[k, 1]]
        rate = [velocity_b[k, 0], *velocity_a[k]] if is_face else [*velocity_a[k, :2], *velocity_b[k, :2]]
        made.append((is_face, [np.array(x) for x in start] + [x + v for x, v in zip(start, rate, strict=True)]))
    return made
