"""P12, P13: the face, edge or vertex that a contact point lies on, and what it turns towards the other body."""

from comotion_server.kernels.jit import jit
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.topology import has_corner
from comotion_server.kernels.vectors import dot, length, rotated, rotated_back, row, sub, unit

FACE, EDGE, VERTEX = 0, 1, 2
ON_FEATURE = 1e-8  # of the body's size: a point nearer to an edge or corner lies on it; coordinates at 1e7 m keep it
NO_EDGE = 1.0  # the cosine where there is no edge: not flat


@jit
def _distance_to_edge(p, a, b):
    u, w = sub(b, a), sub(p, a)
    uu = dot(u, u)
    s = min(max(dot(w, u) / uu, 0.0), 1.0) if uu > 0.0 else 0.0
    return length(sub(w, (s * u[0], s * u[1], s * u[2])))


@jit
def feature_at(m, shape, triangle, p):
    """(feature, corner) of the point p (body frame) on a triangle (over all shapes).

    VERTEX and the corner 0, 1, 2; EDGE and the corner that it starts from; or FACE and 0.
    """
    near = ON_FEATURE * m.size[shape]
    a, b, c = corners(m, triangle)
    da, db, dc = length(sub(p, a)), length(sub(p, b)), length(sub(p, c))
    if min(da, db, dc) <= near:
        return VERTEX, 0 if da <= db and da <= dc else 1 if db <= dc else 2
    da, db, dc = _distance_to_edge(p, a, b), _distance_to_edge(p, b, c), _distance_to_edge(p, c, a)
    if min(da, db, dc) <= near:
        return EDGE, 0 if da <= db and da <= dc else 1 if db <= dc else 2
    return FACE, 0


@jit
def contact_features(m, shape, position, rotation, triangle, point, direction, normal):
    """P13: the face that counts at a contact point; returns what the point lies on: FACE, EDGE or VERTEX.

    m: MeshArrays; position (3,) [m], rotation (3, 3) body to world; triangle: the witness, index within the shape;
    point (3,) [m] on it and direction (3,) towards the other body, both world.
    Out: normal (3,), world: the outward unit normal, among all faces that share the point, that makes the smallest
    angle with the direction.
    """
    p = rotated_back(rotation, sub(point, position))
    towards = rotated_back(rotation, (direction[0], direction[1], direction[2]))
    triangle += m.triangle_start[shape]
    feature, corner = feature_at(m, shape, triangle, p)
    best, best_dot = row(m.normals, triangle), dot(row(m.normals, triangle), towards)
    if feature != FACE:
        v, w = m.triangles[triangle, corner], m.triangles[triangle, (corner + 1) % 3]
        for i in range(m.star_start[v], m.star_start[v + 1]):
            t = m.star[i]
            face = row(m.normals, t)
            shares = feature == VERTEX or has_corner(m.triangles, t, w)
            if shares and dot(face, face) > 0.0 and dot(face, towards) > best_dot:
                best, best_dot = face, dot(face, towards)
    x, y, z = rotated(rotation, best)
    normal[0], normal[1], normal[2] = x, y, z
    return feature


@jit
def _edge_cosine(m, v, w, direction):
    return abs(dot(unit(sub(row(m.vertices, w), row(m.vertices, v))), direction))


@jit
def edge_cosine(m, shape, position, rotation, triangle, point, direction):
    """P12: the smallest |cos| between an edge of the body at a contact point and a unit direction (3,), world.

    Asked with the normal of the other body's face: near 0 the edge lies flat on that face. The edge is the one on
    which the point lies, or any that ends in it; lines within a flat face are no edges. NO_EDGE inside a face.
    Arguments as in `contact_features`.
    """
    p = rotated_back(rotation, sub(point, position))
    d = rotated_back(rotation, (direction[0], direction[1], direction[2]))
    triangle += m.triangle_start[shape]
    feature, corner = feature_at(m, shape, triangle, p)
    v, w = m.triangles[triangle, corner], m.triangles[triangle, (corner + 1) % 3]
    if feature == EDGE:
        return _edge_cosine(m, v, w, d) if m.sharp[triangle, corner] else NO_EDGE
    least = NO_EDGE
    if feature == VERTEX:
        for i in range(m.star_start[v], m.star_start[v + 1]):
            t = m.star[i]
            for k in range(3):
                a, b = m.triangles[t, k], m.triangles[t, (k + 1) % 3]
                if m.sharp[t, k] and (a == v or b == v):
                    least = min(least, _edge_cosine(m, a, b, d))
    return least
