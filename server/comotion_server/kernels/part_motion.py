"""How parts of two bodies that meet move: gap, opening and bias (docs/shapes.md, 5).

Legend: p, q the points that meet, of the bodies with angular velocities w_p and w_q; T, K tangent and curvature of what
they may move along; V = q' - p' of the material points; n from p to q; g = n . (q - p).

The points that meet move along their parts by s' and t', and n turns: q - p stays along n, and n normal to both,
  V + t' T_q - s' T_p = g' n + g n',   n' . T = -n . (w x T) - (n . K) (s' or t').

This is linear in s', t' and n'. As n . T = 0, g' = n . V, and its rate of change is
  g'' = n . (q'' - p'') + n' . V + t' n . (w_q x T_q) - s' n . (w_p x T_p),
with q'', p'' of the material points. From a face p is any point below q, and n' = w_p x n.
"""

from comotion_server.kernels.body_parts import FACE, PARALLEL
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import ZERO, add, along, cross, dot, length, scaled


@lean_jit
def _turning(n, T_p, T_p_rate, T_q, T_q_rate, slip, far):
    """n', from the tangents; where they leave it open, from how fast the points slip past each other."""
    product = cross(T_p, T_q)
    size = length(product)
    if size > PARALLEL:
        size = size if dot(product, n) > 0.0 else -size
        turning = scaled(add(cross(T_p_rate, T_q), cross(T_p, T_q_rate)), 1.0 / size)
        return along(turning, -dot(n, turning), n)
    e, rate = (T_p, T_p_rate) if T_p != ZERO else (T_q, T_q_rate)
    across = along(along(slip, -dot(n, slip), n), -dot(e, slip), e)
    return along(scaled(across, 1.0 / far if far != 0.0 else 0.0), -dot(n, rate), e)


@lean_jit
def _face_bias(at, g, V, w_p, w_q):
    """What of the bias is not of material points, over a face."""
    turning = cross(w_p, at.n)
    bias = 2.0 * dot(turning, V) - g * dot(turning, turning)
    if dot(at.n, at.K_q) != 0.0:
        rate = dot(turning, at.T_q) + dot(at.n, cross(w_q, at.T_q))
        bias -= rate * rate / dot(at.n, at.K_q)
    return bias


@lean_jit
def bias_of(at, rank, V, w_p, w_q):
    """What velocities add to g'', but for the material points' own; at: `Meeting`, rank: of the first part."""
    n, T_p, T_q = at.n, at.T_p, at.T_q
    g = dot(n, (at.q[0] - at.p[0], at.q[1] - at.p[1], at.q[2] - at.p[2]))
    if rank == FACE:
        return _face_bias(at, g, V, w_p, w_q)
    spin_p, spin_q, bent_p, bent_q = cross(w_p, T_p), cross(w_q, T_q), dot(n, at.K_p), dot(n, at.K_q)
    A, B, c = g * bent_p - 1.0, g * bent_q + 1.0, dot(T_p, T_q)
    f, h = -dot(V, T_p) - g * dot(n, spin_p), -dot(V, T_q) - g * dot(n, spin_q)
    det = A * B + c * c
    s, t = ((B * f - c * h) / det, (A * h + c * f) / det) if det != 0.0 else (0.0, 0.0)
    slip = along(along(V, t, T_q), -s, T_p)
    turning = _turning(n, T_p, along(spin_p, s, at.K_p), T_q, along(spin_q, t, at.K_q), slip, g)
    return dot(turning, V) + t * dot(n, spin_q) - s * dot(n, spin_p)
