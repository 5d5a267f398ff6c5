"""Scenes for the event queue, made of meshes and planes without the server's scene files."""

from dataclasses import dataclass
from math import inf

import numpy as np

from comotion_server.geometry.contact_time import near_distance
from comotion_server.kernels.event_queue import begin_step, play, start
from comotion_server.kernels.event_scene import LEFT, Rules, Scene, new_queue
from comotion_server.kernels.flat_contact import new_patch_work
from comotion_server.kernels.flight import (
    SPIN_FREE,
    SPIN_NONE,
    Bodies,
    Flights,
    angular_velocity_of,
    begin_all,
    fly_all,
)
from comotion_server.kernels.mesh_pair import closest_points_of_pairs
from comotion_server.kernels.pair_window import new_work
from comotion_server.kernels.solids import MESH, PIPE, PLANE, RADIUS, SPHERE, Solids
from comotion_server.meshes import TriangleMesh, mass_properties
from comotion_server.meshes.mesh_store import MeshStore

PLENTY = 1 << 62


@dataclass(frozen=True)
class Ball:
    """A sphere; its mass is its density."""

    radius: float


@dataclass(frozen=True)
class Tube:
    """A pipe along z that stays."""

    inner: float
    outer: float
    half: float
    caps: bool = False


@dataclass
class Part:
    """A body: a mesh about its centre of mass, a ball, a tube, or a plane's normal through x; density 0: it stays."""

    shape: object
    x: tuple = (0.0, 0.0, 0.0)
    v: tuple = (0.0, 0.0, 0.0)
    w: tuple = (0.0, 0.0, 0.0)
    R: np.ndarray = None
    density: float = 1.0
    inertia: np.ndarray = None  # of unit density; None: the mesh's own


def inside_out(mesh):
    """A container with the surface of a mesh: its solid side is outside."""
    return TriangleMesh(mesh.vertices, mesh.triangles[:, ::-1])


def centred(mesh):
    """The same mesh about its centre of mass."""
    return TriangleMesh(mesh.vertices - mass_properties(mesh.vertices, mesh.triangles).centre, mesh.triangles)


class Play:
    """Bodies in a queue of their own, from their parts."""

    def __init__(
        self,
        parts,
        *,
        gravity=(0, 0, 0),
        restitution=1.0,
        tolerance=1e-9,
        angle=0.0,
        law=0,
        resting=False,
        log_room=200_000,
    ):
        n = len(parts)
        meshes = [part.shape for part in parts if isinstance(part.shape, TriangleMesh)]
        store = MeshStore.build(meshes) if meshes else None
        shapes = iter(store.shape_of_mesh if meshes else ())
        sizes, axis = np.zeros((n, 4)), np.zeros((n, 3))
        kind, shape, normal = np.zeros(n, np.int64), np.full(n, -1), np.zeros((n, 3))
        radius, near, size = np.full(n, inf), np.full(n, inf), np.full(n, inf)
        bodies = Bodies(
            np.ones((n, 3)), np.tile(np.eye(3), (n, 1, 1)), np.full(n, SPIN_NONE), np.zeros((n, 3)), np.zeros((n, 3)),
            np.zeros(n, np.bool_),
        )  # fmt: skip
        x, v, L, w = (np.zeros((n, 3)) for _ in range(4))
        R = np.tile(np.eye(3), (n, 1, 1))
        for i, part in enumerate(parts):
            x[i], v[i] = part.x, part.v
            R[i] = np.eye(3) if part.R is None else part.R
            if isinstance(part.shape, Ball):
                r = part.shape.radius
                kind[i], sizes[i, RADIUS], radius[i], size[i] = SPHERE, r, r, 2.0 * r
                if part.density > 0.0:
                    bodies.moments[i] = 0.4 * part.density * r * r
                    bodies.inverse_mass[i], bodies.gravity[i] = 1.0 / part.density, gravity
                    bodies.spin[i], bodies.reacts[i] = SPIN_FREE, True
                    w[i], L[i] = part.w, bodies.moments[i] * part.w
                continue
            if isinstance(part.shape, Tube):
                tube = part.shape
                kind[i], axis[i], sizes[i] = PIPE, (0.0, 0.0, 1.0), (tube.inner, tube.outer, tube.half, tube.caps)
                radius[i] = np.hypot(tube.outer, tube.half)
                size[i] = 2.0 * radius[i]
                continue
            if not isinstance(part.shape, TriangleMesh):
                kind[i], normal[i] = PLANE, part.shape
                continue
            kind[i], shape[i] = MESH, next(shapes)
            size[i] = part.shape.size
            radius[i], near[i] = 0.5 * size[i], near_distance(part.shape)
            if part.density > 0.0:
                properties = mass_properties(part.shape.vertices, part.shape.triangles)
                inertia = part.density * (properties.inertia if part.inertia is None else part.inertia)
                bodies.moments[i], axes = np.linalg.eigh(inertia)
                bodies.principal[i] = axes * [np.sign(np.linalg.det(axes)), 1.0, 1.0]
                bodies.inverse_mass[i] = 1.0 / (part.density * properties.volume)
                bodies.gravity[i], bodies.spin[i], bodies.reacts[i] = gravity, SPIN_FREE, True
                L[i] = R[i] @ (inertia @ (R[i].T @ part.w))
                angular_velocity_of(R[i], L[i], bodies.moments[i], bodies.principal[i], w[i])
        vectors = {
            name: np.zeros((n, 3)) for name in ("position", "velocity", "acceleration", "momentum", "torque", "axis")
        }
        flights = Flights(
            origin=np.zeros(n),
            rotation=np.zeros((n, 3, 3)),
            rate=np.zeros((n, 2)),
            kind=np.zeros(n, np.int64),
            **vectors,
        )
        solids = Solids(store and store.arrays, kind, shape, normal, radius, near, sizes, axis)
        self.scene = Scene(bodies, solids, flights, x, v, R, L, w)
        self.rules = Rules(
            np.zeros(n, np.int64),
            np.full((1, 1), restitution),
            np.zeros((1, 1)),
            law,
            angle,
            0.0,
            bool(resting),
            bool(0),
        )
        grain = np.full(n, 64 * np.spacing(max(np.abs(x).max(), size[np.isfinite(size)].max())))
        rooms = (new_work(), new_patch_work()) if meshes else (None, None)
        self.queue = new_queue(x, radius, tolerance * size, grain, 40 * n + 100, 4000, log_room, *rooms)
        self.time = 0.0
        self.zero = np.zeros((n, 3))
        self.torque = self.zero
        assert start(self.queue, self.scene)
        self.queue.tally[LEFT] = PLENTY

    @property
    def state(self):
        return self.scene.x, self.scene.v, self.scene.R, self.scene.L, self.scene.w

    def begin(self, elapsed=0.0):
        begin_all(self.scene.flights, self.scene.bodies, self.zero, self.torque, *self.state)
        begin_step(self.queue, self.scene, elapsed)

    def fly(self, time):
        fly_all(self.scene.flights, self.scene.bodies, time, *self.state)

    def play(self, until):
        """To the local time `until`; how it ended."""
        code = play(self.queue, self.scene, self.rules, until)
        self.fly(self.queue.now[0])
        return code

    def step(self, dt):
        """One coupling step."""
        self.begin(dt)
        code = self.play(dt)
        self.time += dt
        return code

    def gap(self, time):
        """The least gap of all pairs of meshes, and of meshes and planes, at a local time."""
        self.fly(time)
        kind, shape, least = self.scene.solids.kind, self.scene.solids.shape, inf
        x, R, m = self.scene.x, self.scene.R, self.scene.solids.meshes
        meshes, reacts = np.flatnonzero(kind == MESH), self.scene.bodies.reacts
        pairs = np.array([(i, j) for i in meshes for j in meshes if i < j and (reacts[i] or reacts[j])]).reshape(-1, 2)
        if len(pairs):
            count = len(pairs)
            distance, points = np.empty(count), [np.empty((count, 3)) for _ in range(3)]
            witness = np.full((count, 2), -1)
            closest_points_of_pairs(m, shape, x, R, pairs, np.full(count, inf), witness, distance, *points)
            least = distance.min()
        for p in np.flatnonzero(kind == PLANE):
            for i in meshes:
                corners = m.vertices[m.vertex_start[shape[i]] : m.vertex_start[shape[i] + 1]]
                least = min(least, ((corners @ R[i].T + x[i] - x[p]) @ (R[p] @ self.scene.solids.normal[p])).min())
        return least

    def energy(self):
        bodies, total = self.scene.bodies, 0.0
        x, v, _, L, w = self.state
        for i in np.flatnonzero(bodies.reacts):
            mass = 1.0 / bodies.inverse_mass[i, 0]
            total += 0.5 * mass * v[i] @ v[i] + 0.5 * L[i] @ w[i] - mass * bodies.gravity[i] @ x[i]
        return total
