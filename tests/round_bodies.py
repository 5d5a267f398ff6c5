"""Round bodies for scenes by hand."""

import numpy as np

from comotion_server.scene import Body, Capsule, Cylinder, Free, Sphere


def round_body(name, shape, mass, motion=None, **state):
    """A body of a round shape, of uniform density."""
    vectors = {key: np.asarray(value, dtype=float) for key, value in state.items()}
    return Body(name, name, motion or Free(), mass, mass / shape.volume * shape.inertia, shape, **vectors)


def sphere(name="ball", radius=0.1, mass=1.0, motion=None, **state):
    return round_body(name, Sphere(radius), mass, motion, **state)


def capsule(name="capsule", radius=0.1, length=1.0, mass=2.0, axis=0, motion=None, **state):
    return round_body(name, Capsule(radius, length, axis), mass, motion, **state)


def cylinder(name="cylinder", radius=0.1, length=1.0, mass=2.0, axis=2, motion=None, **state):
    return round_body(name, Cylinder(radius, length, axis), mass, motion, **state)
