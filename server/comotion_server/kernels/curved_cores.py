"""Spheres and capsules: a segment with a radius about it.

Legend: M half of the segment, a vector from its middle [m]; zero for a sphere. D middle of b from the middle of a.
"""

from math import copysign

from comotion_server.kernels.curved_points import part_across, some_perpendicular
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.triangle_distance import segment_parameters
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, scaled, sub, unit

LEVEL = 1e-15  # sine of an angle that is rounding


@lean_jit
def _beside(M_a, M_b, D):
    """(whether parallel segments lie beside each other, middle of what they share: parameters s, t in [-1, 1])."""
    half_a, half_b = length(M_a), length(M_b)
    e = scaled(M_a, 1.0 / half_a)
    d = dot(e, D)
    lo, hi = max(-half_a, d - half_b), min(half_a, d + half_b)
    middle = 0.5 * (lo + hi)
    return lo <= hi, middle / half_a, copysign((middle - d) / half_b, (middle - d) * dot(e, M_b))


@lean_jit
def _way(M_a, M_b, D, s, t):
    """From s M_a to D + t M_b, rounded the same either way round."""
    return add(D, sub(scaled(M_b, t), scaled(M_a, s)))


@lean_jit
def core_parameters(M_a, M_b, D):
    """(s, t) of the closest points s M_a and D + t M_b of two segments."""
    across, aa, bb = cross(M_a, M_b), dot(M_a, M_a), dot(M_b, M_b)
    if aa > 0.0 and bb > 0.0 and dot(across, across) <= LEVEL * LEVEL * aa * bb:
        beside, s, t = _beside(M_a, M_b, D)
        if beside:
            return s, t
    s, t = segment_parameters(scaled(M_a, 2.0), scaled(M_b, 2.0), add(D, sub(M_a, M_b)))
    other_t, other_s = segment_parameters(scaled(M_b, 2.0), scaled(M_a, 2.0), add(scaled(D, -1.0), sub(M_b, M_a)))
    s, t, other_s, other_t = 2.0 * s - 1.0, 2.0 * t - 1.0, 2.0 * other_s - 1.0, 2.0 * other_t - 1.0
    if length(_way(M_a, M_b, D, other_s, other_t)) < length(_way(M_a, M_b, D, s, t)):
        return other_s, other_t
    return s, t


@lean_jit
def crossing_normal(M_a, M_b):
    """A unit vector normal to both segments: where they meet, a way apart."""
    n = unit(cross(M_a, M_b))
    if n != ZERO:
        return n
    M = M_a if dot(M_a, M_a) >= dot(M_b, M_b) else M_b
    return some_perpendicular(unit(M)) if M != ZERO else (1.0, 0.0, 0.0)


@lean_jit
def square_to(n, M, t):
    """The direction of n, at right angles to a segment where it is met between its ends."""
    return unit(part_across(n, unit(M)) if abs(t) < 1.0 and M != ZERO else n)


@lean_jit
def _normal(M_a, M_b, s, t, way):
    """The direction of `way`, at right angles to each segment that it meets between its ends."""
    return square_to(square_to(way, M_b, t), M_a, s)


@lean_jit
def round_gap(r_a, M_a, r_b, M_b, D):
    """(signed distance, point on a, point on b, normal from a to b) of two round shapes, from the middle of a."""
    s, t = core_parameters(M_a, M_b, D)
    p, way = scaled(M_a, s), _way(M_a, M_b, D, s, t)
    q = add(p, way)
    far = length(way)
    n = _normal(M_a, M_b, s, t, way) if far > 0.0 else crossing_normal(M_a, M_b)
    return far - (r_a + r_b), along(p, r_a, n), along(q, -r_b, n), n
