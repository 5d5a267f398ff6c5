"""Small and large angles of a floating box: naval architecture's closed forms for wall-sided bodies."""

import numpy as np
import pytest

from comotion_mock_cfd.box_form import SIZE
from comotion_mock_cfd.hydrostatics import hydrostatic_forces
from comotion_mock_cfd.nodal import wrench_about

WATER, GRAVITY = 1000.0, 9.81
LENGTH, BREADTH, HEIGHT = SIZE
DRAUGHT = 0.1
WEIGHT = WATER * GRAVITY * LENGTH * BREADTH * DRAUGHT
BM = BREADTH**2 / (12 * DRAUGHT)
GM = DRAUGHT / 2 + BM - HEIGHT / 2
# Sums of twelve facets, relative to the weight and the box's size.
ROUNDING = 1e-13


def heeled(vertices, angle):
    """Vertices turned about x by an angle [rad], the centre of mass in the water plane."""
    c, s = np.cos(angle), np.sin(angle)
    return vertices @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


@pytest.mark.parametrize("degrees", [0.0, 1e-3, 1.0, 5.0, 15.0, 26.0])
def test_righting_moment_of_a_wall_sided_box(box, degrees):
    # GZ = sin(a) (GM + BM tan^2(a) / 2), exact until the deck goes under at atan(0.1 / 0.2) = 26.6 degrees.
    vertices, triangles = box(SIZE)
    angle = np.radians(degrees)
    placed = heeled(vertices, angle)
    wrench = wrench_about(np.zeros(3), placed, hydrostatic_forces(placed, triangles, WATER, GRAVITY, 0.0))
    assert wrench[:3] == pytest.approx([0, 0, WEIGHT], abs=ROUNDING * WEIGHT)
    righting_arm = np.sin(angle) * (GM + 0.5 * BM * np.tan(angle) ** 2)
    assert wrench[3:] == pytest.approx([-WEIGHT * righting_arm, 0, 0], abs=ROUNDING * WEIGHT)


def test_roll_stiffness_is_weight_times_metacentric_height(box):
    vertices, triangles = box(SIZE)
    angle = 1e-4
    moments = []
    for turn in (-angle, angle):
        placed = heeled(vertices, turn)
        forces = hydrostatic_forces(placed, triangles, WATER, GRAVITY, 0.0)
        moments.append(wrench_about(np.zeros(3), placed, forces)[3])
    stiffness = (moments[0] - moments[1]) / (2 * angle)
    # The cubic term of GZ is of the order of angle squared, 1e-8; rounding divided by the angle is 1e-12.
    assert stiffness == pytest.approx(WEIGHT * GM, rel=1e-7)


def test_heave_stiffness_is_the_weight_of_a_layer_of_water(box):
    vertices, triangles = box(SIZE)
    for rise in (-0.05, -1e-6, 0.03):
        force = hydrostatic_forces(vertices + np.array([0, 0, rise]), triangles, WATER, GRAVITY, 0.0).sum(axis=0)
        expected = WEIGHT - WATER * GRAVITY * LENGTH * BREADTH * rise
        assert force == pytest.approx([0, 0, expected], abs=ROUNDING * WEIGHT)
