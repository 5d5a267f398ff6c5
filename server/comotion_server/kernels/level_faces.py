"""Faces, edges and corners of a mesh that are its local tops along a direction, and the flat face around a triangle.

A body touches another one only where it is a local top: along an outward direction n a corner is one if no edge rises
from it, an edge if neither of its faces rises, a face if it is level. A *slope* is a sine below which nothing counts as
rising. Lines within a flat face are no edges: the direction at them is the face's normal and nothing else.
"""

from math import inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.features import EDGE, VERTEX, feature_at
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.mesh_pair import corners
from comotion_server.kernels.topology import has_corner
from comotion_server.kernels.vectors import add, cross, dot, length, row, scaled, sub

MOST_CROSSED = 256  # lines within a flat face that a point may cross from one look to the next


class Surface(NamedTuple):
    """What of `MeshArrays` is asked here: few arrays, because each one costs time at every call."""

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    sharp: np.ndarray
    star_start: np.ndarray
    star: np.ndarray
    size: np.ndarray


@jit
def surface_of(m):
    """`Surface` of `MeshArrays`."""
    return Surface(m.vertices, m.triangles, m.normals, m.sharp, m.star_start, m.star, m.size)


@lean_jit
def is_level(normal, n, slope):
    """Whether a face with this outward unit normal looks along the unit vector n."""
    turn = cross(normal, n)
    return dot(normal, n) > 0.0 and dot(turn, turn) <= slope * slope


@lean_jit
def rises(u, n, slope):
    """Whether the way u climbs along n."""
    climb = dot(n, u)
    return climb > 0.0 and climb * climb > slope * slope * dot(u, u)


@lean_jit
def neighbour(m, t, k):
    """The triangle across the edge from corner k of triangle t to the next; -1 where there is none."""
    v, w = m.triangles[t, k], m.triangles[t, (k + 1) % 3]
    for i in range(m.star_start[v], m.star_start[v + 1]):
        if m.star[i] != t and has_corner(m.triangles, m.star[i], w):
            return m.star[i]
    return -1


@lean_jit
def is_top_corner(m, v, n, slope):
    """Whether vertex v is a local top along n (body frame, outward)."""
    p = row(m.vertices, v)
    for i in range(m.star_start[v], m.star_start[v + 1]):
        for k in range(3):
            if m.triangles[m.star[i], k] != v and rises(sub(row(m.vertices, m.triangles[m.star[i], k]), p), n, slope):
                return False
    return True


@lean_jit
def is_top_edge(m, t, k, n, slope):
    """Whether the edge from corner k of triangle t, normal to n (body frame, outward), is a local top along n."""
    v, w, other = m.triangles[t, k], m.triangles[t, (k + 1) % 3], neighbour(m, t, k)
    p = row(m.vertices, v)
    if rises(sub(row(m.vertices, m.triangles[t, (k + 2) % 3]), p), n, slope):
        return False
    for c in range(3):
        u = m.triangles[other, c] if other >= 0 else v
        if u != v and u != w and rises(sub(row(m.vertices, u), p), n, slope):
            return False
    return True


@lean_jit
def is_top(m, shape, t, p, n, slope):
    """Whether the point p on triangle t is a local top of the surface along n; both in the body frame."""
    feature, corner = feature_at(m, shape, t, p)
    if feature == VERTEX:
        return is_top_corner(m, m.triangles[t, corner], n, slope)
    if feature == EDGE:
        return is_top_edge(m, t, corner, n, slope)
    return dot(row(m.normals, t), n) > 0.0


@lean_jit
def has_level_face(m, v, n, slope):
    """Whether a face at vertex v looks along n."""
    i, end = m.star_start[v], m.star_start[v + 1]
    while i < end and not is_level(row(m.normals, m.star[i]), n, slope):
        i += 1
    return i < end


@lean_jit
def is_corner(m, v, n, slope):
    """Whether vertex v is a bare corner along n (body frame, outward): a top without a level face."""
    return not has_level_face(m, v, n, slope) and is_top_corner(m, v, n, slope)


@lean_jit
def is_edge(m, t, k, n, slope):
    """Whether the level edge from corner k of triangle t is bare along n; told by one of its two triangles alone."""
    other = neighbour(m, t, k)
    if other < 0:
        return is_top_edge(m, t, k, n, slope)
    once = m.triangles[t, k] < m.triangles[t, (k + 1) % 3]
    return once and not is_level(row(m.normals, other), n, slope) and is_top_edge(m, t, k, n, slope)


@lean_jit
def _way_out(m, t, o, p):
    """Where the way from o leaves triangle t on to p: (edge, -1 if it ends inside; distance of p inside that edge).

    If it ends inside: the least distance from the sharp edges of the triangle, inf if it has none.
    """
    points, normal = corners(m, t), row(m.normals, t)
    edge, first, outside, inside = -1, inf, 0.0, inf
    for k in range(3):
        u = sub(points[(k + 1) % 3], points[k])
        across = scaled(cross(normal, u), 1.0 / length(u))
        here, there = dot(across, sub(o, points[k])), dot(across, sub(p, points[k]))
        if there < 0.0 and there < here and here / (here - there) < first:
            edge, first, outside = k, here / (here - there), there
        if m.sharp[t, k] == 1:
            inside = min(inside, there)
    return edge, outside if edge >= 0 else inside


@lean_jit
def follow(m, t, p):
    """(triangle, margin): where in the flat face of triangle t the point p in its plane is, straight over lines in it.

    margin [m]: from the edges of that face which the last triangle has, negative where the way left the face; inf where
    it has none.
    """
    a, b, c = corners(m, t)
    o = scaled(add(add(a, b), c), 1.0 / 3.0)
    for _ in range(MOST_CROSSED):
        edge, margin = _way_out(m, t, o, p)
        if edge < 0 or m.sharp[t, edge] == 1:
            return t, margin
        t = neighbour(m, t, edge)
    return t, -inf
