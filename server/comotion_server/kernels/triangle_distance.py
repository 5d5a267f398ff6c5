"""P5: the distance of two triangles and its two closest points, from 9 edge pairs and 6 vertex-face pairs.

Every pair of points that is considered lies on the two triangles, so a lost digit can only lengthen the result, and
only in second order. Three things keep it at the rounding of the coordinates:
- all coordinates are taken relative to a vertex of the first triangle;
- parameters of nearly parallel edges come from cross products, not from the Gram determinant (which squares the
  condition), and are projected again on each other's line, after which only the error *across* the lines counts;
- normals of slivers are computed without cancellation.

A pair of features whose connecting direction keeps both triangles apart by its own length *is* the closest pair: the
search ends there. Triangles nearer than TOUCH of their extent touch: distance zero, like those that cross (P7).
"""

from math import inf, sqrt

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.triangle_crossing import crossing_point
from comotion_server.kernels.vectors import ZERO, add, along, cross, cross_exactly, dot, largest, length, scaled, sub

TOUCH = 1e-15  # of the extent: 9 roundings, what the feature distances may be wrong by; larger loses digits of gaps
SIDE = 1e-14  # relative rounding of a vertex's distance to a plane; within it both sides are considered
SLIVER = 0.04  # squared sine of a triangle's angle below which its normal is computed without cancellation

NO_PAIR = (inf, ZERO, ZERO, ZERO)


@lean_jit
def triangle_normal(u, v):
    """The product u x v, right to a few roundings also for slivers."""
    normal = cross(u, v)
    if dot(normal, normal) < SLIVER * dot(u, u) * dot(v, v):
        return cross_exactly(u, v)
    return normal


@lean_jit
def _clamped(value):
    return min(max(value, 0.0), 1.0)


@lean_jit
def segment_parameters(u, v, w):
    """Parameters in [0, 1] of the closest points of the segments s u and w + t v (Lumelsky 1985, Ericson 2005).

    Segments without length are allowed.
    """
    uu, vv = dot(u, u), dot(v, v)
    normal = cross(u, v)
    nn = dot(normal, normal)
    s = 0.0
    if nn > 0.0:
        s = _clamped(dot(cross(w, v), normal) / nn)
    t = _clamped((s * dot(u, v) - dot(v, w)) / vv) if vv > 0.0 else 0.0
    # the projections repair what is lost in s where the lines are nearly parallel, and clamp it where t was clamped
    s = _clamped(dot(u, along(w, t, v)) / uu) if uu > 0.0 else 0.0
    if vv > 0.0:
        t = _clamped(dot(v, sub(scaled(u, s), w)) / vv)
    return s, t


@lean_jit
def _across(gap, squared, u, v):
    """The gap between the insides of two edges, turned to be normal to both where that is the better direction.

    The difference of two points is wrong by rounding / gap, the cross product of the edges by rounding / sine. Where it
    is far from the difference, a point counts as inside its edge by rounding alone: a corner beside an edge.
    """
    normal = cross(u, v)
    uu, vv, nn, along_normal = dot(u, u), dot(v, v), dot(normal, normal), dot(gap, normal)
    if squared * uu * vv >= nn * max(uu, vv) or 2.0 * along_normal * along_normal < squared * nn:
        return gap
    return scaled(normal, sqrt(squared / nn) * (1.0 if along_normal >= 0.0 else -1.0))


@lean_jit
def _edge_pair(best, a0, a1, b0, b1):
    """The better of `best` and the closest points of two edges."""
    u, v, w = sub(a1, a0), sub(b1, b0), sub(b0, a0)
    s, t = segment_parameters(u, v, w)
    gap = sub(along(w, t, v), scaled(u, s))
    squared = dot(gap, gap)
    if squared >= best[0]:
        return best
    if 0.0 < s < 1.0 and 0.0 < t < 1.0:
        gap = _across(gap, squared, u, v)
    return squared, along(a0, s, u), along(b0, t, v), gap


@lean_jit
def _keeps_apart(best, rounding, a0, a1, a2, b0, b1, b2):
    """Whether the connecting direction of the pair separates the triangles by the pair's whole length."""
    n = best[3]
    gap = min(dot(n, b0), dot(n, b1), dot(n, b2)) - max(dot(n, a0), dot(n, a1), dot(n, a2))
    return gap >= best[0] - rounding * sqrt(best[0])


@lean_jit
def _vertex_face(best, p, a, b, c, normal, sign):
    """The better of `best` and the vertex p with its foot on the face a, b, c; the gap is `sign` (p - foot)."""
    if (
        dot(cross(sub(b, a), sub(p, a)), normal) < 0.0
        or dot(cross(sub(c, b), sub(p, b)), normal) < 0.0
        or dot(cross(sub(a, c), sub(p, c)), normal) < 0.0
    ):
        return best
    gap = scaled(normal, dot(normal, sub(p, a)) / dot(normal, normal))
    squared = dot(gap, gap)
    if squared >= best[0]:
        return best
    foot = sub(p, gap)
    if sign > 0.0:
        return squared, foot, p, gap
    return squared, p, foot, scaled(gap, -1.0)


@lean_jit
def _vertices_face(best, limit, p0, p1, p2, a, b, c, normal, sign):
    """Vertex-face pairs of the three vertices p with one face.

    Returns (best, whether all vertices are surely on one side, whether the search is over: the pair found is surely the
    closest of all, or all are farther from the plane than `limit`).
    """
    nn = dot(normal, normal)
    if nn == 0.0:
        return best, False, False
    h0, h1, h2 = dot(normal, sub(p0, a)), dot(normal, sub(p1, a)), dot(normal, sub(p2, a))
    rounding = SIDE * sqrt(nn) * max(largest(sub(p0, a)), largest(sub(p1, a)), largest(sub(p2, a)))
    if min(h0, h1, h2) > rounding or max(h0, h1, h2) < -rounding:
        # all on one side: only the nearest vertex can be closest, and if its foot is inside, nothing is closer
        before = best[0]
        h0, h1, h2 = abs(h0), abs(h1), abs(h2)
        nearest = p0
        if h1 < h0 and h1 <= h2:
            nearest = p1
        elif h2 < h0:
            nearest = p2
        if min(h0, h1, h2) >= limit * sqrt(nn):
            return NO_PAIR, True, True
        best = _vertex_face(best, nearest, a, b, c, normal, sign)
        return best, True, best[0] < before
    best = _vertex_face(best, p0, a, b, c, normal, sign)
    best = _vertex_face(best, p1, a, b, c, normal, sign)
    best = _vertex_face(best, p2, a, b, c, normal, sign)
    return best, False, False


@lean_jit
def _edges_edge(best, a0, a1, a2, b0, b1):
    """The better of `best` and the pairs of triangle a's three edges with one edge."""
    best = _edge_pair(best, a0, a1, b0, b1)
    best = _edge_pair(best, a1, a2, b0, b1)
    return _edge_pair(best, a2, a0, b0, b1)


@lean_jit
def _closest_features(limit, rounding, a0, a1, a2, b0, b1, b2):
    """(squared distance, point on a, point on b, gap from a to b); squared distance 0 where they cross.

    NO_PAIR where a plane shows that the distance is not below `limit`.
    """
    normal_a = triangle_normal(sub(a1, a0), sub(a2, a0))
    normal_b = triangle_normal(sub(b1, b0), sub(b2, b0))
    best, beside_b, done = _vertices_face(NO_PAIR, limit, a0, a1, a2, b0, b1, b2, normal_b, -1.0)
    if done:
        return best
    best, beside_a, done = _vertices_face(best, limit, b0, b1, b2, a0, a1, a2, normal_a, 1.0)
    if done:
        return best
    if not (beside_a or beside_b):
        found, point = crossing_point(a0, a1, a2, b0, b1, b2)
        if found:
            return 0.0, point, point, ZERO
    before = best[0]
    best = _edges_edge(best, a0, a1, a2, b0, b1)
    if best[0] < before and _keeps_apart(best, rounding, a0, a1, a2, b0, b1, b2):
        return best
    before = best[0]
    best = _edges_edge(best, a0, a1, a2, b1, b2)
    if best[0] < before and _keeps_apart(best, rounding, a0, a1, a2, b0, b1, b2):
        return best
    return _edges_edge(best, a0, a1, a2, b2, b0)


@lean_jit
def closer_points(limit, a0, a1, a2, b0, b1, b2):
    """As `triangle_points`, or distance inf where it is cheaply shown that it is not below `limit` [m]."""
    origin = a0
    a1, a2 = sub(a1, origin), sub(a2, origin)
    b0, b1, b2 = sub(b0, origin), sub(b1, origin), sub(b2, origin)
    touch = TOUCH * max(largest(a1), largest(a2), largest(b0), largest(b1), largest(b2))
    squared, p, q, gap = _closest_features(limit, 0.5 * touch, ZERO, a1, a2, b0, b1, b2)
    if squared == inf:
        return NO_PAIR
    distance = length(gap)
    if distance <= touch:
        middle = add(origin, scaled(add(p, q), 0.5))
        return 0.0, middle, middle, ZERO
    return distance, add(origin, p), add(origin, q), scaled(gap, 1.0 / distance)


@lean_jit
def triangle_points(a0, a1, a2, b0, b1, b2):
    """Closest points of two triangles, each vertex a tuple (x, y, z) [m].

    Returns (distance, point on a, point on b, direction), the direction a unit vector from a to b. Triangles that cross
    or touch have distance exactly 0, one common point, and direction zero. Never NaN for coordinates below 1e70.
    """
    return closer_points(inf, a0, a1, a2, b0, b1, b2)
