"""Round shapes: masses against quadrature, their triangles against the surface, and vertices only when asked for."""

import numpy as np
import pytest
from scipy.integrate import quad

from comotion_server.meshes.mass import mass_properties
from comotion_server.meshes.repair import repair
from comotion_server.scene import Body, Capsule, Collisions, Cylinder, Free, Pipe, Scene, Sphere
from comotion_server.simulation import Simulation

QUADRATURE = 1e-10  # relative: what the integrals over the profile are asked for
ON_SURFACE = 1e-15  # of the size: rounding of a vertex
SHAPES = [
    Sphere(0.5),
    Capsule(0.3, 0.8),
    Capsule(0.3, 0.8, axis=0),
    Cylinder(0.4, 1.4),
    Cylinder(0.4, 0.05, axis=1),
    Pipe(0.3, 0.4, 1.2),
    Pipe(0.3, 0.4, 1.2, axis=0, caps=True),
]
IDS = [f"{shape.kind} {'xyz'[shape.axis]}" for shape in SHAPES]


def finer(shape, resolution):
    fields = {name: getattr(shape, name) for name in shape.__dataclass_fields__}
    return type(shape)(**fields | {"resolution": resolution})


def rings(shape, z):
    """(inner, outer) radius of the section at a height along the axis."""
    if isinstance(shape, Pipe):
        return shape.inner_radius, shape.outer_radius
    if isinstance(shape, Sphere):
        return 0.0, np.sqrt(max(shape.radius**2 - z * z, 0.0))
    beyond = max(abs(z) - 0.5 * shape.length, 0.0) if isinstance(shape, Capsule) else 0.0
    return 0.0, np.sqrt(max(shape.radius**2 - beyond**2, 0.0))


@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_mass_properties_are_the_integrals_over_the_sections(shape):
    h = shape.half_extents[0]
    kinks = [-0.5 * shape.length, 0.5 * shape.length] if isinstance(shape, Capsule) else None

    def integral(f):
        def section(z):
            inner, outer = rings(shape, z)
            return f(z, outer) - f(z, inner)

        return quad(section, -h, h, points=kinks, epsabs=0.0, epsrel=QUADRATURE, limit=200)[0]

    volume = integral(lambda _, r: np.pi * r**2)
    about = integral(lambda _, r: 0.5 * np.pi * r**4)
    across = integral(lambda z, r: 0.25 * np.pi * r**4 + np.pi * r**2 * z * z)
    moments = np.where(np.arange(3) == shape.axis, about, across)
    assert shape.volume == pytest.approx(volume, rel=10 * QUADRATURE)
    assert np.diag(shape.inertia) == pytest.approx(moments, rel=10 * QUADRATURE)
    assert np.count_nonzero(shape.inertia - np.diag(np.diag(shape.inertia))) == 0


def off_surface(shape, points):
    """How far points are from the surface."""
    z = points[:, shape.axis]
    rho = np.linalg.norm(np.delete(points, shape.axis, axis=1), axis=1)
    if isinstance(shape, Sphere):
        return np.hypot(z, rho) - shape.radius
    h = 0.5 * shape.length
    if isinstance(shape, Capsule):
        return np.hypot(np.maximum(np.abs(z) - h, 0.0), rho) - shape.radius
    ends = np.abs(np.abs(z) - h)
    if isinstance(shape, Pipe):
        return np.minimum(np.minimum(np.abs(rho - shape.inner_radius), np.abs(rho - shape.outer_radius)), ends)
    return np.minimum(np.abs(rho - shape.radius), ends)


@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_the_triangles_are_closed_and_inscribed(shape):
    mesh = shape.mesh
    health = repair(mesh.vertices, mesh.triangles.astype(np.int64)).health
    assert health.closed
    assert health.turned_facets == health.turned_shells == health.zero_area == 0
    assert len(mesh.vertices) == shape.vertex_count
    assert np.abs(off_surface(shape, mesh.vertices)).max() <= 4 * ON_SURFACE * shape.radius_about_centre
    assert mesh.size == pytest.approx(2.0 * shape.radius_about_centre, rel=ON_SURFACE * 4)
    assert (np.abs(mesh.vertices).max(axis=0) <= shape.outline.max(axis=0) * (1.0 + ON_SURFACE)).all()


@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_the_volume_of_the_triangles_converges_in_second_order(shape):
    errors = []
    for resolution in (32, 64, 128):
        mesh = finer(shape, resolution).mesh
        errors.append(shape.volume - mass_properties(mesh.vertices, mesh.triangles).volume)
    assert 0.0 < errors[0] < 0.03 * shape.volume
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.01)


@pytest.mark.parametrize("resolution", [3, 5, 7, 50])
def test_any_resolution_gives_a_closed_surface(resolution):
    for shape in SHAPES:
        mesh = finer(shape, resolution).mesh
        assert repair(mesh.vertices, mesh.triangles.astype(np.int64)).health.closed
        assert len(mesh.vertices) == finer(shape, resolution).vertex_count


@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_vertices_are_made_only_when_they_are_asked_for(shape):
    shape = finer(shape, 8)
    body = Body("one", "one", Free(), 2.0, 2.0 / shape.volume * shape.inertia, shape)
    simulation = Simulation(Scene("alone", np.array([0.0, 0.0, -10.0]), 1.0, 0.1, Collisions(), (body,)))
    start = simulation.checkpoint()
    simulation.step(0.1, wrenches=[[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    by_wrench = simulation.bodies.position, simulation.bodies.quaternion
    assert "mesh" not in vars(shape)
    simulation.restore(start)
    vertices = simulation.vertices("one")
    assert vertices == pytest.approx(shape.mesh.vertices, abs=1e-15)
    assert simulation.regions[0].vertex_count == shape.vertex_count
    forces = np.tile([2.0 / len(vertices), 0.0, 0.0], (len(vertices), 1))
    simulation.step(0.1, forces={"one": forces})
    assert simulation.bodies.position == pytest.approx(by_wrench[0], abs=1e-14)
    assert simulation.bodies.quaternion == pytest.approx(by_wrench[1], abs=1e-14)
