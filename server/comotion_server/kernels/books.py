"""The books of an impact (VALIDATION B): what the bodies carry before and after, against what the impulse says.

What fixed, prescribed, locked or non-reacting bodies and the parallel rule (P12) take is an external impulse: the
balance compares the change of what the bodies carry with the part of the impulse that their free directions take up.

Legend: as in `impact`; c the contact point of b (that of a lies on the same line along J);
ledger (7,): momentum (3), angular momentum about c (3), energy.
"""

from math import sqrt

from comotion_server.kernels.flight import SPIN_FREE
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import cross


@lean_jit
def carried(bodies, i, x, v, L, w, c, ledger):
    """Adds what body i carries in its free directions to the ledger; a body that does not react carries nothing."""
    if not bodies.reacts[i]:
        return
    W = bodies.inverse_mass[i]
    p = (
        v[i, 0] / W[0] if W[0] > 0.0 else 0.0,
        v[i, 1] / W[1] if W[1] > 0.0 else 0.0,
        v[i, 2] / W[2] if W[2] > 0.0 else 0.0,
    )
    m = cross((x[i, 0] - c[0], x[i, 1] - c[1], x[i, 2] - c[2]), p)
    for k in range(3):
        ledger[k] += p[k]
        ledger[3 + k] += m[k] + L[i, k]
        ledger[6] += 0.5 * (p[k] * v[i, k] + L[i, k] * w[i, k])


@lean_jit
def taken(bodies, i, x, v, w, c, J, turning, ledger):
    """Adds to the ledger what impulse J at c gives to body i, or the work of a body that does not react."""
    if not bodies.reacts[i]:
        u = cross((w[i, 0], w[i, 1], w[i, 2]), (c[0] - x[i, 0], c[1] - x[i, 1], c[2] - x[i, 2]))
        for k in range(3):
            ledger[6] -= J[k] * (v[i, k] + (u[k] if turning else 0.0))
        return
    W, spin = bodies.inverse_mass[i], bodies.spin[i]
    p = (J[0] if W[0] > 0.0 else 0.0, J[1] if W[1] > 0.0 else 0.0, J[2] if W[2] > 0.0 else 0.0)
    r = (c[0] - x[i, 0], c[1] - x[i, 1], c[2] - x[i, 2])
    m = cross((-r[0], -r[1], -r[2]), p)
    t = cross(r, J)
    for k in range(3):
        ledger[k] += p[k]
        ledger[3 + k] += m[k]
        if turning and spin in (SPIN_FREE, k):
            ledger[3 + k] += t[k]


@lean_jit
def size_of(bodies, i, x, v, L, c):
    """Scales of body i for relative errors: |p| [kg m/s] and |r| |p| + |L| [kg m2/s]."""
    if not bodies.reacts[i]:
        return 0.0, 0.0
    momentum = arm = spin = 0.0
    for k in range(3):
        if bodies.inverse_mass[i, k] > 0.0:
            momentum += (v[i, k] / bodies.inverse_mass[i, k]) ** 2
        arm += (x[i, k] - c[k]) ** 2
        spin += L[i, k] ** 2
    return sqrt(momentum), sqrt(arm * momentum) + sqrt(spin)


@lean_jit
def errors(before, after, given, scale, out):
    """Relative errors (3,) of momentum, angular momentum and energy; `scale` (3,) says relative to what."""
    p = h = 0.0
    for k in range(3):
        p += (after[k] - before[k] - given[k]) ** 2
        h += (after[3 + k] - before[3 + k] - given[3 + k]) ** 2
    out[0] = sqrt(p) / scale[0]
    out[1] = sqrt(h) / scale[1] if scale[1] > 0.0 else 0.0
    out[2] = abs(after[6] - before[6] - given[6]) / scale[2]
