"""Bodies and poses for tests of contact points, and their rows by an independent reading."""

import numpy as np
from mesh_forms import cube

from comotion_server.kernels.contact_manifold import manifold
from comotion_server.kernels.contacts import new_contacts
from comotion_server.kernels.flat_contact import new_patch_work
from comotion_server.kernels.solids import MESH, PLANE, Solids
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.meshes.triangle_mesh import TriangleMesh

GAP = 5e-10
REACH = 1e-8
UPRIGHT = np.eye(3)


def turn(axis, angle):
    """Rotation matrix (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def centred_cube(edge=1.0):
    return cube(edge, (-0.5 * edge,) * 3)


def extruded(outline, height, cuts=()):
    """A prism over a simple polygon (k, 2), counter-clockwise, from z = 0 to height; cuts: its triangles."""
    outline = np.asarray(outline, dtype=float)
    k = len(outline)
    cuts = np.array(cuts) if len(cuts) else np.array([(0, i, i + 1) for i in range(1, k - 1)])
    vertices = np.concatenate([np.c_[outline, np.full(k, z)] for z in (0.0, height)])
    i, j = np.arange(k), (np.arange(k) + 1) % k
    sides = [np.c_[i, j, j + k], np.c_[i, j + k, i + k]]
    return vertices, np.concatenate([cuts[:, ::-1], cuts + k, *sides])


def ell():
    """An L of height 1: legs of length 2 and width 1 in x-y; the inner corner is (0, 0), the notch looks to +x, +y."""
    outline = [(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)]
    return extruded(outline, 1.0, [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)])


def slab(cells, size=4.0, seed=0):
    """A box 1 high below z = 0; top and bottom are divided into cells x cells jittered squares of two triangles."""
    rng, k = np.random.default_rng(seed), cells + 1
    ticks = np.linspace(-size / 2, size / 2, k)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    for c in (x, y):
        c[1:-1, 1:-1] += rng.uniform(-0.3, 0.3, (k - 2, k - 2)) * size / cells
    top = np.stack((x, y, np.zeros_like(x)), axis=-1).reshape(-1, 3)
    n = np.arange(k * k).reshape(k, k)
    a, b, c, d = n[:-1, :-1].ravel(), n[1:, :-1].ravel(), n[1:, 1:].ravel(), n[:-1, 1:].ravel()
    ring = np.concatenate((n[:-1, 0], n[-1, :-1], n[:0:-1, -1], n[0, :0:-1]))
    ahead, below = np.roll(ring, -1), k * k
    return np.concatenate((top, top - [0.0, 0.0, 1.0])), np.concatenate(
        (
            np.c_[a, b, c],
            np.c_[a, c, d],
            np.c_[a, c, b] + below,
            np.c_[a, d, c] + below,
            np.c_[ring, ring + below, ahead],
            np.c_[ahead, ring + below, ahead + below],
        )
    )


def solids_of(forms):
    """`Solids` of meshes (vertices, triangles) and of planes, given by their normals."""
    meshes = [TriangleMesh(*form) for form in forms if isinstance(form, tuple)]
    store = MeshStore.build(meshes or [TriangleMesh(*centred_cube())])
    count = len(forms)
    kind, shape = np.full(count, PLANE), np.full(count, -1)
    normal, radius = np.zeros((count, 3)), np.full(count, np.inf)
    for i, form in enumerate(forms):
        if isinstance(form, tuple):
            kind[i], shape[i] = MESH, sum(isinstance(f, tuple) for f in forms[:i])
            radius[i] = 0.5 * store.size[shape[i]]
        else:
            normal[i] = form
    near, size, axis = np.full(count, 0.02), np.zeros((count, 4)), np.zeros((count, 3))
    return Solids(store.arrays, kind, shape, normal, radius, near, size, axis)


class Touching:
    """Two bodies at a pose, and their contact points."""

    def __init__(self, forms, x, R, reach=REACH, angle=0.0, level=0.0, room=256):
        self.solids = solids_of(forms)
        self.x, self.R = np.array(x, dtype=float), np.array(R, dtype=float)
        self.contacts = new_contacts(room)
        self.work = new_patch_work()
        self.options = (reach, angle, level)
        self.count = self.again()

    def again(self):
        return manifold(self.solids, 0, 1, self.x, self.R, *self.options, self.contacts, 0, self.work)

    def column(self, name):
        return getattr(self.contacts, name)[: self.count]

    @property
    def points(self):
        """The points on a (c, 3), world, from the centre of a."""
        return self.column("arm_a")

    def sorted_rows(self):
        """Normals, arms and gaps in an order of places: what does not depend on numbering."""
        rows = np.c_[self.column("arm_a"), self.column("normal"), self.column("arm_b"), self.column("gap")]
        keys = np.round(rows[:, :6], 6) + 0.0
        return rows[np.lexsort(keys.T[::-1])]


def clipped(subject, clip):
    """The overlap of two convex polygons (k, 2), counter-clockwise (Sutherland, Hodgman 1974)."""
    result = list(np.asarray(subject, dtype=float))
    for a, b in zip(clip, np.roll(clip, -1, axis=0), strict=True):
        edge = np.subtract(b, a)
        side = [edge[0] * (p - a)[1] - edge[1] * (p - a)[0] for p in result]
        kept = []
        for i, p in enumerate(result):
            before = i - 1
            if side[i] * side[before] < 0.0:
                kept.append(result[before] + (p - result[before]) * side[before] / (side[before] - side[i]))
            if side[i] >= 0.0:
                kept.append(p)
        result = kept
    return np.array(result)


def area(polygon):
    """Area of a polygon (k, 2) [m2]."""
    x, y = np.asarray(polygon).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
