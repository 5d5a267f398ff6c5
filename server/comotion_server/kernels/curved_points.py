"""A point against a cylinder, a pipe, or the inside of a closed pipe: closed forms in the plane of point and axis.

Legend: u unit axis; P point from the shape's centre [m]; z along the axis and rho across it; r, h radius and half
length; `outward` the unit vector across the axis to the point, zero on the axis.
"""

from math import copysign, hypot

from comotion_server.kernels.curved_kinds import CAPS, HALF, INNER, OUTER
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, scaled, unit


@lean_jit
def part_across(v, u):
    """The part of a vector across u; taken twice, it is at right angles to u however small it is."""
    w = along(v, -dot(v, u), u)
    return along(w, -dot(w, u), u)


@lean_jit
def profile(u, P):
    """(z, rho, outward) of a point."""
    z, across = dot(u, P), part_across(P, u)
    rho = length(across)
    return z, rho, scaled(across, 1.0 / rho) if rho > 0.0 else ZERO


@lean_jit
def some_perpendicular(u):
    """A unit vector normal to u: across the coordinate axis that u is farthest from."""
    x, y, z = abs(u[0]), abs(u[1]), abs(u[2])
    if x <= y and x <= z:
        return unit((0.0, -u[2], u[1]))
    if y <= z:
        return unit((u[2], 0.0, -u[0]))
    return unit((-u[1], u[0], 0.0))


@lean_jit
def beyond(r, h, u, P):
    """(a, b, outward): how far a point lies outside a solid cylinder, across and along its axis; 0 inside."""
    z, rho, outward = profile(u, P)
    return max(rho - r, 0.0), copysign(max(abs(z) - h, 0.0), z), outward


@lean_jit
def from_cylinder(r, h, u, P):
    """The vector to a point from the nearest point of a solid cylinder; zero inside."""
    a, b, outward = beyond(r, h, u, P)
    return along(scaled(outward, a), b, u)


@lean_jit
def slope(r, h, u, P, M):
    """Half the rate of the squared distance from a solid cylinder where the point moves at M; rounding counts as 0."""
    a, b, outward = beyond(r, h, u, P)
    rate = a * dot(outward, M) + b * dot(u, M)
    return rate if abs(rate) > 4e-16 * (a + abs(b)) * length(M) else 0.0


@lean_jit
def is_in_bore(size, u, P):
    """Whether a point lies in the bore of a pipe, between its ends."""
    z, rho, _ = profile(u, P)
    return rho < size[INNER] and abs(z) < size[HALF]


@lean_jit
def cavity_depth(r, h, u, P):
    """(distance to the wall or an end, unit normal out of the wall) of a point in a closed cylinder, signed."""
    z, rho, outward = profile(u, P)
    if h - abs(z) < r - rho:
        return h - abs(z), scaled(u, copysign(1.0, -z))
    if rho > 0.0:
        return r - rho, scaled(outward, -1.0)
    return r - rho, some_perpendicular(u)


@lean_jit
def _cylinder_depth(r, h, u, z, rho, outward):
    """As `cylinder_distance` inside of it."""
    if h - abs(z) < r - rho:
        return abs(z) - h, scaled(u, copysign(1.0, z))
    return rho - r, outward if rho > 0.0 else some_perpendicular(u)


@lean_jit
def cylinder_distance(r, h, u, P):
    """(signed distance, unit normal from the cylinder to the point)."""
    z, rho, outward = profile(u, P)
    a, b = rho - r, abs(z) - h
    if a <= 0.0 and b <= 0.0:
        return _cylinder_depth(r, h, u, z, rho, outward)
    if b <= 0.0:
        return a, outward
    if a <= 0.0:
        return b, scaled(u, copysign(1.0, z))
    far = hypot(a, b)
    return far, along(scaled(outward, a / far), copysign(b / far, z), u)


@lean_jit
def pipe_distance(size, u, P):
    """(signed distance, unit normal from the pipe to the point); in a closed pipe of what is nearest, wall or end."""
    z, rho, outward = profile(u, P)
    r, h = size[INNER], size[HALF]
    if rho >= r and (abs(z) >= h or rho >= size[OUTER]):
        return cylinder_distance(size[OUTER], h, u, P)
    if rho < r:
        if size[CAPS] > 0.0:
            return cavity_depth(r, h, u, P) if abs(z) < h else cylinder_distance(size[OUTER], h, u, P)
        inward = scaled(outward, -1.0) if rho > 0.0 else some_perpendicular(u)
        if abs(z) <= h:
            return r - rho, inward
        far = hypot(r - rho, abs(z) - h)
        return far, along(scaled(inward, (r - rho) / far), copysign((abs(z) - h) / far, z), u)
    into_bore, outside, ends = r - rho, rho - size[OUTER], abs(z) - h
    if into_bore >= outside and into_bore >= ends:
        return into_bore, scaled(outward, -1.0)
    if outside >= ends:
        return outside, outward
    return ends, scaled(u, copysign(1.0, z))


@lean_jit
def lowest_of_cylinder(r, h, u, n):
    """The point of a solid cylinder farthest against the unit vector n; the middle of what is level."""
    rise = dot(n, u)
    across = part_across(n, u)
    if abs(rise) < 4e-16:
        return scaled(across, -r / length(across))
    steep = length(cross(u, n))
    end = scaled(u, copysign(h, -rise))
    return end if steep < 4e-16 else add(end, scaled(across, -r / length(across)))
