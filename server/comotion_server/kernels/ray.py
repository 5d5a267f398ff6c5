"""Where a ray leaves a closed mesh, and whether its origin is inside.

Inside means that outward crossings outnumber inward ones along the ray. Where the ray passes so near to an edge, or so
flat to a face, that the count could be wrong, the solid angle of the whole surface decides instead (van Oosterom and
Strackee 1983): slow, but without exceptions.
"""

from math import atan2, inf, pi

from comotion_server.kernels.jit import jit
from comotion_server.kernels.vectors import cross, dot, largest, length, row, sub

DOUBT = 1e-12  # relative margin to an edge, a grazing face or the origin within which a crossing is not counted on


@jit
def _meets_box(m, node, p, d):
    """Whether the ray from p along d meets a node's box."""
    c = sub(p, row(m.centre, node))
    near, far = 0.0, inf
    for k in range(3):
        axis = row(m.axes[node], k)
        at, speed, half = dot(axis, c), dot(axis, d), m.half[node, k]
        half += DOUBT * (abs(at) + half)
        if abs(speed) < DOUBT:
            if abs(at) > half:
                return False
        else:
            one, other = (-half - at) / speed, (half - at) / speed
            near, far = max(near, min(one, other)), min(far, max(one, other))
    return near <= far


@jit
def _crossing(p, d, a, b, c):
    """(distance along the ray, distance to the plane, outward 1 or inward -1 or none 0, in doubt) for one triangle."""
    a, b, c = sub(a, p), sub(b, p), sub(c, p)
    normal = cross(sub(b, a), sub(c, a))
    size, reach = length(normal), max(largest(a), largest(b), largest(c))
    if size == 0.0:
        return 0.0, 0.0, 0, False
    speed, height = dot(normal, d), dot(normal, a)
    if abs(speed) <= 1e-9 * size:  # flat to the ray: it can only pass through edges, which the neighbours see
        return 0.0, 0.0, 0, abs(height) <= 1e-9 * size * reach
    sign = 1.0 if speed > 0.0 else -1.0
    least = min(sign * dot(cross(a, b), d), sign * dot(cross(b, c), d), sign * dot(cross(c, a), d))
    margin = DOUBT * reach * reach
    distance = height / speed
    if least < -margin or distance < -DOUBT * reach:
        return 0.0, 0.0, 0, False
    return max(distance, 0.0), abs(height) / size, int(sign), least <= margin or distance <= DOUBT * reach


@jit
def _solid_angle(a, b, c):
    """Solid angle [sr] of a triangle seen from the origin, positive where its outward side is turned away."""
    la, lb, lc = length(a), length(b), length(c)
    return 2.0 * atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)


@jit
def winding_number(m, shape, p):
    """How often the surface of a shape goes around the point p (body frame): 1 inside, 0 outside, between on it."""
    total = 0.0
    for t in range(m.triangle_start[shape], m.triangle_start[shape + 1]):
        a, b, c = (
            row(m.vertices, m.triangles[t, 0]),
            row(m.vertices, m.triangles[t, 1]),
            row(m.vertices, m.triangles[t, 2]),
        )
        total += _solid_angle(sub(a, p), sub(b, p), sub(c, p))
    return total / (4.0 * pi)


@jit
def way_out(m, shape, p, d, stack):
    """Distance [m] from the point p to the plane of the face where the ray along the unit vector d leaves the shape.

    Everything in the body frame. Negative where p is not inside. stack (STACK_SIZE, 2) int64 is work space.
    """
    return way_out_along(m, shape, p, d, stack)[0]


@jit
def way_out_along(m, shape, p, d, stack):
    """(as `way_out`, distance [m] along the ray to where it leaves)."""
    if not _meets_box(m, m.root[shape], p, d):
        return -1.0, 0.0
    stack[0, 0] = m.root[shape]
    top, nearest, depth, crossings, doubt = 1, inf, -1.0, 0, False
    while top > 0:
        top -= 1
        node = stack[top, 0]
        if not _meets_box(m, node, p, d):
            continue
        if m.child[node] >= 0:
            stack[top, 0], stack[top + 1, 0] = m.child[node], m.child[node] + 1
            top += 2
            continue
        for i in range(m.first[node], m.first[node] + m.entries[node]):
            t = m.leaf_triangles[i]
            distance, to_plane, sign, in_doubt = _crossing(
                p,
                d,
                row(m.vertices, m.triangles[t, 0]),
                row(m.vertices, m.triangles[t, 1]),
                row(m.vertices, m.triangles[t, 2]),
            )
            crossings += sign
            doubt = doubt or in_doubt
            if sign > 0 and distance < nearest:
                nearest, depth = distance, to_plane
    inside = winding_number(m, shape, p) > 0.5 if doubt else crossings > 0
    return (depth, nearest) if inside else (-1.0, 0.0)
