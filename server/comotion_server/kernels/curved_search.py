"""The lowest point of a convex function on a segment, a disc or a triangle: the squared distance from a solid cylinder.

On a segment its slope only grows, so that the lowest point is enclosed (false position with halved ends, Illinois, and
every third turn a bisection). Discs and triangles are swept by chords: the least value on a chord is again convex from
chord to chord, and its slope is that of the function along the way its lowest point goes (envelope theorem).
"""

from math import sqrt

from comotion_server.kernels.curved_points import slope
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import along, scaled, sub

TURNS = 200
NARROW = 2e-16  # of a parameter that runs over about 1


@lean_jit
def between(lo, f_lo, hi, f_hi, turn):
    """Where to look next for the zero of a function that grows from f_lo < 0 to f_hi > 0."""
    middle = 0.5 * (lo + hi)
    if turn % 3 == 2:
        return middle
    t = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
    return t if lo < t < hi else middle


@lean_jit
def lowest_on_segment(r, h, u, P, M, lo, hi):
    """The parameter t in [lo, hi] at which P + t M is nearest to a cylinder; the middle where all are equally near."""
    f_lo, f_hi = slope(r, h, u, along(P, lo, M), M), slope(r, h, u, along(P, hi, M), M)
    if f_lo >= 0.0 and f_hi <= 0.0:
        return 0.5 * (lo + hi)
    if f_lo >= 0.0:
        return lo
    if f_hi <= 0.0:
        return hi
    side = 0
    for turn in range(TURNS):
        if hi - lo <= NARROW:
            break
        t = between(lo, f_lo, hi, f_hi, turn)
        f = slope(r, h, u, along(P, t, M), M)
        if f == 0.0:
            return t
        if f < 0.0:
            lo, f_lo, f_hi, side = t, f, 0.5 * f_hi if side < 0 else f_hi, -1
        else:
            hi, f_hi, f_lo, side = t, f, 0.5 * f_lo if side > 0 else f_lo, 1
    return 0.5 * (lo + hi)


@lean_jit
def _on_chord(r, h, u, c, e1, e2, a):
    """(slope from chord to chord, point) of the lowest point on the chord a in [-1, 1] of a disc."""
    s = sqrt((1.0 - a) * (1.0 + a))
    P, M = along(c, a, e1), scaled(e2, s)
    t = lowest_on_segment(r, h, u, P, M, -1.0, 1.0)
    P = along(P, t, M)
    return slope(r, h, u, P, sub(scaled(e1, s), scaled(e2, t * a))), P


@lean_jit
def lowest_on_disc(r, h, u, c, e1, e2):
    """The point nearest to a cylinder on the disc about c with the radii e1, e2, vectors at right angles [m].

    It is sharpest where it lies along e2.
    """
    f, P = _on_chord(r, h, u, c, e1, e2, 0.0)
    if f == 0.0:
        return P
    lo, hi, f_lo, f_hi, side = -1.0, 1.0, -1.0, 1.0, 0
    if f < 0.0:
        lo, f_lo, f_hi = 0.0, f, -f
    else:
        hi, f_hi, f_lo = 0.0, f, -f
    for turn in range(TURNS):
        if hi - lo <= NARROW:
            break
        a = between(lo, f_lo, hi, f_hi, turn)
        f, P = _on_chord(r, h, u, c, e1, e2, a)
        if f == 0.0:
            break
        if f < 0.0:
            lo, f_lo, f_hi, side = a, f, 0.5 * f_hi if side < 0 else f_hi, -1
        else:
            hi, f_hi, f_lo, side = a, f, 0.5 * f_lo if side > 0 else f_lo, 1
    return P


@lean_jit
def _on_fan(r, h, u, a, p, q, s):
    """(slope from chord to chord, point) of the lowest point on the chord from a + s p to a + s q."""
    chord = sub(q, p)
    t = lowest_on_segment(r, h, u, along(a, s, p), scaled(chord, s), 0.0, 1.0)
    way = along(p, t, chord)
    P = along(a, s, way)
    return slope(r, h, u, P, way), P


@lean_jit
def lowest_on_triangle(r, h, u, a, b, c):
    """The point of a triangle nearest to a cylinder."""
    p, q = sub(b, a), sub(c, a)
    f_hi, P = _on_fan(r, h, u, a, p, q, 1.0)
    if f_hi <= 0.0:
        return P
    f_lo = min(slope(r, h, u, a, p), slope(r, h, u, a, q))
    if f_lo >= 0.0:
        return a
    lo, hi, side = 0.0, 1.0, 0
    for turn in range(TURNS):
        if hi - lo <= NARROW:
            break
        s = between(lo, f_lo, hi, f_hi, turn)
        f, P = _on_fan(r, h, u, a, p, q, s)
        if f == 0.0:
            break
        if f < 0.0:
            lo, f_lo, f_hi, side = s, f, 0.5 * f_hi if side < 0 else f_hi, -1
        else:
            hi, f_hi, f_lo, side = s, f, 0.5 * f_lo if side > 0 else f_lo, 1
    return P
