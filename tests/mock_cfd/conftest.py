"""Bodies, and a motion server small enough to be seen through: one body that translates under a held force."""

from types import SimpleNamespace

import numpy as np
import pytest

from comotion_mock_cfd.box_form import box_mesh
from comotion_protocol.messages import Region, RegionBody

GRAVITY = 9.81
WATER = 1000.0


def _icosphere(divisions):
    """A sphere of radius 1: an icosahedron whose facets are quartered, the new vertices put on the sphere."""
    g = (1 + 5**0.5) / 2
    v = np.array([[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g]])
    v = np.concatenate([v, [[0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]])
    rows = (
        "0 11 5 0 5 1 0 1 7 0 7 10 0 10 11 1 5 9 5 11 4 11 10 2 10 7 6 7 1 8 3 9 4 3 4 2 3 2 6 3 6 8 3 8 9 4 9 5 2 4 11"
    )
    t = np.array((rows + " 6 2 10 8 6 7 9 8 1").split(), dtype=int).reshape(-1, 3)
    v /= np.linalg.norm(v[0])
    for _ in range(divisions):
        edges = np.sort(t[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        unique, at = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (at.reshape(-1, 3) + len(v)).T
        middle = v[unique].sum(axis=1)
        v = np.concatenate([v, middle / np.linalg.norm(middle, axis=1, keepdims=True)])
        a, b, c = t.T
        t = np.concatenate([np.stack(f, axis=1) for f in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return v, t


def _rotation(rng):
    """A random rotation matrix."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


class OneBody:
    """Stands in for `MotionClient`: a body of the given mesh that translates, exactly, under held force and gravity."""

    def __init__(self, mesh, mass, position=(0, 0, 0), velocity=(0, 0, 0), sample="midpoint", dt=0.01):
        self._mesh, self._triangles = mesh
        self._mass = mass
        self.position, self.velocity = np.array(position, dtype=float), np.array(velocity, dtype=float)
        self._sample = sample
        self.time = 0.0
        body = RegionBody(name="box", first_vertex=0, vertex_count=len(self._mesh))
        counts = {"vertex_count": len(self._mesh), "triangle_count": len(self._triangles)}
        region = Region(name="floating", moves=True, bodies=(body,), **counts)
        self.triangles = {"floating": self._triangles}
        self.states = [self._state()]
        self.opened = SimpleNamespace(regions=(region,), time=0.0, step=1, **self._surface(dt))
        self.steps = []

    def step(self, dt, forces, *, dt_next):
        acceleration = forces["floating"].sum(axis=0) / self._mass - (0.0, 0.0, GRAVITY)
        self.position = self.position + self.velocity * dt + 0.5 * acceleration * dt**2
        self.velocity = self.velocity + acceleration * dt
        self.time += dt
        self.steps.append((dt, dt_next))
        self.states.append(self._state())
        return SimpleNamespace(step=len(self.steps), time=self.time, **self._surface(dt_next))

    def _surface(self, dt_next):
        ahead = 0.5 * dt_next if self._sample == "midpoint" else 0.0
        centre = self.position + self.velocity * ahead
        return {
            "vertices": {"floating": self._mesh + centre},
            "velocities": {"floating": np.broadcast_to(self.velocity, self._mesh.shape).copy()},
            "poses": np.array([[*centre, 1.0, 0.0, 0.0, 0.0]]),
            "twists": np.array([[*self.velocity, 0.0, 0.0, 0.0]]),
        }

    def _state(self):
        return np.concatenate([self.position, self.velocity])


@pytest.fixture
def one_body():
    return OneBody


@pytest.fixture
def icosphere():
    return _icosphere


@pytest.fixture
def rotation():
    return _rotation


@pytest.fixture
def box():
    return box_mesh
