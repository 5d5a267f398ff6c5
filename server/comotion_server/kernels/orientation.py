"""The side of a plane on which a point lies, right even where the plain determinant is all rounding.

The determinant is taken in plain doubles with its error bound; only when the bound does not settle the sign is it taken
again in double-double arithmetic (32 digits; Dekker 1971, bounds after Shewchuk 1997).
"""

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.vectors import sub, two_product

PLAIN_BOUND = 1.8e-15  # 16 roundings of the permanent: what a plain 3 x 3 determinant of differences may be wrong by
DOUBLE_BOUND = 1e-29  # the same in double-double; below it the four points count as coplanar


@lean_jit
def _two_sum(a, b):
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@lean_jit
def _double_difference(a, b):
    return _two_sum(a, -b)


@lean_jit
def _double_add(a, b):
    high, low = _two_sum(a[0], b[0])
    return _two_sum(high, low + a[1] + b[1])


@lean_jit
def _double_multiply(a, b):
    high, low = two_product(a[0], b[0])
    return _two_sum(high, low + a[0] * b[1] + a[1] * b[0])


@lean_jit
def _double_minor(a, b, c, d):
    """A b - c d."""
    product = _double_multiply(c, d)
    return _double_add(_double_multiply(a, b), (-product[0], -product[1]))


@lean_jit
def volume_exactly(a, b, c, d):
    """The determinant det(a - d, b - d, c - d), right to 29 digits of its largest term."""
    ux, uy, uz = _double_difference(a[0], d[0]), _double_difference(a[1], d[1]), _double_difference(a[2], d[2])
    vx, vy, vz = _double_difference(b[0], d[0]), _double_difference(b[1], d[1]), _double_difference(b[2], d[2])
    wx, wy, wz = _double_difference(c[0], d[0]), _double_difference(c[1], d[1]), _double_difference(c[2], d[2])
    total = _double_multiply(ux, _double_minor(vy, wz, vz, wy))
    total = _double_add(total, _double_multiply(uy, _double_minor(vz, wx, vx, wz)))
    return _double_add(total, _double_multiply(uz, _double_minor(vx, wy, vy, wx)))[0]


@lean_jit
def orientation(a, b, c, d):
    """The sign (-1, 0, 1) of det(a - d, b - d, c - d): the side of the plane a, b, c on which d lies."""
    u, v, w = sub(a, d), sub(b, d), sub(c, d)
    x1, x2 = v[1] * w[2], v[2] * w[1]
    y1, y2 = v[2] * w[0], v[0] * w[2]
    z1, z2 = v[0] * w[1], v[1] * w[0]
    determinant = u[0] * (x1 - x2) + u[1] * (y1 - y2) + u[2] * (z1 - z2)
    permanent = abs(u[0]) * (abs(x1) + abs(x2)) + abs(u[1]) * (abs(y1) + abs(y2)) + abs(u[2]) * (abs(z1) + abs(z2))
    bound = PLAIN_BOUND * permanent
    if abs(determinant) <= bound:
        determinant = volume_exactly(a, b, c, d)
        bound = DOUBLE_BOUND * permanent
    if determinant > bound:
        return 1
    if determinant < -bound:
        return -1
    return 0
