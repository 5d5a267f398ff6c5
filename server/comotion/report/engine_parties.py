"""The engines that the study `engines` compares: each builds a case, advances it, tells its state.

Each gets what suits it: spheres and boxes as such, no damping, and its own way to be elastic. A party that
is not installed is left out (`pip install 'comotion[peers]'`).
"""

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from math import log, pi, sqrt
from typing import Any, Protocol

import numpy as np

from comotion.report.engine_cases import Case, G, State

FLOOR = 50.0  # [m] thickness of a box that stands for a plane, half its edges
CONTACT_STEPS = 10  # MuJoCo: steps that an elastic contact, a spring, lasts


class Party(Protocol):
    """An engine with a case in it."""

    library: str

    def __init__(self, case: Case, dt: float) -> None: ...

    def advance(self, steps: int) -> None:
        """So many steps."""

    def state(self) -> State:
        """Now."""


class Comotion:
    """This server, rule `exact`, balls as spheres and the rest as meshes; `dt` is the coupling step."""

    library = "comotion_server"

    def __init__(self, case: Case, dt: float) -> None:
        from comotion_server.meshes import TriangleMesh
        from comotion_server.scene import Body, Collisions, Fixed, Free, Plane, Scene, Sphere
        from comotion_server.simulation import Simulation
        from comotion_server.warm_up import warm_up

        meshes: dict[int, TriangleMesh] = {}
        nothing = np.full((3, 3), np.nan)
        bodies = []
        for k, thing in enumerate(case.things):
            size = thing.parts[0].size
            if isinstance(size, float):
                body_shape: Sphere | TriangleMesh = Sphere(size)
            else:
                body_shape = meshes.setdefault(len(thing.mesh[0]), TriangleMesh(*thing.mesh))
            state: dict[str, Any] = {"velocity": np.array(thing.velocity), "angular_velocity": np.array(thing.spin)}
            inertia = np.diag(thing.moments)
            bodies.append(
                Body(f"thing-{k:04d}", "things", Free(), thing.mass, inertia, body_shape, thing.position, **state)
            )
        for k, (normal, point) in enumerate(case.walls):
            shape, at = Plane(np.array(normal)), np.array(point)
            bodies.append(Body(f"wall-{k}", "walls", Fixed(), np.nan, nothing, shape, at))
        collisions = Collisions(restitution=case.restitution, friction=case.friction, budget=1_000_000)
        scene = Scene("benchmark", np.array([0.0, 0.0, -G]), case.duration, dt, collisions, tuple(bodies))
        warm_up(scene)
        self._simulation, self._dt, self._count = Simulation(scene), dt, len(case.things)

    def advance(self, steps):
        for _ in range(steps):
            self._simulation.step(self._dt)

    def state(self):
        from comotion_server.quaternions import rotation_from_quaternion

        bodies, n = self._simulation.bodies, self._count  # things come before walls in the order of names
        rotation = np.array([rotation_from_quaternion(q) for q in bodies.quaternion[:n]])
        return State(bodies.position[:n], rotation, bodies.velocity[:n], bodies.angular_velocity[:n])


class MuJoCo:
    """Contacts are springs by design: a stiff one without damping for e = 1, with that of a lossy bounce below."""

    library = "mujoco"

    def __init__(self, case: Case, dt: float) -> None:
        import mujoco

        self._step, self._transform = mujoco.mj_step, mujoco.mju_quat2Mat
        self._model = mujoco.MjModel.from_xml_string(self._xml(case, dt))
        self._data = mujoco.MjData(self._model)
        self._count = len(case.things)
        poses, twists = self._data.qpos.reshape(-1, 7), self._data.qvel.reshape(-1, 6)
        poses[:, :3] = [thing.position for thing in case.things]
        poses[:, 3:] = (1.0, 0.0, 0.0, 0.0)
        twists[:] = [(*thing.velocity, *thing.spin) for thing in case.things]

    def advance(self, steps):
        self._step(self._model, self._data, nstep=steps)

    def state(self):
        poses, twists = self._data.qpos.reshape(-1, 7).copy(), self._data.qvel.reshape(-1, 6).copy()
        rotation = np.empty((self._count, 9))
        for q, R in zip(poses[:, 3:], rotation, strict=True):
            self._transform(R, q)
        rotation = rotation.reshape(-1, 3, 3)
        spin = np.einsum("nij,nj->ni", rotation, twists[:, 3:])  # a free joint turns in the body's own frame
        return State(poses[:, :3], rotation, twists[:, :3], spin)

    @staticmethod
    def _xml(case, dt):
        contact = f'condim="{3 if case.friction else 1}" friction="{case.friction}" solimp="0.9999 0.9999 0.001"'
        if case.restitution > 0.0:
            damping = -log(case.restitution) / sqrt(pi**2 + log(case.restitution) ** 2)
            stiffness = (pi / (CONTACT_STEPS * dt)) ** 2 / (1.0 - damping**2)
            contact += f' solref="{-stiffness} {-2.0 * damping * sqrt(stiffness)}"'
        walls = "".join(
            f'<geom type="plane" size="0 0 1" pos="{_words(at)}" zaxis="{_words(normal)}" {contact}/>'
            for normal, at in case.walls
        )
        bodies = "".join(
            f'<body><freejoint/><inertial pos="0 0 0" mass="{thing.mass}" diaginertia="{_words(thing.moments)}"/>'
            + "".join(f'<geom {_mujoco_shape(part.size)} pos="{_words(part.at)}" {contact}/>' for part in thing.parts)
            + "</body>"
            for thing in case.things
        )
        option = f'<option timestep="{dt}" gravity="0 0 {-G}"/><size memory="1G"/>'
        return f"<mujoco>{option}<worldbody>{walls}{bodies}</worldbody></mujoco>"


def _words(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def _mujoco_shape(size):
    if isinstance(size, float):
        return f'type="sphere" size="{size}"'
    return f'type="box" size="{_words(edge / 2 for edge in size)}"'


@contextmanager
def _silence() -> Iterator[None]:
    """Bullet greets on the standard output and error of the process, below Python: not here."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept, nowhere = [os.dup(1), os.dup(2)], os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
        ctypes.CDLL(None).fflush(None)
    finally:
        os.dup2(kept[0], 1)
        os.dup2(kept[1], 2)
        for descriptor in (*kept, nowhere):
            os.close(descriptor)


class Bullet:
    """Sequential impulses.

    Where e > 0: no error reduction, which would push, and no contact before bodies touch, which would take off the
    rebound what the gap leaves to go.
    """

    library = "pybullet"

    def __init__(self, case: Case, dt: float) -> None:
        with _silence():
            import pybullet
            from pybullet_utils.bullet_client import BulletClient

            self._b = b = BulletClient(pybullet.DIRECT)
        b.setGravity(0, 0, -G)
        push = {"erp": 0.0, "contactERP": 0.0, "contactBreakingThreshold": 1e-9} if case.restitution > 0.0 else {}
        b.setPhysicsEngineParameter(fixedTimeStep=dt, numSubSteps=0, restitutionVelocityThreshold=0.0, **push)
        smooth = {"lateralFriction": sqrt(case.friction), "linearDamping": 0.0, "angularDamping": 0.0}
        for normal, at in case.walls:
            wall = b.createCollisionShape(b.GEOM_PLANE, planeNormal=normal)
            body = b.createMultiBody(0.0, wall, basePosition=at)
            b.changeDynamics(body, -1, restitution=1.0, **smooth)  # those of two bodies are multiplied
        self._bodies = []
        for thing in case.things:
            body = b.createMultiBody(thing.mass, self._shape(thing), basePosition=thing.position)
            b.changeDynamics(body, -1, restitution=case.restitution, localInertiaDiagonal=thing.moments, **smooth)
            b.resetBaseVelocity(body, thing.velocity, thing.spin)
            self._bodies.append(body)

    def advance(self, steps):
        for _ in range(steps):
            self._b.stepSimulation()

    def state(self):
        poses = [self._b.getBasePositionAndOrientation(body) for body in self._bodies]
        twists = [self._b.getBaseVelocity(body) for body in self._bodies]
        rotation = [np.reshape(self._b.getMatrixFromQuaternion(q), (3, 3)) for _, q in poses]
        position, velocity, spin = (np.array(rows) for rows in ([x for x, _ in poses], *zip(*twists, strict=True)))
        return State(position, np.array(rotation), velocity, spin)

    def _shape(self, thing):
        b = self._b
        if isinstance(thing.parts[0].size, float):
            return b.createCollisionShape(b.GEOM_SPHERE, radius=thing.parts[0].size)
        halves = [[edge / 2 for edge in part.size] for part in thing.parts]
        if len(halves) == 1:
            return b.createCollisionShape(b.GEOM_BOX, halfExtents=halves[0])
        places = [part.at for part in thing.parts]
        return b.createCollisionShapeArray(
            [b.GEOM_BOX] * len(halves), halfExtents=halves, collisionFramePositions=places
        )


class Dart:
    """A boxed complementarity problem per step; bodies slower than 0.1 m/s do not bounce, as built in."""

    library = "dartpy"

    def __init__(self, case: Case, dt: float) -> None:
        import dartpy as dart

        self._dart, self._friction = dart, case.friction
        self._world = dart.simulation.World()
        self._world.setTimeStep(dt)
        self._world.setGravity([0.0, 0.0, -G])
        self._world.setCollisionDetector(dart.collision.BulletCollisionDetector())
        for k, (normal, at) in enumerate(case.walls):
            axis = int(np.argmax(np.abs(normal)))
            edges = np.where(np.arange(3) == axis, FLOOR, 2.0 * FLOOR)
            body = self._weld(f"wall-{k}", np.array(at) - 0.5 * FLOOR * np.array(normal))
            self._add_shape(body, dart.dynamics.BoxShape(edges), np.zeros(3), 1.0)  # restitutions are multiplied
        self._bodies = [self._free(f"thing-{k}", thing, case.restitution) for k, thing in enumerate(case.things)]

    def advance(self, steps):
        for _ in range(steps):
            self._world.step()

    def state(self):
        transforms = [body.getWorldTransform() for body in self._bodies]
        return State(
            np.array([transform.translation() for transform in transforms]),
            np.array([transform.rotation() for transform in transforms]),
            np.array([body.getLinearVelocity() for body in self._bodies]),
            np.array([body.getAngularVelocity() for body in self._bodies]),
        )

    def _weld(self, name, at):
        skeleton = self._dart.dynamics.Skeleton(name)
        joint, body = skeleton.createWeldJointAndBodyNodePair()
        place = self._dart.math.Isometry3()
        place.set_translation(at)
        joint.setTransformFromParentBodyNode(place)
        self._world.addSkeleton(skeleton)
        return body

    def _free(self, name, thing, restitution):
        dynamics = self._dart.dynamics
        skeleton = dynamics.Skeleton(name)
        joint, body = skeleton.createFreeJointAndBodyNodePair()
        body.setInertia(dynamics.Inertia(thing.mass, np.zeros(3), np.diag(thing.moments)))
        for part in thing.parts:
            sphere = isinstance(part.size, float)
            shape = dynamics.SphereShape(part.size) if sphere else dynamics.BoxShape(part.size)
            self._add_shape(body, shape, part.at, restitution)
        joint.setPositions([0.0, 0.0, 0.0, *thing.position])
        joint.setVelocities([*thing.spin, *thing.velocity])  # at the start the body's axes are the world's
        self._world.addSkeleton(skeleton)
        return body

    def _add_shape(self, body, shape, at, restitution):
        node = body.createShapeNode(shape)
        node.setRelativeTranslation(at)
        node.createCollisionAspect()
        aspect = node.createDynamicsAspect()
        aspect.setFrictionCoeff(self._friction)
        aspect.setRestitutionCoeff(restitution)


ALL: dict[str, type[Party]] = {"comotion": Comotion, "MuJoCo": MuJoCo, "Bullet": Bullet, "DART": Dart}
LIBRARIES = {name: party.library for name, party in ALL.items()}
PARTIES = {name: party for name, party in ALL.items() if find_spec(party.library)}
