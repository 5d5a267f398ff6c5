"""When a polynomial of degree four at most first falls below zero: the gap of bodies on parabolas as time goes on.

Between the roots of its second derivative the first one is monotone, between the roots of that one the polynomial is:
so at most six intervals are each either passed over or hold one root, which is closed in on from both sides. Two roots
that have run together, or just not met, are told by the sign of the polynomial at its least value, to rounding; none is
passed over. (Degree two has its formula, with a discriminant that keeps its digits.)

A polynomial is the tuple of its coefficients (c0, c1, c2, c3, c4), c0 first.
"""

from math import inf, sqrt

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import difference_of_products

HALVINGS = 200  # of an interval at most, whatever the numbers; Newton's method needs about five steps


@lean_jit
def value(c, s):
    """The polynomial at s."""
    return c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * c[4])))


@lean_jit
def slope(c, s):
    """Its derivative at s."""
    return c[1] + s * (2.0 * c[2] + s * (3.0 * c[3] + s * 4.0 * c[4]))


@lean_jit
def root_between(c, low, high):
    """The root in [low, high], where the polynomial is monotone and its sign differs at the two ends."""
    below = value(c, low) > 0.0  # it falls
    s = 0.5 * (low + high)
    for _ in range(HALVINGS):
        f = value(c, s)
        if f == 0.0:
            return s
        if (f > 0.0) == below:
            low = s
        else:
            high = s
        d = slope(c, s)
        after = s - f / d if d != 0.0 else low
        if not low < after < high:
            after = 0.5 * (low + high)
        if after in (s, low, high):
            return after
        s = after
    return s


@lean_jit
def _turning_points(c):
    """The roots of the second derivative, the lower one first; inf where there is none."""
    a, b, d = 12.0 * c[4], 3.0 * c[3], 2.0 * c[2]  # a s^2 + 2 b s + d
    if a == 0.0:
        return (-0.5 * d / b if b != 0.0 else inf), inf
    squared = difference_of_products(b, b, a, d)
    if squared <= 0.0:
        return inf, inf
    q = -(b + sqrt(squared)) if b > 0.0 else sqrt(squared) - b
    one, other = q / a, d / q
    return min(one, other), max(one, other)


@lean_jit
def _quadratic_fall(c):
    """The same for degree two."""
    half = 0.5 * c[1]
    if half >= 0.0 and c[2] >= 0.0:
        return inf
    squared = difference_of_products(half, half, c[2], c[0])
    if squared < 0.0:
        return inf
    root = sqrt(squared)
    if half < 0.0:
        return c[0] / (root - half)
    return (half + root) / -c[2]


@lean_jit
def first_fall(c, horizon):
    """The first s > 0 at which the polynomial, positive just after 0, falls below zero; inf: not up to `horizon`.

    Of degree two the horizon is of no account.
    """
    if c[3] == 0.0 and c[4] == 0.0:
        return _quadratic_fall(c)
    derivative = (c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4], 0.0)
    first, second = _turning_points(c)
    low = 0.0
    for piece in range(3):
        high = min(max(first if piece == 0 else second, 0.0), horizon) if piece < 2 else horizon
        if not high > low:
            continue
        turn = high
        if (value(derivative, low) > 0.0) != (value(derivative, high) > 0.0):
            turn = root_between(derivative, low, high)
        for end in (turn, high):
            if value(c, end) < 0.0:
                return root_between(c, low, end)
            low = end
    return inf


@lean_jit
def fall_time(c, still, depth, horizon):
    """When a gap, times some length, closes: the first s >= 0 at which it comes to zero from above; inf: not at all.

    A gap at zero, or below by rounding, that closes faster than `still` is a contact now. If it opens, its next return
    is looked for, with the root at zero divided out. If it does neither, it is a contact once it has come down by
    `depth`, which is rounding.
    """
    if c[0] > 0.0:
        return first_fall(c, horizon)
    if c[1] < -still:
        return 0.0
    if c[1] > still:
        return first_fall((c[1], c[2], c[3], c[4], 0.0), horizon)
    if c[2] > 0.0:
        return first_fall((c[2], c[3], c[4], 0.0, 0.0), horizon)
    return first_fall((depth, 0.0, c[2], c[3], c[4]), horizon)
