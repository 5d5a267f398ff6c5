"""From nodal forces to one wrench per body (P3), by compensated sums (Neumaier): no digit is lost to many nodes."""

from comotion_server.kernels.jit import jit


@jit
def add(total, lost, k, value):
    """Neumaier's compensated addition of `value` to total[k]; what it rounds away gathers in lost[k]."""
    before = total[k]
    after = before + value
    if abs(before) >= abs(value):
        lost[k] += (before - after) + value
    else:
        lost[k] += (value - after) + before
    total[k] = after


@jit
def gather(forces, vertices, first, count, centres, force, moment, lost):
    """Sums nodal forces [N] (n,3) at `vertices` (n,3) into force and moment (b,3) about `centres` (b,3), per body.

    `first`, `count` (b,) give each body's rows; `lost` (6,) is work space. Everything in the world frame.
    """
    for b in range(first.shape[0]):
        force[b, :] = 0.0
        moment[b, :] = 0.0
        lost[:] = 0.0
        cx, cy, cz = centres[b, 0], centres[b, 1], centres[b, 2]
        for i in range(first[b], first[b] + count[b]):
            fx, fy, fz = forces[i, 0], forces[i, 1], forces[i, 2]
            rx, ry, rz = vertices[i, 0] - cx, vertices[i, 1] - cy, vertices[i, 2] - cz
            add(force[b], lost[:3], 0, fx)
            add(force[b], lost[:3], 1, fy)
            add(force[b], lost[:3], 2, fz)
            add(moment[b], lost[3:], 0, ry * fz - rz * fy)
            add(moment[b], lost[3:], 1, rz * fx - rx * fz)
            add(moment[b], lost[3:], 2, rx * fy - ry * fx)
        for k in range(3):
            force[b, k] += lost[k]
            moment[b, k] += lost[3 + k]
