"""Bodies and scenes that several studies need, in few words."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from comotion_server.meshes import TriangleMesh, box, mass_properties
from comotion_server.scene import Body, Collisions, Fixed, Free, Plane, Prescribed, Scene, Sphere

if TYPE_CHECKING:
    from comotion_server.results import Impact
    from comotion_server.simulation import Simulation

G = 9.81  # [m/s2]
CUBE = (1.0, 1.0, 1.0)  # [m]


def ball(radius: float, halvings: int) -> TriangleMesh:
    """A ball of facets [m]."""
    from comotion_mock_cfd.body_forms import ball_mesh

    vertices, triangles = ball_mesh(radius, halvings)
    return TriangleMesh(vertices, triangles.astype(np.uint32))


def solid(name: str, mesh: TriangleMesh, mass: float = 1.0, motion: Any = None, **state: Any) -> Body:
    """A body of uniform density."""
    properties = mass_properties(mesh.vertices, mesh.triangles)
    vectors: dict[str, Any] = {key: np.asarray(value, dtype=float) for key, value in state.items()}
    return Body(name, name, motion or Free(), mass, properties.inertia * mass / properties.volume, mesh, **vectors)


def brick(name: str, size: Any, mass: float = 1.0, motion: Any = None, **state: Any) -> Body:
    """A box with edges [m]."""
    return solid(name, box(size), mass, motion, **state)


def sphere(name: str, radius: float, mass: float = 1.0, **state: Any) -> Body:
    """A round ball of uniform density; radius [m]."""
    vectors: dict[str, Any] = {key: np.asarray(value, dtype=float) for key, value in state.items()}
    return Body(name, name, Free(), mass, 0.4 * mass * radius**2 * np.eye(3), Sphere(radius), **vectors)


def wall(name: str, size: Any, position: Any) -> Body:
    """A box that never moves."""
    return brick(name, size, motion=Fixed(), position=position)


def driven(name: str, size: Any, position: Any, velocity: Any) -> Body:
    """A box with a prescribed velocity [m/s]."""
    return brick(name, size, motion=Prescribed(velocity=np.asarray(velocity, dtype=float)), position=position)


def plane(name: str = "floor", normal: Any = (0.0, 0.0, 1.0), position: Any = (0.0, 0.0, 0.0)) -> Body:
    """A fixed half space."""
    shape = Plane(np.asarray(normal, dtype=float))
    return Body(name, name, Fixed(), np.nan, np.full((3, 3), np.nan), shape, np.asarray(position, dtype=float))


def simulation(*bodies: Body, gravity: float = 0.0, **collisions: Any) -> "Simulation":
    """At time 0; gravity [m/s2] pulls down."""
    from comotion_server.simulation import Simulation

    in_order = tuple(sorted(bodies, key=lambda body: body.name))
    return Simulation(Scene("report", np.array([0.0, 0.0, -gravity]), 1.0, 0.01, Collisions(**collisions), in_order))


def play(sim: "Simulation", duration: float, dt: float) -> "list[Impact]":
    """Steps of `dt` [s] over a duration [s]: all impacts, in order."""
    return [impact for _ in range(round(duration / dt)) for impact in sim.step(dt).impacts]


def player(make: "Callable[[], Simulation]", duration: float, dt: float) -> "Callable[[], Callable[[], Any]]":
    """What `timed_from` takes: gives the simulation, the impacts, and leaves making it out of the figure."""

    def prepared() -> Callable[[], Any]:
        sim = make()
        return lambda: (sim, play(sim, duration, dt))

    return prepared
