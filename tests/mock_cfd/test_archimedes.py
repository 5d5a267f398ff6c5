"""Hydrostatics against Archimedes: the force is the weight of the displaced water, acting at its centroid."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from comotion_mock_cfd.hydrostatics import hydrostatic_forces
from comotion_mock_cfd.nodal import wrench_about

WATER, GRAVITY = 1000.0, 9.81
WEIGHT = WATER * GRAVITY
# Sums of some hundred facets in double precision, relative to the sum of the magnitudes: a few units of 1e-16 each.
ROUNDING = 1e-13


def volume_and_moment(vertices, triangles):
    """Volume and first moment (integral of x) of a closed mesh by the divergence theorem, about its own middle."""
    middle = vertices.mean(axis=0)
    a, b, c = (vertices[triangles[:, i]] - middle for i in range(3))
    volumes = np.einsum("ki,ki->k", a, np.cross(b, c)) / 6
    return volumes.sum(), volumes @ (a + b + c) / 4 + volumes.sum() * middle


def cube_below(normal, height):
    """Volume and first moment of the unit cube [0, 1]^3 where normal . x <= height, in rational numbers.

    Inclusion and exclusion over the corners v: every term is the simplex normal . (x - v) <= h = height - normal . v
    cut from the octant at v, of volume h^3 / (6 n1 n2 n3) and first moment about v h^4 / (24 n1 n2 n3 n_i).
    """
    flip = [n < 0 for n in normal]
    height = Fraction(height) - sum(Fraction(n) for n in normal if n < 0)
    n = [abs(Fraction(x)) for x in normal]
    volume, moment = Fraction(0), [Fraction(0)] * 3
    for corner in product((0, 1), repeat=3):
        h = height - sum(ni * vi for ni, vi in zip(n, corner, strict=True))
        if h <= 0:
            continue
        part = (-1) ** sum(corner) * h**3 / (6 * n[0] * n[1] * n[2])
        volume += part
        moment = [m + part * (v + h / (4 * ni)) for m, v, ni in zip(moment, corner, n, strict=True)]
    moment = [volume - m if f else m for m, f in zip(moment, flip, strict=True)]
    return float(volume), np.array([float(m) for m in moment])


def fraction_below(heights, level):
    """Share of a tetrahedron below a level, from the heights of its corners, in rational numbers.

    The volume under a moving plane is a cubic B-spline whose knots are the heights (Curry and Schoenberg 1966), written
    with truncated powers.
    """
    h, level = [Fraction(x) for x in heights], Fraction(level)
    share = Fraction(0)
    for i, low in enumerate(h):
        if low < level:
            others = [other - low for j, other in enumerate(h) if j != i]
            share += (level - low) ** 3 / (others[0] * others[1] * others[2])
    return float(share)


def test_a_dry_body_has_exactly_no_force(icosphere):
    vertices, triangles = icosphere(2)
    forces = hydrostatic_forces(vertices, triangles, WATER, GRAVITY, -1.0 - 1e-12)
    assert not forces.any()


@pytest.mark.parametrize("seed", range(4))
def test_a_wet_body_of_any_shape_has_its_displacement_about_any_point(icosphere, rotation, seed):
    rng = np.random.default_rng(seed)
    vertices, triangles = icosphere(2)
    # Dents of random depth, so that the body is not convex; no symmetry is left to help.
    vertices = vertices * rng.uniform(0.5, 1.5, (len(vertices), 1)) @ rotation(rng).T + rng.normal(size=3)
    level = vertices[:, 2].max() + rng.uniform(0.0, 3.0)
    forces = hydrostatic_forces(vertices, triangles, WATER, GRAVITY, level)
    volume, moment = volume_and_moment(vertices, triangles)
    point = 5.0 * rng.normal(size=3)
    wrench = wrench_about(point, vertices, forces)
    scale = np.abs(forces).sum()
    assert wrench[:3] == pytest.approx([0, 0, WEIGHT * volume], abs=ROUNDING * scale)
    arm = moment / volume - point
    lever = np.linalg.norm(vertices - point, axis=1).max()
    assert wrench[3:] == pytest.approx(np.cross(arm, [0, 0, WEIGHT * volume]), abs=ROUNDING * scale * lever)


@pytest.mark.parametrize("seed", range(25))
def test_a_cube_cut_by_any_plane_displaces_the_exact_volume(box, rotation, seed):
    rng = np.random.default_rng(100 + seed)
    vertices, triangles = box((1.0, 1.0, 1.0))
    turned = rotation(rng)
    placed = vertices @ turned.T
    level = rng.uniform(placed[:, 2].min(), placed[:, 2].max())
    # In the cube's own coordinates, x' = x + 1/2, the water is where up . x' <= level + up . (1/2, 1/2, 1/2).
    up = turned[2]
    volume, moment = cube_below(up, level + sum(map(Fraction, up)) / 2)
    forces = hydrostatic_forces(placed, triangles, WATER, GRAVITY, level)
    wrench = wrench_about(np.zeros(3), placed, forces)
    assert wrench[:3] == pytest.approx([0, 0, WEIGHT * volume], abs=ROUNDING * WEIGHT)
    centre_moment = turned @ (moment - volume / 2)  # first moment about the cube's centre, world
    expected = np.cross(centre_moment, [0, 0, WEIGHT])
    assert wrench[3:] == pytest.approx(expected, abs=ROUNDING * WEIGHT)


@pytest.mark.parametrize("seed", range(5))
def test_a_dented_body_cut_by_the_water(icosphere, rotation, seed):
    rng = np.random.default_rng(200 + seed)
    vertices, triangles = icosphere(1)
    vertices = vertices * rng.uniform(0.4, 1.6, (len(vertices), 1)) @ rotation(rng).T
    level = rng.uniform(-0.5, 0.5)
    # Signed tetrahedra from the origin to every facet, each cut for itself.
    volume = 0.0
    for a, b, c in vertices[triangles]:
        volume += np.dot(a, np.cross(b, c)) / 6 * fraction_below((0.0, a[2], b[2], c[2]), level)
    force = hydrostatic_forces(vertices, triangles, WATER, GRAVITY, level).sum(axis=0)
    assert force == pytest.approx([0, 0, WEIGHT * volume], abs=ROUNDING * WEIGHT)


@pytest.mark.parametrize(("level", "volume"), [(-0.5, 0.0), (-0.2, 0.3), (0.0, 0.5), (0.5, 1.0), (0.7, 1.0)])
def test_an_upright_cube_with_faces_and_edges_in_the_water_plane(box, level, volume):
    vertices, triangles = box((1.0, 1.0, 1.0))
    force = hydrostatic_forces(vertices, triangles, WATER, GRAVITY, level).sum(axis=0)
    assert force == pytest.approx([0, 0, WEIGHT * volume], abs=ROUNDING * WEIGHT)


@pytest.mark.parametrize("apex", [1, -1])
@pytest.mark.parametrize("wet", [1e-6, 0.1, 0.5, 0.9, 0.999])
def test_a_tetrahedron_with_its_apex_up_or_down(apex, wet):
    base = np.array([[0.0, 0.0, 0.0], [1.3, 0.1, 0.0], [0.4, 0.9, 0.0], [0.5, 0.3, 2.0 * apex]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])[:, ::apex]
    low, height = base[:, 2].min(), 2.0
    level = low + wet * height
    whole = 0.5 * np.cross(base[1], base[2])[2] * height / 3
    tip = (1.0 - (level - low) / height) if apex > 0 else (level - low) / height  # the pyramid cut off at the apex
    volume = whole * (1.0 - tip**3 if apex > 0 else tip**3)
    # A pyramid's centroid is a quarter of the way from the base's centroid to the apex.
    middle, top = base[:3].mean(axis=0), base[3]
    tip_centre = top + 0.75 * tip * (middle - top)
    centre_moment = volume * tip_centre
    if apex > 0:
        centre_moment = whole * (0.75 * middle + 0.25 * top) - whole * tip**3 * tip_centre
    forces = hydrostatic_forces(base, triangles, WATER, GRAVITY, level)
    wrench = wrench_about(np.zeros(3), base, forces)
    assert wrench[:3] == pytest.approx([0, 0, WEIGHT * volume], abs=ROUNDING * WEIGHT * whole)
    expected = np.cross(centre_moment, [0, 0, WEIGHT])
    assert wrench[3:] == pytest.approx(expected, abs=ROUNDING * WEIGHT * whole)


def test_a_drop_of_wetness_keeps_its_digits():
    # The lowest corner dips by 1e-7 m: its tiny displacement is not the difference of large numbers.
    base = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [-1.0, -1.0, 1.0]])
    triangles = np.array([[1, 2, 3], [0, 2, 1], [0, 3, 2], [0, 1, 3]])
    depth = 1e-7
    force = hydrostatic_forces(base, triangles, WATER, GRAVITY, depth).sum(axis=0)
    assert force[2] == pytest.approx(WEIGHT * 1.5 * depth**3 / 3, rel=1e-12)


def test_a_sphere_converges_to_the_spherical_cap_with_the_square_of_the_facets(icosphere):
    level = 0.3
    cap = np.pi * (1 + level) ** 2 * (3 - (1 + level)) / 3
    errors = []
    for divisions in (2, 3, 4):
        force = hydrostatic_forces(*icosphere(divisions), WATER, GRAVITY, level).sum(axis=0)
        errors.append(1.0 - force[2] / (WEIGHT * cap))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert ratios == pytest.approx([4, 4], rel=0.05)  # chords: second order, and already asymptotic
