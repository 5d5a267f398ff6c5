"""The contact time of a sphere with a sphere, a plane or a pipe, in closed form (docs/spheres.md).

Both bodies fly on parabolas, so the offset of their centres is D + V s + A s^2 / 2 from the later of their two
take-offs on, and the gap, or its product with a length, is a polynomial of s. Times are counted from
there: a contact is where it is, whoever asks and however often. The gap at a contact is zero, to rounding.
"""

from math import inf, sqrt

from comotion_server.kernels.flight import STILL as NOT_TURNING
from comotion_server.kernels.flight import motion_of
from comotion_server.kernels.impact_query import (
    CLOSING,
    CONTACT_TIME,
    GAP,
    LATER,
    MEETS,
    MET,
    NONE,
    NORMAL,
    OVERLAPS,
    POINT_A,
    POINT_B,
    STALLS,
    STILL,
    TIME,
    TOUCHES,
)
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.pipe_impact import GRAIN, OVERLAP, pipe_gap, pipe_time
from comotion_server.kernels.polynomial_falls import fall_time
from comotion_server.kernels.solids import PIPE, PLANE, RADIUS, SPHERE
from comotion_server.kernels.vectors import along, cross, dot, length, rotated, row, scaled, sub


@lean_jit
def are_smooth(solids, a, b):
    """Whether two bodies are a sphere and a sphere, a plane or a pipe."""
    one, other = solids.kind[a], solids.kind[b]
    if one == SPHERE:
        return other in (SPHERE, PLANE, PIPE)
    return other == SPHERE and one in (PLANE, PIPE)


@lean_jit
def has_closed_form(solids, flights, a, b):
    """Whether the contact time of two bodies is known in closed form on these flights: planes and pipes do not turn."""
    if solids.kind[a] == SPHERE and solids.kind[b] == SPHERE:
        return True
    other = a if solids.kind[b] == SPHERE else b
    return are_smooth(solids, a, b) and flights.kind[other] == NOT_TURNING


@lean_jit
def has_horizon(solids, flights, a, b):
    """Whether a contact is only looked for up to some time: polynomials of degree two are solved for good."""
    kinds = solids.kind[a] + solids.kind[b]
    if kinds == SPHERE + SPHERE:
        return row(flights.acceleration, a) != row(flights.acceleration, b)
    return kinds == SPHERE + PIPE


@lean_jit
def _polished(D, V, A, reach, s):
    """The time at which |D + V s + A s^2 / 2| = reach, from one that is nearly right."""
    for _ in range(2):
        at = along(along(D, s, V), 0.5 * s * s, A)
        far = length(at)
        speed = dot(at, along(V, s, A)) / far
        change = (far - reach) / speed if speed < 0.0 else inf
        if not abs(change) < 1e-6 * s:
            break
        s -= change
    return s


@lean_jit
def spheres_time(D, V, A, reach, still, tolerance, horizon):
    """When two spheres touch, `reach` [m] the sum of their radii: s >= 0, OVERLAP, or inf: not up to `horizon`."""
    far = length(D)
    if far - reach < -tolerance:
        return OVERLAP
    half = dot(D, V)
    if A[0] == 0.0 and A[1] == 0.0 and A[2] == 0.0:
        if not half < 0.0:
            return inf
        if far <= reach:
            return 0.0 if half < -reach * still else inf
        beside, speed = length(cross(D, V)), length(V) * reach  # half^2 - V^2 (D^2 - reach^2) with digits to spare
        if beside > speed:
            return inf
        s = (far - reach) * (far + reach) / (sqrt((speed - beside) * (speed + beside)) - half)
        return s
    c = ((far - reach) * (far + reach), 2.0 * half, dot(V, V) + dot(D, A), dot(V, A), 0.25 * dot(A, A))
    s = fall_time(c, 2.0 * reach * still, GRAIN * reach * reach, horizon)
    return _polished(D, V, A, reach, s) if 0.0 < s < inf else s


@lean_jit
def plane_time(n, D, V, A, r, still, tolerance, horizon):
    """When a sphere of radius r at D from a plane with unit normal n touches it, likewise."""
    height = dot(n, D)
    if height - r < -tolerance:
        return OVERLAP
    c = (height - r, dot(n, V), 0.5 * dot(n, A), 0.0, 0.0)
    return fall_time(c, still, GRAIN * (r + length(D)), horizon)


@lean_jit
def direction_of(solids, rotation, i):
    """The normal of a plane, or the axis of a pipe, in the world."""
    return rotated(rotation, row(solids.normal if solids.kind[i] == PLANE else solids.axis, i))


@lean_jit
def _write_findings(solids, flights, a, b, time, findings):
    """The contact in the world frame."""
    (xa, va), (xb, vb) = motion_of(flights, a, time), motion_of(flights, b, time)
    gap, n = smooth_gap(solids, a, b, xa, xb, flights.rotation[a], flights.rotation[b])
    closing = dot(n, sub(va, vb))
    if solids.kind[a] == SPHERE:
        p = along(xa, solids.size[a, RADIUS], n)
        q = along(p, gap, n)
    else:
        q = along(xb, -solids.size[b, RADIUS], n)
        p = along(q, -gap, n)
    findings[CONTACT_TIME], findings[GAP], findings[CLOSING] = time, gap, closing
    findings[POINT_A : POINT_A + 3], findings[POINT_B : POINT_B + 3] = p, q
    findings[NORMAL : NORMAL + 3] = n


@lean_jit
def smooth_gap(solids, a, b, xa, xb, rotation_a, rotation_b):
    """(gap [m], unit normal from a to b, world) of a sphere and a sphere, a plane or a pipe, centres at xa and xb."""
    if solids.kind[a] == SPHERE and solids.kind[b] == SPHERE:
        D = sub(xb, xa)
        far = length(D)
        n = scaled(D, 1.0 / far) if far > 0.0 else (1.0, 0.0, 0.0)
        return far - (solids.size[a, RADIUS] + solids.size[b, RADIUS]), n
    sphere, other = (b, a) if solids.kind[b] == SPHERE else (a, b)
    D = sub(xb, xa) if sphere == b else sub(xa, xb)
    r, u = solids.size[sphere, RADIUS], direction_of(solids, rotation_a if other == a else rotation_b, other)
    if solids.kind[other] == PLANE:
        gap, n = dot(u, D) - r, u
    else:
        gap, n = pipe_gap(solids.size[other], u, D, r)
    return gap, (n if sphere == b else scaled(n, -1.0))


@lean_jit
def contact_time(solids, flights, a, b, tolerance, end):
    """The local time [s] at which bodies that `has_closed_form` touch; inf: not up to `end`; OVERLAP or STALL."""
    begin = max(flights.origin[a], flights.origin[b])
    (xa, va), (xb, vb) = motion_of(flights, a, begin), motion_of(flights, b, begin)
    D, V, A = sub(xb, xa), sub(vb, va), sub(row(flights.acceleration, b), row(flights.acceleration, a))
    still, left = STILL * (length(va) + length(vb)), end - begin
    tolerance += still * begin  # what the clock's rounding is worth
    if solids.kind[a] == SPHERE and solids.kind[b] == SPHERE:
        s = spheres_time(D, V, A, solids.size[a, RADIUS] + solids.size[b, RADIUS], still, tolerance, left)
    else:
        sphere, other = (b, a) if solids.kind[b] == SPHERE else (a, b)
        if sphere == a:
            D, V, A = scaled(D, -1.0), scaled(V, -1.0), scaled(A, -1.0)
        r, u = solids.size[sphere, RADIUS], direction_of(solids, flights.rotation[other], other)
        if solids.kind[other] == PLANE:
            s = plane_time(u, D, V, A, r, still, tolerance, left)
        else:
            s = pipe_time(solids.size[other], u, D, V, A, r, still, tolerance, left)
    return begin + s if s >= 0.0 else s


@lean_jit
def foresee(solids, flights, a, b, tolerance, end, memory):
    """Note the contact time of bodies that `has_closed_form` from memory[TIME] on: NONE, LATER, OVERLAPS or STALLS.

    After LATER it is the proven time, and kept until one of them takes off anew; after NONE they stay apart until then
    (memory[TIME] is inf) or up to `end`.
    """
    time = contact_time(solids, flights, a, b, tolerance, end)
    if time < 0.0:
        return OVERLAPS if time == OVERLAP else STALLS
    if time < inf:
        memory[TIME], memory[MET] = max(time, memory[TIME]), 1.0
        return LATER
    memory[TIME] = max(end, memory[TIME]) if has_horizon(solids, flights, a, b) else inf
    return NONE


@lean_jit
def advance_smooth(solids, flights, a, b, end, key, tolerance, memory, findings):
    """As `time_of_impact.advance`, for bodies that `has_closed_form`."""
    begin = memory[TIME]
    if memory[MET] == 0.0:
        status = foresee(solids, flights, a, b, tolerance, end, memory)
        if status != LATER:
            return status
    if not memory[TIME] < end:
        return NONE
    if memory[TIME] > key:
        return LATER
    _write_findings(solids, flights, a, b, memory[TIME], findings)
    return TOUCHES if memory[TIME] == begin else MEETS
