"""Two solid cylinders: the nearest points of the four end discs to the other cylinder, and of side to side.

The closest points lie in an end disc of one of them, or on both sides; discs are searched through (`curved_search`),
and the sides are nearest where the axes are. Every pair of points that is compared lies on both cylinders, so an error
can only lengthen the distance, and only in second order. Where the cylinders all but touch, the direction between the
points is rounding: the normal then comes from the faces, sides or rims that the points lie on.

Legend: r, h, u radius, half length and axis of a and b; D centre of b from the centre of a; all points from a's centre.
"""

from math import copysign, inf

from comotion_server.kernels.curved_cores import core_parameters
from comotion_server.kernels.curved_points import from_cylinder, part_across, profile, some_perpendicular
from comotion_server.kernels.curved_search import lowest_on_disc
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, scaled, sub, unit

LEVEL = 1e-14  # sine of an angle, and share of a length, that is taken as rounding
SLIGHT = 1e-8  # angle whose square is rounding: tangents nearer to parallel than this count as one


@lean_jit
def _across(v, u):
    """The direction of v across u; zero where there is none."""
    w = part_across(v, u)
    return unit(w) if dot(w, w) > LEVEL * LEVEL * dot(v, v) else ZERO


@lean_jit
def _nearest_of_disc(r, h, u, r_disc, v, c):
    """The point nearest to a cylinder about the origin on the disc about c of radius r_disc, normal to v."""
    e2 = _across(from_cylinder(r, h, u, c), v)
    if e2 == ZERO:
        e2 = _across(c, v)
    if e2 == ZERO:
        e2 = _across(u, v)
    if e2 == ZERO:
        e2 = some_perpendicular(v)
    return lowest_on_disc(r, h, u, c, scaled(cross(v, e2), r_disc), scaled(e2, r_disc))


@lean_jit
def _sides(r_a, h_a, u_a, r_b, h_b, u_b, D):
    """(distance, p, q) where the axes are nearest."""
    _, t = core_parameters(scaled(u_a, h_a), scaled(u_b, h_b), D)
    q = along(D, t * h_b, u_b)
    p = sub(q, from_cylinder(r_a, h_a, u_a, q))
    way = from_cylinder(r_b, h_b, u_b, sub(p, D))
    return length(way), p, sub(p, way)


@lean_jit
def _outward(n, out, up):
    """The direction n without what rounding turned inward of a rim: out, up are normals of its side and its face."""
    n = along(along(n, -min(dot(n, out), 0.0), out), -min(dot(n, up), 0.0), up)
    return unit(n) if n != ZERO else out


@lean_jit
def _rims_normal(way, out_a, up_a, out_b, up_b, size):
    """The normal of two rims that are nearest, a `way` apart; out, up: of the side and the face that meet there."""
    tangent = cross(up_a, out_a)
    across = cross(tangent, cross(up_b, out_b))
    if length(across) > max(length(way) / size, SLIGHT):
        n = scaled(unit(across), 1.0 if dot(across, way) >= 0.0 else -1.0)
    else:
        n = along(way, -dot(way, tangent), tangent)
    n = _outward(n, out_a, up_a)
    return scaled(_outward(scaled(n, -1.0), out_b, up_b), -1.0)


@lean_jit
def _feature(r, h, u, P):
    """(how far a point on a cylinder is from the rims, its unit normal there); at most 0 on a rim, to rounding."""
    z, rho, outward = profile(u, P)
    grain = LEVEL * (r + h)
    if h - abs(z) >= r - rho:
        return h - abs(z) - grain, outward
    return r - rho - grain, scaled(u, copysign(1.0, z))


@lean_jit
def cylinders_normal(r_a, h_a, u_a, r_b, h_b, u_b, D, p, q):
    """The unit normal from a to b at their closest points p and q: of the face or side that is met most surely."""
    from_rim_a, n_a = _feature(r_a, h_a, u_a, q)
    from_rim_b, n_b = _feature(r_b, h_b, u_b, sub(p, D))
    if max(from_rim_a, from_rim_b) > 0.0:
        return n_a if from_rim_a >= from_rim_b else scaled(n_b, -1.0)
    z_a, _, out_a = profile(u_a, p)
    z_b, _, out_b = profile(u_b, sub(q, D))
    up_a, up_b = scaled(u_a, copysign(1.0, z_a)), scaled(u_b, copysign(1.0, z_b))
    return _rims_normal(sub(q, p), out_a, up_a, out_b, up_b, max(r_a, r_b))


@lean_jit
def closest_of_cylinders(r_a, h_a, u_a, r_b, h_b, u_b, D):
    """(distance, p, q) of the closest points of two cylinders; distance 0 where they overlap."""
    best = _sides(r_a, h_a, u_a, r_b, h_b, u_b, D)
    other = _sides(r_b, h_b, u_b, r_a, h_a, u_a, scaled(D, -1.0))
    if other[0] < best[0]:
        best = other[0], add(other[2], D), add(other[1], D)
    for end in (-1.0, 1.0):
        q = _nearest_of_disc(r_a, h_a, u_a, r_b, u_b, along(D, end * h_b, u_b))
        way = from_cylinder(r_a, h_a, u_a, q)
        if length(way) < best[0]:
            best = length(way), sub(q, way), q
        p = _nearest_of_disc(r_b, h_b, u_b, r_a, u_a, sub(scaled(u_a, end * h_a), D))
        way = from_cylinder(r_b, h_b, u_b, p)
        if length(way) < best[0]:
            best = length(way), add(p, D), add(sub(p, way), D)
    return best


@lean_jit
def width(r, h, u, n):
    """How far a cylinder reaches from its centre along the unit vector n."""
    return h * abs(dot(u, n)) + r * length(cross(u, n))


@lean_jit
def _wider(best, n, r_a, h_a, u_a, r_b, h_b, u_b, D):
    if n == ZERO:
        return best
    n = n if dot(n, D) >= 0.0 else scaled(n, -1.0)
    gap = dot(n, D) - (width(r_a, h_a, u_a, n) + width(r_b, h_b, u_b, n))
    return (gap, n) if gap > best[0] else best


@lean_jit
def way_apart(r_a, h_a, u_a, r_b, h_b, u_b, D):
    """(gap, at most 0, and direction) along which overlapping cylinders come apart, the best of a few."""
    best = -inf, u_a
    for n in (u_a, u_b, unit(cross(u_a, u_b)), _across(D, u_a), _across(D, u_b)):
        best = _wider(best, n, r_a, h_a, u_a, r_b, h_b, u_b, D)
    return min(best[0], 0.0), best[1]
