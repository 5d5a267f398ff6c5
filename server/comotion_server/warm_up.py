"""Compiles what a scene's plan can call before the first client comes, so that no step of a run waits for a compiler.

Numba compiles a kernel when it is first called; from then on it lies in the cache of this machine. A little scene that
meets everything once (nodal forces, a turning flight, a prediction, an impact; an overlap under the paper's rules, a
held contact that is hit under rule `exact`) calls them all: minutes the first time, seconds from the cache.
"""

from dataclasses import replace

import numpy as np

from comotion_server.meshes import TriangleMesh, box
from comotion_server.plan import Plan
from comotion_server.quaternions import quaternion_of, rotation_from_quaternion
from comotion_server.scene import Body, Capsule, Cylinder, Fixed, Free, Plane, Scene, Sphere
from comotion_server.simulation import Simulation

STEP = 0.01  # [s]
STEPS = 3
BALL_STEPS = 60  # until the ball has come down, bounced and rested
GAP = 0.005  # [m] half of what the falling cube covers in a step: it lands in it
FALL = np.array([0.0, 0.0, -10.0])  # [m/s2] bends the path, so that one sub-step ends inside the floor (P14)
APART = np.array([9.0, 0.0, 0.0])  # [m] where a ball meets nothing
TILT = quaternion_of(np.array([0.5, 0.3, 0.0]))  # the cube comes corner first: both criteria of P12 have to be judged


def warm_up(scene: Scene) -> None:
    """Compiles the kernels that `scene` can need; the scene itself is not touched."""
    kinds = TriangleMesh | Capsule | Cylinder if Plan(scene).keeps("collisions") else TriangleMesh
    if any(isinstance(body.shape, kinds) for body in scene.bodies):
        _meet_cubes(scene)
    else:
        _meet_balls(scene)


def _meet_balls(scene: Scene) -> None:
    """A ball falls onto one that rests on a floor: all that a scene without meshes can need."""
    inertia, beside = 0.1 * np.eye(3), np.array([0.3, 0.2, 0.5])
    at, velocity = np.array([0.0, 0.0, 1.5]), np.array([0.0, 0.0, -1.0])
    bodies = [Body("ball", "ball", Free(), 1.0, inertia, Sphere(0.5), at, velocity=velocity)]
    if Plan(scene).keeps("collisions"):
        bodies.append(Body("floor", "floor", Fixed(), np.nan, inertia, Plane(np.array([0.0, 0.0, 1.0]))))
        bodies.append(Body("seat", "seat", Free(), 1.0, inertia, Sphere(0.5), beside))
    simulation = Simulation(Scene("warm-up", FALL, STEP, STEP, scene.collisions, tuple(bodies)))
    wrenches = np.zeros((len(bodies), 6))
    wrenches[0] = 1e-3  # [N], [N m]: it turns
    for _ in range(BALL_STEPS):
        simulation.mark_sent(simulation.sample(1e-3 * STEP))
        simulation.step(STEP, wrenches=wrenches)


def _meet_cubes(scene: Scene) -> None:
    """A cube meets what a scene of meshes can meet."""
    shape, inertia = box([1.0, 1.0, 1.0]), np.eye(3) / 6.0
    lowest = float((shape.vertices @ rotation_from_quaternion(TILT).T)[:, 2].min())
    at, velocity = np.array([0.0, 0.0, GAP - lowest]), np.array([0.0, 0.0, -1.0])
    bodies = [Body("cube", "cube", Free(), 1.0, inertia, shape, at, quaternion=TILT, velocity=velocity)]
    collisions = scene.collisions
    if Plan(scene).keeps("collisions"):
        bodies.append(Body("floor", "floor", Fixed(), 1.0, inertia, shape, position=np.array([0.0, 0.0, -0.5])))
        if collisions.rule == "exact":
            beside = np.array([0.3, 0.2, 0.5])
            bodies[0] = replace(bodies[0], position=at + 2.0 * beside * np.array([0.0, 0.0, 1.0]))
            bodies.append(Body("seat", "seat", Free(), 1.0, inertia, shape, position=beside))
            if any(isinstance(body.shape, Cylinder) for body in scene.bodies):  # other code than without
                bodies.append(Body("tin", "tin", Free(), 1.0, inertia, Cylinder(0.5, 1.0), APART))
            elif any(isinstance(body.shape, Sphere | Capsule) for body in scene.bodies):  # likewise
                bodies.append(Body("ball", "ball", Free(), 1.0, inertia, Sphere(0.5), position=APART))
        else:
            collisions = replace(collisions, rule="paper-advance", substeps=1)
    simulation = Simulation(Scene("warm-up", FALL, STEP, STEP, collisions, tuple(bodies)))
    sample = simulation.sample(1e-3 * STEP, velocities=True)
    simulation.mark_sent(sample)
    push = np.zeros_like(sample.vertices["cube"])
    push[0, 2] = 1e-3  # [N] at a corner: it turns the cube
    for _ in range(STEPS):
        simulation.step(STEP, {"cube": push})
