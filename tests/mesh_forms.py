"""Meshes and mesh files for tests, made without the code under test."""

import numpy as np

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
CUBE_QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def cube(edge=1.0, offset=(0.0, 0.0, 0.0)):
    """Vertices from `offset` to `offset` + `edge`, and 12 outward triangles."""
    vertices = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], dtype=float) * edge + offset
    triangles = np.array([t for a, b, c, d in CUBE_QUADS for t in ((a, b, c), (a, c, d))])
    return vertices, triangles


def torus(count, major=3.0, minor=1.0):
    """A ring about z with `count` x `count` vertices."""
    u, v = np.meshgrid(*2 * [np.arange(count) * 2 * np.pi / count], indexing="ij")
    r = major + minor * np.cos(v)
    vertices = np.stack((r * np.cos(u), r * np.sin(u), minor * np.sin(v)), axis=-1).reshape(-1, 3)
    a = np.arange(count * count).reshape(count, count)
    b, d = np.roll(a, -1, axis=0), np.roll(a, -1, axis=1)
    c = np.roll(b, -1, axis=1)
    quads = np.stack((a, b, c, d), axis=-1).reshape(-1, 4)
    return vertices, np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))


def sphere(rounds):
    """A unit sphere: an octahedron whose facets are split in four `rounds` times."""
    points = [*np.eye(3), *-np.eye(3)]
    facets = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    for _ in range(rounds):
        middles = {}

        def middle(i, j, middles=middles):
            key = (min(i, j), max(i, j))
            if key not in middles:
                point = points[i] + points[j]
                middles[key] = len(points)
                points.append(point / np.linalg.norm(point))
            return middles[key]

        split = []
        for a, b, c in facets:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            split += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        facets = split
    return np.array(points), np.array(facets)


def write_stl(path, vertices, triangles):
    """A binary STL file; coordinates are rounded to single precision."""
    facets = np.zeros(len(triangles), FACET)
    facets["corners"] = np.asarray(vertices)[np.asarray(triangles)]
    path.write_bytes(b"solid or not\0".ljust(80, b" ") + np.uint32(len(triangles)).tobytes() + facets.tobytes())
    return path


def write_text_stl(path, vertices, triangles, name="body"):
    """A text STL file in full double precision."""
    rows = [f"solid {name}"]
    for corners in np.asarray(vertices)[np.asarray(triangles)]:
        rows += ["facet normal 0 0 0", " outer loop"]
        rows += ["  vertex " + " ".join(repr(float(x)) for x in corner) for corner in corners]
        rows += [" endloop", "endfacet"]
    path.write_text("\n".join([*rows, f"endsolid {name}", ""]))
    return path
