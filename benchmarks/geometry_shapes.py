"""Pairs of bodies to measure distances on: smooth, rough, hollow, thin, coarse and fine."""

import numpy as np

from comotion_server.meshes import TriangleMesh, box, prism


def grid(points, *, closed=(True, True)):
    """The surface of a grid of points (n, m, 3) that joins its ends where `closed` says so."""
    n, m, _ = points.shape
    i, j = np.meshgrid(np.arange(n - (not closed[0])), np.arange(m - (not closed[1])), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return TriangleMesh(points.reshape(-1, 3), triangles)


def torus(around, across, radius=0.7, tube=0.3):
    """A ring about the z axis, of `around` x `across` x 2 triangles."""
    u, v = 2 * np.pi * np.arange(around)[:, None] / around, 2 * np.pi * np.arange(across)[None, :] / across
    ring = radius + tube * np.cos(v)
    return grid(np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v) + 0 * u], -1))


def ball(rounds, roughness=0.0, stretch=(1.0, 1.0, 1.0)):
    """A sphere of 8 x 4^rounds triangles: an octahedron split in four and blown up; then dented and stretched."""
    corners = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    facets = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]])
    soup = corners[facets]
    for _ in range(rounds):
        a, b, c = soup[:, 0], soup[:, 1], soup[:, 2]
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        soup = np.concatenate([np.stack(part, axis=1) for part in parts])
    vertices, index = np.unique(np.round(soup.reshape(-1, 3), 12), axis=0, return_inverse=True)
    vertices /= np.linalg.norm(vertices, axis=1)[:, None]
    dents = 1 + roughness * np.random.default_rng(3).normal(size=(len(vertices), 1))
    return TriangleMesh(vertices * dents * np.array(stretch), index.reshape(-1, 3))


def rod(sides, length=2.0, radius=0.05):
    """A round bar along z, of triangles as long as it is."""
    u = 2 * np.pi * np.arange(sides) / sides
    ends = [np.column_stack([radius * np.cos(u), radius * np.sin(u), np.full(sides, z)]) for z in (0, length)]
    rings = [0 * ends[0] + [0, 0, 0], *ends, 0 * ends[1] + [0, 0, length]]
    mesh = grid(np.stack(rings, axis=1) - [0, 0, 0.5 * length], closed=(True, False))
    corners = mesh.vertices[mesh.triangles]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return TriangleMesh(mesh.vertices, mesh.triangles[area > 0])


def spring(turns, along, across):
    """A coil about the z axis."""
    s = np.linspace(0, 2 * np.pi * turns, along)[:, None]
    v = 2 * np.pi * np.arange(across)[None, :] / across
    ring = 0.6 + 0.08 * np.cos(v)
    height = 0.3 * (s / (2 * np.pi) - turns / 2) + 0.08 * np.sin(v)
    return grid(np.stack([ring * np.cos(s), ring * np.sin(s), height], -1), closed=(False, True))


def pairs():
    """Named pairs of meshes, about 1 m in size."""
    fine, rough, ring, hull = ball(4), ball(4, 0.05), torus(24, 12), ball(4, 0.0, (1.6, 0.35, 0.3))
    plate, bar, floe = box([2.0, 0.6, 0.02]), rod(32), prism(base=0.5, height=0.4, thickness=0.03)
    return {
        "sphere 2048": (fine, fine),
        "rough 2048": (rough, rough),
        "ring 576": (ring, ring),
        "ring 8192": (torus(96, 43), torus(96, 43)),
        "hull 2048": (hull, hull),
        "spring 2400": (spring(4, 121, 10), spring(4, 121, 10)),
        "box 12": (box([1.0, 1.0, 1.0]), box([1.0, 1.0, 1.0])),
        "floe 8": (floe, floe),
        "rod 128": (bar, bar),
        "rough 8192": (ball(5, 0.02), ball(5, 0.02)),
        "plate-rough": (plate, rough),
        "rod-ring": (bar, torus(96, 43)),
        "hull-floe": (hull, floe),
    }
