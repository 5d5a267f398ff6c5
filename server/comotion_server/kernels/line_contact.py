"""The middle line of a capsule over an edge or a corner of the ground, as in `ball_contact` (docs/shapes.md, 5).

Legend: u the capsule's axis, D its centre from the ground's, e an edge from p, all world; t and s along u and e [m].
"""

from comotion_server.kernels.ball_contact import Stand
from comotion_server.kernels.contacts import LINE_CORNER
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.solids import HALF_LENGTH
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, rotated, row, scaled, sub, unit

PARALLEL = 1e-9  # sine of the angle between lines that do not cross: their ends tell where they are beside each other


@lean_jit
def _over_corner(u, half, p, D, velocity, spin, turn):
    """`Stand` over the corner at p."""
    t = dot(u, sub(p, D))
    arm = scaled(u, t)
    d = sub(add(D, arm), p)
    far, n = length(d), unit(d)
    V = sub(add(velocity, cross(turn, arm)), cross(spin, p))
    across = along(along(V, -dot(n, V), n), -dot(u, V), u)
    turning = along(scaled(across, 1.0 / far if far > 0.0 else 0.0), -dot(cross(turn, u), n), u)
    return Stand(n, turning, arm, p, far, half - abs(t))


@lean_jit
def _over_edge(u, half, p, q, D, spin, turn):
    """`Stand` over the edge from p to q, which is not parallel to u."""
    e, size, W = unit(sub(q, p)), length(sub(q, p)), sub(D, p)
    product, slant = cross(u, e), dot(u, e)
    square = dot(product, product)
    t, s = (slant * dot(W, e) - dot(W, u)) / square, (dot(W, e) - slant * dot(W, u)) / square
    scale = (1.0 if dot(product, W) >= 0.0 else -1.0) / length(product)
    n = scaled(product, scale)
    turning = scaled(add(cross(cross(turn, u), e), cross(u, cross(spin, e))), scale)
    turning = along(turning, -dot(n, turning), n)
    return Stand(n, turning, scaled(u, t), along(p, s, e), dot(n, W), min(half - abs(t), s, size - s))


@lean_jit
def stand_of_line(solids, contacts, i, body, ground, R, D, velocity, spin, turn):
    """`Stand` of row i; arguments as of `stand_of_ball`."""
    m, f = solids.meshes, contacts.feature[i]
    u, half = rotated(R[body], row(solids.axis, body)), solids.size[body, HALF_LENGTH]
    p = rotated(R[ground], row(m.vertices, f[1]))
    if contacts.kind[i] == LINE_CORNER:
        return _over_corner(u, half, p, D, velocity, spin, turn)
    q = rotated(R[ground], row(m.vertices, f[2]))
    return _over_edge(u, half, p, q, D, spin, turn)


@lean_jit
def is_along(solids, body, ground, R, v, w):
    """Whether the edge from vertex v to w is parallel to the capsule, to rounding."""
    m, u = solids.meshes, rotated(R[body], row(solids.axis, body))
    e = unit(rotated(R[ground], sub(row(m.vertices, w), row(m.vertices, v))))
    product = cross(u, e)
    return dot(product, product) <= PARALLEL * PARALLEL or e == ZERO
