"""Three-vectors as tuples of floats: small enough for registers, so hot loops allocate nothing."""

from math import sqrt

from comotion_server.kernels.jit import lean_jit

ZERO = (0.0, 0.0, 0.0)
PARALLEL = 1e-15  # sine of an angle that is rounding
SPLITTER = 134217729.0  # 2^27 + 1: Veltkamp's splitting of a double into two halves of 26 bits


@lean_jit
def row(array, i):
    """Row i of an (n, 3) array."""
    return array[i, 0], array[i, 1], array[i, 2]


@lean_jit
def add(a, b):
    """Sum a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@lean_jit
def sub(a, b):
    """Difference a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@lean_jit
def scaled(a, s):
    """Product s a."""
    return a[0] * s, a[1] * s, a[2] * s


@lean_jit
def along(a, s, u):
    """Point a + s u."""
    return a[0] + s * u[0], a[1] + s * u[1], a[2] + s * u[2]


@lean_jit
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@lean_jit
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lean_jit
def lever(arm, push):
    """The vector product arm x push; nothing at all where they are parallel to rounding: round bodies stay unspun."""
    turn = cross(arm, push)
    return turn if dot(turn, turn) > PARALLEL * PARALLEL * dot(arm, arm) * dot(push, push) else ZERO


@lean_jit
def length(a):
    """Euclidean norm."""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@lean_jit
def unit(a):
    """Direction of a; zero stays zero."""
    size = length(a)
    if size > 0.0:
        return a[0] / size, a[1] / size, a[2] / size
    return ZERO


@lean_jit
def largest(a):
    """The largest absolute component."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))


@lean_jit
def rotated(R, a):
    """Product R a, with R (3, 3)."""
    return (
        R[0, 0] * a[0] + R[0, 1] * a[1] + R[0, 2] * a[2],
        R[1, 0] * a[0] + R[1, 1] * a[1] + R[1, 2] * a[2],
        R[2, 0] * a[0] + R[2, 1] * a[1] + R[2, 2] * a[2],
    )


@lean_jit
def rotated_back(R, a):
    """Product R^T a, with R (3, 3)."""
    return (
        R[0, 0] * a[0] + R[1, 0] * a[1] + R[2, 0] * a[2],
        R[0, 1] * a[0] + R[1, 1] * a[1] + R[2, 1] * a[2],
        R[0, 2] * a[0] + R[1, 2] * a[1] + R[2, 2] * a[2],
    )


@lean_jit
def two_sum(a, b):
    """The sum and its rounding error, exactly (Knuth 1969)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@lean_jit
def two_product(a, b):
    """The product and its rounding error, exactly (Dekker 1971)."""
    product = a * b
    c = SPLITTER * a
    a_high = c - (c - a)
    a_low = a - a_high
    c = SPLITTER * b
    b_high = c - (c - b)
    b_low = b - b_high
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@lean_jit
def difference_of_products(a, b, c, d):
    """The value a b - c d to about two roundings, whatever cancels."""
    p, p_error = two_product(a, b)
    q, q_error = two_product(c, d)
    return (p - q) + (p_error - q_error)


@lean_jit
def cross_exactly(a, b):
    """The cross product with every component right to about two roundings: for nearly parallel a and b."""
    return (
        difference_of_products(a[1], b[2], a[2], b[1]),
        difference_of_products(a[2], b[0], a[0], b[2]),
        difference_of_products(a[0], b[1], a[1], b[0]),
    )
