"""Distance, closest points and normal of two shapes of which none is a mesh (docs/shapes.md).

    curved_gap(kind_a, size_a, axis_a, x_a, R_a, kind_b, size_b, axis_b, x_b, R_b)
        -> (distance, point_a, point_b, normal)

kind: PLANE, SPHERE, CAPSULE, CYLINDER or PIPE; size (4,) lengths [m]; axis (3,) unit, body frame (`curved_kinds`: what
they mean; those of a sphere are not read); x (3,) centre [m], world; R (3, 3) body to world. Tuples do, and rows of
arrays. Out: the distance [m], at most 0 where the bodies overlap; of spheres, capsules and planes, and of a sphere in
or beside a cylinder or pipe, it is then minus the depth. The points lie on the surfaces, world [m]. The normal is a
unit vector from a to b: moving b along it makes the distance grow; it is right also where bodies touch.

Bodies may be in the bore of a pipe or outside of it. A plane and a pipe see a pipe's outside alone. A capsule or
cylinder whose centre is in the bore of a closed pipe is inside. `is_known` tells which pairs have no answer: two
planes, and a cylinder with an open pipe.

    segment_pipe, closest_of_cylinders, ... of the other curved_*.py do the work, each in the frame of its first body.
"""

from math import inf

from comotion_server.kernels.curved_bore import cylinder_in_bore, pipe_segment
from comotion_server.kernels.curved_cores import round_gap, square_to
from comotion_server.kernels.curved_cylinders import closest_of_cylinders, cylinders_normal, way_apart
from comotion_server.kernels.curved_kinds import (
    CAPS,
    CAPSULE,
    CYLINDER,
    HALF,
    HALF_LENGTH,
    OUTER,
    PIPE,
    PLANE,
    RADIUS,
)
from comotion_server.kernels.curved_points import cylinder_distance, is_in_bore, lowest_of_cylinder
from comotion_server.kernels.curved_search import lowest_on_segment
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import ZERO, add, along, dot, rotated, scaled, sub


@lean_jit
def is_known(kind_a, size_a, kind_b, size_b):
    """Whether `curved_gap` has an answer for two shapes."""
    if kind_a > kind_b:
        kind_a, size_a, kind_b, size_b = kind_b, size_b, kind_a, size_a
    if kind_a == CYLINDER and kind_b == PIPE:
        return size_b[CAPS] > 0.0
    return kind_b > PLANE


@lean_jit
def outline(kind, size):
    """(radius, half length) of the solid cylinder that a cylinder or pipe is from outside."""
    return (size[OUTER], size[HALF]) if kind == PIPE else (size[RADIUS], size[HALF_LENGTH])


@lean_jit
def core(kind, size, u):
    """Half the segment of a sphere or capsule, as a vector [m]."""
    return scaled(u, size[HALF_LENGTH]) if kind == CAPSULE else ZERO


@lean_jit
def _plane_and(n, kind, size, u, D):
    """A plane through the origin, normal n, and anything."""
    if kind <= CAPSULE:
        M, rise = core(kind, size, u), dot(n, u)
        low = ZERO
        if abs(rise) > 4e-16:
            low = scaled(M, -1.0 if rise > 0.0 else 1.0)
        q = along(add(D, low), -size[RADIUS], n)
        gap = dot(n, add(D, low)) - size[RADIUS]
    else:
        r, h = outline(kind, size)
        q = add(D, lowest_of_cylinder(r, h, u, n))
        gap = dot(n, q)
    return gap, along(q, -gap, n), q, n


@lean_jit
def _round_and_cylinder(r, M, r_b, h_b, u_b, D):
    """A sphere or capsule and a cylinder."""
    P = scaled(D, -1.0)
    t = lowest_on_segment(r_b, h_b, u_b, P, M, -1.0, 1.0)
    p = scaled(M, t)
    far, n = cylinder_distance(r_b, h_b, u_b, sub(p, D))
    n = square_to(n, M, t)
    return far - r, along(p, -r, n), along(p, -far, n), scaled(n, -1.0)


@lean_jit
def _round_and_pipe(r, M, size, u, D):
    """A sphere or capsule and a pipe."""
    far, t, n = pipe_segment(size, u, scaled(D, -1.0), M)
    p = scaled(M, t)
    return far - r, along(p, -r, n), along(p, -far, n), scaled(n, -1.0)


@lean_jit
def _cylinders(r_a, h_a, u_a, r_b, h_b, u_b, D):
    """Two solid cylinders."""
    far, p, q = closest_of_cylinders(r_a, h_a, u_a, r_b, h_b, u_b, D)
    if far > 0.0:
        return far, p, q, cylinders_normal(r_a, h_a, u_a, r_b, h_b, u_b, D, p, q)
    gap, n = way_apart(r_a, h_a, u_a, r_b, h_b, u_b, D)
    middle = scaled(add(p, q), 0.5)
    return gap, along(middle, -0.5 * gap, n), along(middle, 0.5 * gap, n), n


@lean_jit
def _cylinder_and_pipe(size_a, u_a, size, u, D):
    """A cylinder and a closed pipe, inside or outside of it."""
    r, h = size_a[RADIUS], size_a[HALF_LENGTH]
    if not is_in_bore(size, u, scaled(D, -1.0)):
        return _cylinders(r, h, u_a, size[OUTER], size[HALF], u, D)
    far, P, n = cylinder_in_bore(size, u, r, h, u_a, scaled(D, -1.0))
    p = add(P, D)
    return far, p, along(p, -far, n), scaled(n, -1.0)


@lean_jit
def _in_order(kind_a, size_a, u_a, kind_b, size_b, u_b, D):
    """Of two shapes with kind_a <= kind_b; points from the centre of a."""
    if kind_a == PLANE:
        if kind_b == PLANE:
            return inf, ZERO, ZERO, ZERO
        return _plane_and(u_a, kind_b, size_b, u_b, D)
    if kind_a <= CAPSULE:
        M = core(kind_a, size_a, u_a)
        if kind_b <= CAPSULE:
            return round_gap(size_a[RADIUS], M, size_b[RADIUS], core(kind_b, size_b, u_b), D)
        if kind_b == CYLINDER:
            return _round_and_cylinder(size_a[RADIUS], M, size_b[RADIUS], size_b[HALF_LENGTH], u_b, D)
        return _round_and_pipe(size_a[RADIUS], M, size_b, u_b, D)
    if kind_a == CYLINDER and kind_b == PIPE:
        return _cylinder_and_pipe(size_a, u_a, size_b, u_b, D)
    r_a, h_a = outline(kind_a, size_a)
    r_b, h_b = outline(kind_b, size_b)
    return _cylinders(r_a, h_a, u_a, r_b, h_b, u_b, D)


@lean_jit
def curved_gap(kind_a, size_a, axis_a, x_a, R_a, kind_b, size_b, axis_b, x_b, R_b):
    """(distance, point_a, point_b, normal from a to b): see the top of this file."""
    u_a, u_b, D = rotated(R_a, axis_a), rotated(R_b, axis_b), sub(x_b, x_a)
    if kind_a <= kind_b:
        distance, p, q, n = _in_order(kind_a, size_a, u_a, kind_b, size_b, u_b, D)
    else:
        distance, q, p, n = _in_order(kind_b, size_b, u_b, kind_a, size_a, u_a, scaled(D, -1.0))
        p, q, n = add(p, D), add(q, D), scaled(n, -1.0)
    return distance, add(p, x_a), add(q, x_a), n
