"""P7: whether two triangles have a point in common: crossing, touching, or overlapping in one plane."""

from comotion_server.kernels.jit import jit
from comotion_server.kernels.triangle_distance import triangle_points


@jit
def triangles_intersect(a0, a1, a2, b0, b1, b2):
    """Whether two triangles, each vertex a tuple (x, y, z), meet: decided as the distance is, never at odds with it.

    Triangles without area are segments or points and are answered as such.
    """
    return triangle_points(a0, a1, a2, b0, b1, b2)[0] == 0.0
