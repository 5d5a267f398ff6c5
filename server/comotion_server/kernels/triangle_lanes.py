"""Lower bounds of the distance of one triangle to eight, eight at a time (see `lanes`).

The closest pair of features (P5: 9 edge pairs, 6 vertex-face pairs) is found quickly and not to the last digit; the gap
between the triangles' vertices along its direction is a bound for any direction, and the distance for the right one. So
where it does not rule a pair out, `triangle_distance` has the last word.

Legend: the one triangle has corners a, b, c; a lane's has d, e, f, relative to a. `best` is (squared distance, gap).
"""

from math import sqrt

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.lanes import CORNERS, NONE
from comotion_server.kernels.vectors import cross, dot, sub

FLAT = 1e-12  # squared sine of two edges below which they count as parallel
TINY = 1e-280  # keeps quotients of what has no length finite
NO_AREA = 1e270  # a quotient by TINY is larger


@lean_jit
def _clamped(value):
    return min(max(value, 0.0), 1.0)


@lean_jit
def _taken(best, take, squared, x, y, z):
    """Another gap in the place of `best`, or not."""
    return (
        squared if take else best[0],
        x if take else best[1],
        y if take else best[2],
        z if take else best[3],
    )


@lean_jit
def _edges(best, u, uu, v, vv, w):
    """The lesser of `best` and the gap of the segments s u and w + t v; uu, vv: their squared lengths."""
    uv, uw, vw = dot(u, v), dot(u, w), dot(v, w)
    denominator = uu * vv - uv * uv
    apart = denominator > FLAT * uu * vv
    s = _clamped((uw * vv - vw * uv) / (denominator if apart else 1.0))
    t = _clamped((s * uv - vw) / vv)
    s = _clamped((t * uv + uw) / uu)
    x, y, z = w[0] + t * v[0] - s * u[0], w[1] + t * v[1] - s * u[1], w[2] + t * v[2] - s * u[2]
    squared = x * x + y * y + z * z
    return _taken(best, squared < best[0], squared, x, y, z)


@lean_jit
def _foot(best, p, q, r, normal, over, mp, mq, mr):
    """The lesser of `best` and the gap of a point to a face; p, q, r: the point relative to the corners.

    normal of the face, over: 1 / its square; mp, mq, mr: inward normals of the edges that start in the corners.
    """
    inside = (dot(p, mp) >= 0.0) & (dot(q, mq) >= 0.0) & (dot(r, mr) >= 0.0)
    height = dot(p, normal)
    squared, k = height * height * over, height * over
    take = inside & (over < NO_AREA) & (squared < best[0])
    return _taken(best, take, squared, k * normal[0], k * normal[1], k * normal[2])


@lean_jit
def _corner(blocks, node, row, lane, origin):
    return (
        blocks[node, row, lane] - origin[0],
        blocks[node, row + 1, lane] - origin[1],
        blocks[node, row + 2, lane] - origin[2],
    )


@lean_jit
def triangle_bounds(blocks, node, corners, bounds):
    """Lower bounds (8,) of the distance of one triangle to the eight in blocks[node].

    corners (9,): of the one, in the frame of the eight.
    """
    a = corners[0], corners[1], corners[2]
    b = corners[3] - a[0], corners[4] - a[1], corners[5] - a[2]
    c = corners[6] - a[0], corners[7] - a[1], corners[8] - a[2]
    bc, ca = sub(c, b), (-c[0], -c[1], -c[2])
    bb, cc, dd = dot(b, b) + TINY, dot(bc, bc) + TINY, dot(c, c) + TINY
    normal = cross(b, c)
    square = dot(normal, normal)
    over = 1.0 / (square + TINY)
    ma, mb, mc = cross(normal, b), cross(normal, bc), cross(normal, ca)
    for l in range(blocks.shape[2]):
        d, e, f = (
            _corner(blocks, node, CORNERS, l, a),
            _corner(blocks, node, CORNERS + 3, l, a),
            _corner(blocks, node, CORNERS + 6, l, a),
        )
        u, v, w = sub(e, d), sub(f, e), sub(d, f)
        uu, vv, ww = dot(u, u) + TINY, dot(v, v) + TINY, dot(w, w) + TINY
        db, eb, fb = sub(d, b), sub(e, b), sub(f, b)
        dc, ec, fc = sub(d, c), sub(e, c), sub(f, c)
        best = (1e300, 0.0, 0.0, 0.0)
        best = _edges(best, b, bb, u, uu, d)
        best = _edges(best, b, bb, v, vv, e)
        best = _edges(best, b, bb, w, ww, f)
        best = _edges(best, bc, cc, u, uu, db)
        best = _edges(best, bc, cc, v, vv, eb)
        best = _edges(best, bc, cc, w, ww, fb)
        best = _edges(best, ca, dd, u, uu, dc)
        best = _edges(best, ca, dd, v, vv, ec)
        best = _edges(best, ca, dd, w, ww, fc)
        best = _foot(best, d, db, dc, normal, over, ma, mb, mc)
        best = _foot(best, e, eb, ec, normal, over, ma, mb, mc)
        best = _foot(best, f, fb, fc, normal, over, ma, mb, mc)
        other = cross(u, v)
        squared = dot(other, other)
        under = 1.0 / (squared + TINY)
        mu, mv, mw = cross(u, other), cross(v, other), cross(w, other)  # outward: the differences are reversed, too
        best = _foot(best, d, e, f, other, under, mu, mv, mw)
        best = _foot(best, db, eb, fb, other, under, mu, mv, mw)
        best = _foot(best, dc, ec, fc, other, under, mu, mv, mw)
        n = best[1], best[2], best[3]
        near = min(dot(n, d), dot(n, e), dot(n, f))
        far = max(0.0, dot(n, b), dot(n, c))
        bounds[l] = (near - far) / sqrt(best[0] + TINY) if best[0] > TINY else NONE
