"""Scenes built by hand for the tests of the server."""

import numpy as np

from comotion_server.meshes import box, mass_properties
from comotion_server.scene import Body, Collisions, Fixed, Free, Plane, Prescribed, Scene


def solid(name, mesh, *, density=None, mass=None, motion=None, **state):
    """A body of uniform density about its centre of mass."""
    properties = mass_properties(mesh.vertices, mesh.triangles)
    density = mass / properties.volume if density is None else density
    vectors = {key: np.asarray(value, dtype=float) for key, value in state.items() if not isinstance(value, str)}
    words = {key: value for key, value in state.items() if isinstance(value, str)}
    return Body(
        name,
        words.pop("region", name),
        motion or Free(),
        density * properties.volume,
        density * properties.inertia,
        mesh,
        **vectors,
        **words,
    )


def free_box(name="box", size=(1.0, 2.0, 3.0), mass=2.0, **state):
    return solid(name, box(list(size)), mass=mass, **state)


def fixed_box(name, size, position):
    return solid(name, box(list(size)), density=1.0, motion=Fixed(), position=position)


def moved_box(name, size, position, velocity):
    motion = Prescribed(velocity=np.asarray(velocity, dtype=float))
    return solid(name, box(list(size)), density=1.0, motion=motion, position=position)


def plane(name="floor", normal=(0.0, 0.0, 1.0), position=(0.0, 0.0, 0.0), velocity=None):
    """A half space below its position, fixed unless it has a velocity."""
    motion = Fixed() if velocity is None else Prescribed(velocity=np.asarray(velocity, dtype=float))
    shape = Plane(np.asarray(normal, dtype=float) / np.linalg.norm(normal))
    return Body(name, name, motion, np.nan, np.full((3, 3), np.nan), shape, np.asarray(position, dtype=float))


def scene_of(*bodies, gravity=(0.0, 0.0, 0.0), **collisions):
    return Scene("by hand", np.asarray(gravity, dtype=float), 1.0, 0.01, Collisions(**collisions), bodies)
