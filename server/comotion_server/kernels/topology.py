"""What the features of a mesh need to know of their neighbours: built once per mesh."""

from comotion_server.kernels.jit import jit
from comotion_server.kernels.triangle_distance import triangle_normal
from comotion_server.kernels.vectors import cross, dot, row, sub, unit

FLAT = 1e-6  # sine of the angle of two faces below which their common edge is no edge of the body; an STL's rounding


@jit
def build_normals(vertices, triangles, normals):
    """Unit outward normals (t, 3); zero where a triangle has no area."""
    for t in range(len(triangles)):
        a, b, c = row(vertices, triangles[t, 0]), row(vertices, triangles[t, 1]), row(vertices, triangles[t, 2])
        normals[t] = unit(triangle_normal(sub(b, a), sub(c, a)))


@jit
def build_stars(triangles, start, star):
    """The triangles around each vertex, in the order of their indices: start (v + 1,), star (3 t,)."""
    start[:] = 0
    for t in range(len(triangles)):
        for k in range(3):
            start[triangles[t, k] + 1] += 1
    for v in range(len(start) - 1):
        start[v + 1] += start[v]
    for t in range(len(triangles)):
        for k in range(3):
            v = triangles[t, k]
            star[start[v]] = t
            start[v] += 1
    for v in range(len(start) - 1, 0, -1):
        start[v] = start[v - 1]
    start[0] = 0


@jit
def has_corner(triangles, t, v):
    """Whether vertex v is a corner of triangle t."""
    return triangles[t, 0] == v or triangles[t, 1] == v or triangles[t, 2] == v


@jit
def _is_flat(n, m):
    turn = cross(n, m)
    return dot(n, m) > 0.0 and dot(turn, turn) <= FLAT * FLAT


@jit
def build_sharp(triangles, normals, start, star, sharp):
    """Whether each edge (t, 3), from corner k to k + 1, is a crease or a border and not a line within a flat face."""
    for t in range(len(triangles)):
        for k in range(3):
            v, w = triangles[t, k], triangles[t, (k + 1) % 3]
            neighbours, creases = 0, 0
            for i in range(start[v], start[v + 1]):
                other = star[i]
                if other != t and has_corner(triangles, other, w):
                    neighbours += 1
                    if not _is_flat(row(normals, t), row(normals, other)):
                        creases += 1
            sharp[t, k] = 1 if creases > 0 or neighbours == 0 else 0
