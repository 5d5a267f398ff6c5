"""Points at which a sphere touches a sphere, a plane or a pipe, and their motion (docs/spheres.md).

The arms of the sphere lie along the normal, so only the motion of its centre counts. A sphere in a pipe with closed
ends may touch its wall and both ends, which are parts of their own. Legend: D offset of the sphere's centre from the
other body's, V its velocity against that body's centre, world; e axis.
"""

from math import inf

from comotion_server.kernels.contacts import BALL_EDGE, FULL, SMOOTH
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.pipe_impact import is_in_bore, pipe_gap
from comotion_server.kernels.solids import CAPS, HALF, INNER, OUTER, PIPE, PLANE, RADIUS, SPHERE
from comotion_server.kernels.sphere_impact import direction_of
from comotion_server.kernels.vectors import ZERO, along, cross, dot, length, row, scaled, sub

NEAREST, WALL, TOP, BOTTOM, PARTS = (
    0,
    1,
    2,
    3,
    4,
)  # of a body: its nearest point; of a closed bore: its wall and its ends


@lean_jit
def sphere_of(solids, a, b):
    """(the sphere, the other body) of a pair; of two spheres b is the sphere."""
    return (b, a) if solids.kind[b] == SPHERE else (a, b)


@lean_jit
def is_bent(solids, contacts, i):
    """Whether the normal of row i turns where the bodies slide on each other without turning."""
    a, b, kind = contacts.bodies[i, 0], contacts.bodies[i, 1], contacts.kind[i]
    if kind >= BALL_EDGE:
        return True
    return kind == SMOOTH and solids.kind[a] != PLANE and solids.kind[b] != PLANE


@lean_jit
def part_gap(solids, sphere, other, part, D, u):
    """(gap [m], unit normal from the other body to the sphere) of one part; u: `direction_of` the other body."""
    r, kind = solids.size[sphere, RADIUS], solids.kind[other]
    if kind == PLANE:
        return dot(u, D) - r, u
    if kind == SPHERE:
        far = length(D)
        n = scaled(D, 1.0 / far) if far > 0.0 else (1.0, 0.0, 0.0)
        return far - (r + solids.size[other, RADIUS]), n
    size = solids.size[other]
    if part == NEAREST:
        return pipe_gap(size, u, D, r)
    z = dot(u, D)
    if part == WALL:
        across = along(D, -z, u)
        rho = length(across)
        return size[INNER] - r - rho, scaled(across, -1.0 / rho) if rho > 0.0 else ZERO
    if part == TOP:
        return size[HALF] - r - z, scaled(u, -1.0)
    return size[HALF] - r + z, u


@lean_jit
def _axis(solids, R, other):
    return direction_of(solids, R[other], other) if solids.kind[other] != SPHERE else ZERO


@lean_jit
def smooth_manifold(solids, a, b, x, R, reach, contacts, first):
    """`manifold` of a sphere and a sphere, plane or pipe: how many rows, or FULL."""
    sphere, other = sphere_of(solids, a, b)
    D, u, count, parts = sub(row(x, sphere), row(x, other)), _axis(solids, R, other), 0, (NEAREST, NEAREST + 1)
    if solids.kind[other] == PIPE and solids.size[other, CAPS] > 0.0 and is_in_bore(solids.size[other], u, D):
        parts = (WALL, PARTS)
    for part in range(parts[0], parts[1]):
        gap, n = part_gap(solids, sphere, other, part, D, u)
        if gap > reach or n == ZERO:
            continue
        i = first + count
        if i >= len(contacts.gap):
            return FULL
        contacts.bodies[i, 0], contacts.bodies[i, 1] = a, b
        contacts.kind[i] = SMOOTH
        contacts.feature[i, :] = -1
        contacts.feature[i, 0] = part
        _write(solids, contacts, i, sphere, other, D, gap, n)
        count += 1
    return count


@lean_jit
def _write(solids, contacts, i, sphere, other, D, gap, n):
    """Normal, arms and gap of row i, n pointing to the sphere."""
    r = solids.size[sphere, RADIUS]
    arm = scaled(n, -r)
    foot = scaled(n, solids.size[other, RADIUS]) if solids.kind[other] == SPHERE else along(D, -(r + gap), n)
    if sphere == contacts.bodies[i, 1]:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = n, foot, arm
    else:
        contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i] = scaled(n, -1.0), arm, foot
    contacts.gap[i] = gap


@lean_jit
def _pipe_bias(size, part, e, D, V, n):
    """What the velocity V of the sphere's centre adds to the second derivative of its distance from a pipe at rest.

    rho'' = a_rho + v_t^2 / rho, and where a rim is nearest, g = |(rho, z) - rim| bends with the motion across it, too.
    """
    if part >= TOP:
        return 0.0
    z, vz = dot(e, D), dot(e, V)
    across, v = along(D, -z, e), along(V, -vz, e)
    rho = length(across)
    if rho == 0.0:
        return 0.0
    beyond = abs(z) - size[HALF]
    outward = scaled(across, 1.0 / rho)
    v_rho, n_rho, n_z = dot(outward, v), dot(outward, n), dot(e, n)
    bias = n_rho * max(dot(v, v) - v_rho * v_rho, 0.0) / rho
    if part == NEAREST and beyond > 0.0 and n_rho != 0.0:
        edge = size[OUTER] if rho > size[OUTER] else size[INNER]
        sideways = n_z * v_rho - n_rho * vz
        far = (rho - edge) * n_rho + (beyond if z > 0.0 else -beyond) * n_z
        bias += sideways * sideways / far if far > 0.0 else 0.0
    return bias


@lean_jit
def refresh_smooth(solids, contacts, i, x, v, R, w):
    """`refresh` of a SMOOTH row; pipes do not turn."""
    a, b = contacts.bodies[i, 0], contacts.bodies[i, 1]
    sphere, other = sphere_of(solids, a, b)
    D, u, part = sub(row(x, sphere), row(x, other)), _axis(solids, R, other), contacts.feature[i, 0]
    gap, n = part_gap(solids, sphere, other, part, D, u)
    _write(solids, contacts, i, sphere, other, D, gap, n)
    V = sub(row(v, sphere), row(v, other))
    if solids.kind[other] == PLANE:  # the sphere's centre against the material point of the plane below it
        spin, reach = row(w, other), gap + solids.size[sphere, RADIUS]
        foot = along(D, -reach, n)
        turning = cross(spin, n)
        V = sub(V, cross(spin, foot))
        inward = cross(spin, cross(spin, foot))
        bias = -dot(n, inward) + 2.0 * dot(turning, V) - reach * dot(turning, turning)
    elif solids.kind[other] == SPHERE:
        opening = dot(n, V)
        bias = max(dot(V, V) - opening * opening, 0.0) / length(D)
    else:
        bias = _pipe_bias(solids.size[other], part, u, D, V, n)
    return inf, dot(n, V), bias
