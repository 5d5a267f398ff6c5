"""Playing a simulation and looking at what it did: for tests of physics."""

from dataclasses import replace

import numpy as np

from comotion_server.geometry import distance
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import rotation_from_quaternion
from comotion_server.scene import Free, Plane

SAME_TIME = 1e-12  # [s]: rows of one patch, or of one cluster, have one time


def play(sim, duration, dt, **given):
    """Steps of `dt` [s] over a duration [s]: all impacts, in order."""
    return [impact for _ in range(round(duration / dt)) for impact in sim.step(dt, **given).impacts]


def hits(impacts, *bodies):
    """Times [s] at which bodies hit: each pair once at a time, however many points its patch has."""
    pairs = {(i.body_a, i.body_b, round(i.time / SAME_TIME)): i for i in impacts if set(bodies) <= {i.body_a, i.body_b}}
    return np.array(sorted(impact.time for impact in pairs.values()))


def momentum(sim):
    """Total (3,) [kg m/s] of the bodies with a mass."""
    return np.nansum(sim.bodies.mass[:, None] * sim.bodies.velocity, axis=0)


def row_of(sim, name):
    return sim.bodies.names.index(name)


def smallest_gap(sim, within=0.01):
    """Smallest distance [m] of two bodies of which one can move away, if any is `within` [m]; 0: they overlap."""
    x, scales = sim.bodies.position, sim.bodies.scale
    bodies = [_scaled(body, s) for body, s in zip(sim.scene.bodies, scales, strict=True)]
    R = [rotation_from_quaternion(q) for q in sim.bodies.quaternion]
    found = within
    for j, b in enumerate(bodies):
        for i, a in enumerate(bodies[:j]):
            if not (isinstance(a.motion, Free) or isinstance(b.motion, Free)):
                continue
            if isinstance(a.shape, Plane) or isinstance(b.shape, Plane):
                (p, plane), (m, mesh) = ((i, a), (j, b)) if isinstance(a.shape, Plane) else ((j, b), (i, a))
                points = mesh.shape.vertices @ R[m].T + x[m]
                found = min(found, ((points - x[p]) @ (R[p] @ plane.shape.normal)).min())
            elif np.linalg.norm(x[i] - x[j]) < 0.5 * (a.mesh.size + b.mesh.size) + within:
                found = min(found, distance(a.mesh, (R[i], x[i]), b.mesh, (R[j], x[j])).distance)
    return found


def _scaled(body, s):
    """The body as healing has left it."""
    if s == 1.0:
        return body
    return replace(body, shape=TriangleMesh(s * body.mesh.vertices, body.mesh.triangles))


def energy(sim):
    """Kinetic and potential [J] of the bodies that can move."""
    total, gravity = 0.0, sim.scene.gravity
    for k, body in enumerate(sim.scene.bodies):
        if isinstance(body.motion, Free):
            x, v, w = sim.bodies.position[k], sim.bodies.velocity[k], sim.bodies.angular_velocity[k]
            R = rotation_from_quaternion(sim.bodies.quaternion[k])
            total += 0.5 * body.mass * v @ v + 0.5 * w @ R @ body.inertia @ R.T @ w - body.mass * gravity @ x
    return total


def angular_momentum(sim):
    """Total (3,) about the world origin [kg m2/s] of the bodies that can move."""
    total = np.zeros(3)
    for k, body in enumerate(sim.scene.bodies):
        if isinstance(body.motion, Free):
            R = rotation_from_quaternion(sim.bodies.quaternion[k])
            spin = R @ body.inertia @ R.T @ sim.bodies.angular_velocity[k]
            total += spin + body.mass * np.cross(sim.bodies.position[k], sim.bodies.velocity[k])
    return total
