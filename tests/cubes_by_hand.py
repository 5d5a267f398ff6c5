"""Surfaces of unit cubes, for tests of what is drawn."""

from types import SimpleNamespace

import numpy as np

from comotion.outputs.surface import Surface

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # outward
FACES = np.array([triangle for a, b, c, d in QUADS for triangle in ((a, b, c), (a, c, d))], dtype=np.uint32)
MOTION = {"floe": "free", "hull": "prescribed", "bank": "fixed"}


def scene_of(**centres):
    """Unit cubes, one region each."""
    regions, vertices, triangles = [], {}, {}
    for name, centre in centres.items():
        body = SimpleNamespace(name=name, first_vertex=0, vertex_count=8)
        regions.append(SimpleNamespace(name=name, vertex_count=8, bodies=(body,)))
        vertices[name], triangles[name] = CORNERS + centre, FACES
    return Surface(regions, vertices, triangles)
