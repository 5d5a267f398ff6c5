"""Drag of reference bodies, and that it only ever takes energy."""

import numpy as np
import pytest

from comotion_mock_cfd.drag import add_drag
from comotion_mock_cfd.fluid import Drag, Fluid, FluidScene
from comotion_mock_cfd.fluid_forces import fluid_forces
from comotion_mock_cfd.nodal import wrench_about
from comotion_mock_cfd.water_line import wet_surface

WATER = 1000.0
# A few hundred facets, relative to the sum of magnitudes.
ROUNDING = 1e-13


def drag_of(vertices, triangles, velocities, level, form, friction):
    nodal = np.zeros_like(vertices)
    add_drag(nodal, wet_surface(vertices, triangles, level), velocities, WATER, form, friction)
    return nodal


def test_a_submerged_cube_face_on_has_the_form_coefficient_on_its_front_and_friction_on_four_sides(box):
    vertices, triangles = box((0.5, 0.5, 0.5))
    speed, form, friction = 2.0, 1.1, 0.01
    velocities = np.tile([speed, 0.0, 0.0], (8, 1))
    forces = drag_of(vertices, triangles, velocities, 10.0, form, friction)
    dynamic = 0.5 * WATER * speed**2 * 0.25
    wrench = wrench_about(np.zeros(3), vertices, forces)
    assert wrench == pytest.approx([-dynamic * (form + 4 * friction), 0, 0, 0, 0, 0], abs=ROUNDING * dynamic)


def test_a_half_submerged_cube_has_half_the_drag_at_half_the_depth(box):
    vertices, triangles = box((1.0, 1.0, 1.0))
    forces = drag_of(vertices, triangles, np.tile([1.0, 0.0, 0.0], (8, 1)), 0.0, 1.0, 0.0)
    wrench = wrench_about(np.zeros(3), vertices, forces)
    force = -0.5 * WATER * 0.5
    # The wetted half of the front has its centroid a quarter below the origin: moment (r x F)_y = z F_x.
    assert wrench == pytest.approx([force, 0, 0, 0, -0.25 * force, 0], abs=ROUNDING * 500)


def test_a_sphere_has_half_the_form_coefficient_and_the_friction_of_its_flanks(icosphere):
    # Integrals of cos^3 over the front (Newton's sine-squared law) and of sin^3 over the sphere.
    form_area, friction_area = np.pi / 2, 3 * np.pi**2 / 4
    for coefficients, area in (((1.0, 0.0), form_area), ((0.0, 1.0), friction_area)):
        errors = []
        for divisions in (2, 3, 4):
            vertices, triangles = icosphere(divisions)
            velocities = np.tile([0.0, 0.0, 1.0], (len(vertices), 1))
            force = drag_of(vertices, triangles, velocities, 2.0, *coefficients).sum(axis=0)
            errors.append(abs(force[2] / (-0.5 * WATER * area) - 1.0))
        assert errors[-1] < 5e-3  # the facets' chords: second order, 642 vertices and more
        assert errors[0] / errors[1] > 3.0
        assert errors[1] / errors[2] > 3.0


@pytest.mark.parametrize("seed", range(20))
def test_drag_never_gives_energy_whatever_the_motion(icosphere, rotation, seed):
    rng = np.random.default_rng(seed)
    vertices, triangles = icosphere(1)
    vertices = vertices * rng.uniform(0.3, 1.7, (len(vertices), 1)) @ rotation(rng).T
    current = rng.normal(size=3)
    velocities = rng.normal(size=3) + np.cross(rng.normal(size=3), vertices) + current
    fluid = Fluid(level=rng.uniform(-1, 1), current=tuple(current), drag=Drag(form=1.0, friction=0.1))
    scene = FluidScene(fluid, gravity=0.0, dt=1.0, duration=1.0)
    forces = fluid_forces(scene, vertices, velocities, triangles)
    power = np.vdot(forces, velocities - current)
    assert power < 0.0


def test_a_body_that_goes_with_the_current_has_no_drag(icosphere):
    vertices, triangles = icosphere(1)
    current = (0.3, -0.2, 0.1)
    fluid = Fluid(current=current, drag=Drag(form=1.0, friction=1.0))
    velocities = np.tile(current, (len(vertices), 1))
    still = fluid_forces(FluidScene(fluid, 0.0, 1.0, 1.0), vertices, velocities, triangles)
    assert not still.any()


def test_a_facet_without_area_has_no_drag_and_no_nan():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    forces = drag_of(vertices, np.array([[0, 1, 2]]), np.ones((3, 3)), 1.0, 1.0, 1.0)
    assert not forces.any()
