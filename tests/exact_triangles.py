"""The distance of two triangles in exact integers: the truth that the triangle kernels are measured against.

Doubles are whole multiples of a power of two, so squared distances are ratios of integers; only the last square root is
taken at 60 digits. Every candidate of P5 is formed the long way: points against edges, edges against edges, points
against faces; and an edge that passes through a face makes the distance zero.
"""

from mpmath import mp, mpf

DIGITS = 60


def exact_distance(a, b):
    """The distance of two triangles, (3, 3) doubles each, to 60 digits."""
    points, scale = _whole([*a, *b])
    a, b = points[:3], points[3:]
    with mp.workdps(DIGITS):
        if _passes(a, b) or _passes(b, a):
            return mpf(0)
        squares = [square for square in _candidates(a, b) if square is not None]
        return mp.sqrt(min(mpf(top) / mpf(bottom) for top, bottom in squares)) / scale


def _whole(points):
    ratios = [[float(c).as_integer_ratio() for c in point] for point in points]
    scale = max(bottom for point in ratios for _, bottom in point)
    return [tuple(top * (scale // bottom) for top, bottom in point) for point in ratios], scale


def _sub(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _side(a, b, c, d):
    volume = _dot(_sub(a, d), _cross(_sub(b, d), _sub(c, d)))
    return (volume > 0) - (volume < 0)


def _candidates(a, b):
    for i in range(3):
        yield _point_face(a[i], *b)
        yield _point_face(b[i], *a)
        for j in range(3):
            yield _point_edge(a[i], b[j], b[j - 2])
            yield _point_edge(b[i], a[j], a[j - 2])
            yield _edge_edge(a[i], a[i - 2], b[j], b[j - 2])


def _point_edge(p, a, b):
    u, w = _sub(b, a), _sub(p, a)
    uu, at = _dot(u, u), _dot(w, u)
    if uu == 0 or at <= 0:
        return _dot(w, w), 1
    if at >= uu:
        w = _sub(p, b)
        return _dot(w, w), 1
    across = _cross(u, w)
    return _dot(across, across), uu


def _edge_edge(a, b, c, d):
    u, v, w = _sub(b, a), _sub(d, c), _sub(c, a)
    n = _cross(u, v)
    nn = _dot(n, n)
    s, t = _dot(_cross(w, v), n), _dot(_cross(w, u), n)
    if nn == 0 or not (0 <= s <= nn and 0 <= t <= nn):
        return None
    return _dot(w, n) ** 2, nn


def _point_face(p, a, b, c):
    n = _cross(_sub(b, a), _sub(c, a))
    outside = any(_dot(_cross(_sub(y, x), _sub(p, x)), n) < 0 for x, y in ((a, b), (b, c), (c, a)))
    if outside or _dot(n, n) == 0:
        return None
    return _dot(n, _sub(p, a)) ** 2, _dot(n, n)


def _passes(a, b):
    """Whether an edge of a passes through the inside of b."""
    sides = [_side(*b, p) for p in a]
    for i in range(3):
        if sides[i] * sides[i - 2] < 0:
            turns = {_side(a[i], a[i - 2], b[k], b[k - 2]) for k in range(3)}
            if turns in ({1}, {-1}):
                return True
    return False
