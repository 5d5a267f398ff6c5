"""The geometry kernels compiled and as plain Python give the same bits."""

import os
import subprocess
import sys

SCRIPT = """
import numpy as np
from comotion_server.kernels.features import contact_features, edge_cosine
from comotion_server.kernels.mesh_pair import closest_points_of_pairs
from comotion_server.kernels.penetration import overlap_depth
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.meshes import box
from comotion_server.meshes.mesh_store import MeshStore
from meshes_by_hand import l_shape, torus
from triangle_families import FAMILIES, turn

rng = np.random.default_rng(5)
for family in FAMILIES:
    a, b = family(rng)
    print(family.__name__, np.hstack(triangle_points(*map(tuple, a.tolist()), *map(tuple, b.tolist()))).tobytes().hex())
m = MeshStore.build([torus(6, 4), l_shape(), box([1.0, 1.0, 1.0])]).arrays
for name, array in zip(m._fields, m):
    print(name, array.tobytes().hex())
for _ in range(4):
    x, R = rng.normal(size=(3, 3)), np.stack([turn(rng) for _ in range(3)])
    pairs, witness = np.array([(0, 1), (0, 2), (1, 2)]), np.full((3, 2), -1)
    distance, p, q, n = np.empty(3), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    closest_points_of_pairs(m, np.arange(3), x, R, pairs, np.full(3, np.inf), witness, distance, p, q, n)
    print([array.tobytes().hex() for array in (distance, p, q, n, witness)])
    normal = np.empty(3)
    print(contact_features(m, 0, x[0], R[0], witness[0, 0], p[0], n[0], normal), normal.tobytes().hex())
    print(float(edge_cosine(m, 0, x[0], R[0], witness[0, 0], p[0], n[0])).hex())
    print(float(overlap_depth(m, 1, 2, x[1], R[1], x[1] + 0.5, R[2], n[2])).hex())
"""


def run(**environment):
    path = os.pathsep.join(sys.path)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env=os.environ | {"PYTHONPATH": path} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.splitlines()


def test_compiled_and_plain_agree_to_the_bit():
    compiled, plain = run(), run(NUMBA_DISABLE_JIT="1")
    assert len(compiled) > 40
    for one, other in zip(compiled, plain, strict=True):
        assert one == other
