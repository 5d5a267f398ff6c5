"""Times to collision of all pairs of spheres, planes and pipes over a whole step (P19)."""

from math import inf

from comotion_server.kernels.flight import motion_of
from comotion_server.kernels.jit import jit
from comotion_server.kernels.pipe_impact import OVERLAP
from comotion_server.kernels.solids import RADIUS, SPHERE
from comotion_server.kernels.sphere_impact import contact_time, has_closed_form, smooth_gap
from comotion_server.kernels.vectors import dot, sub


@jit
def pairs_of(solids, bodies, flights, pairs):
    """All pairs that may collide, to pairs (p,2), a < b; returns how many there are, whether or not they have room."""
    count, n = 0, len(solids.kind)
    for a in range(n):
        for b in range(a + 1, n):
            if (bodies.reacts[a] or bodies.reacts[b]) and has_closed_form(solids, flights, a, b):
                if count < len(pairs):
                    pairs[count, 0], pairs[count, 1] = a, b
                count += 1
    return count


@jit
def times_of(solids, flights, pairs, now, end, seconds):
    """Local times [s] at which pairs (p,2) collide from `now` on, to seconds (p,); inf: not up to `end`.

    Pairs that intersect have the time `now` if they close, else they do not collide.
    """
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        time = contact_time(solids, flights, a, b, 0.0, end)
        if time < 0.0:
            (xa, va), (xb, vb) = motion_of(flights, a, now), motion_of(flights, b, now)
            _, n = smooth_gap(solids, a, b, xa, xb, flights.rotation[a], flights.rotation[b])
            time = now if time == OVERLAP and dot(n, sub(vb, va)) < 0.0 else inf
        seconds[k] = time if time < end else inf


@jit
def touch_of(solids, flights, a, b, now, points):
    """Where bodies a and b are nearest at `now`: points (3,3), on a, on b, and the unit normal from a to b; the gap."""
    xa, xb = motion_of(flights, a, now)[0], motion_of(flights, b, now)[0]
    gap, n = smooth_gap(solids, a, b, xa, xb, flights.rotation[a], flights.rotation[b])
    for k in range(3):
        if solids.kind[a] == SPHERE:
            points[0, k] = xa[k] + solids.size[a, RADIUS] * n[k]
            points[1, k] = points[0, k] + gap * n[k]
        else:
            points[1, k] = xb[k] - solids.size[b, RADIUS] * n[k]
            points[0, k] = points[1, k] - gap * n[k]
        points[2, k] = n[k]
    return gap
