"""Mass properties against closed forms, a second method, and what rotation, translation and scaling must do."""

import numpy as np
import pytest
from mesh_forms import cube, sphere, torus

from comotion_server.meshes import MeshError, TriangleMesh, box, mass_properties, prism
from comotion_server.meshes.mass import centred, surface_centre
from comotion_server.meshes.shapes import box_properties, prism_properties

ROUNDING = 1e-12  # a few hundred sums and products in double precision, the figure the project promises
SECOND_METHOD = 1e-9  # trimesh sums about the world origin, one after the other


def assert_same(found, expected, rtol=ROUNDING):
    scale = np.abs(expected.inertia).max()
    assert found.volume == pytest.approx(expected.volume, rel=rtol)
    np.testing.assert_allclose(found.inertia, expected.inertia, rtol=0, atol=rtol * scale)


@pytest.mark.parametrize("offset", [0.0, 1e6, -1e6])
def test_unit_cube_wherever_it_is(offset):
    vertices, triangles = cube(offset=3 * (offset,))
    mass = mass_properties(vertices, triangles)
    assert mass.volume == pytest.approx(1.0, rel=ROUNDING)
    np.testing.assert_allclose(mass.inertia, np.eye(3) / 6, rtol=0, atol=ROUNDING / 6)
    np.testing.assert_array_equal(mass.centre, np.full(3, offset + 0.5))  # exact in binary


def test_tetrahedron_in_rational_numbers():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    mass = mass_properties(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    assert mass.volume == pytest.approx(1 / 6, rel=ROUNDING)
    np.testing.assert_allclose(mass.centre, np.full(3, 1 / 4), rtol=ROUNDING)
    # about the centre: integral of x2 = 1/60 - 1/96 = 1/160, of xy = 1/120 - 1/96 = -1/480
    np.testing.assert_allclose(mass.inertia, np.eye(3) * (1 / 80 - 1 / 480) + 1 / 480, rtol=0, atol=ROUNDING / 80)


@pytest.mark.parametrize("size", [(1, 2, 3), (1e-6, 2e-6, 5e-6), (1e4, 1e-3, 7.0)])
def test_box_meshes_agree_with_their_closed_forms(size):
    mesh = box(size)
    found = mass_properties(mesh.vertices, mesh.triangles)
    assert_same(found, box_properties(size))
    np.testing.assert_allclose(found.centre, 0, atol=ROUNDING * mesh.size)


@pytest.mark.parametrize("lengths", [(0.3, 0.2, 0.018), (1, 1, 1), (1e-3, 1e3, 1)])
def test_prism_meshes_agree_with_their_closed_forms(lengths):
    mesh = prism(*lengths)
    found = mass_properties(mesh.vertices, mesh.triangles)
    assert_same(found, prism_properties(*lengths))
    np.testing.assert_allclose(found.centre, 0, atol=ROUNDING * mesh.size)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx(lengths)


def test_ellipsoid_converges_with_second_order():
    axes = np.array([1.0, 2.0, 0.5])
    volume = 4 / 3 * np.pi * axes.prod()
    inertia = volume / 5 * np.diag((axes**2).sum() - axes**2)
    errors = []
    for rounds in (2, 3, 4, 5):
        vertices, triangles = sphere(rounds)
        mass = mass_properties(vertices * axes, triangles)
        errors.append(
            [abs(mass.volume / volume - 1), np.abs(mass.inertia / inertia.max() - inertia / inertia.max()).max()]
        )
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders[-1], 2.0, atol=0.05)  # edges halve, chords miss the sphere by their square


def test_a_moved_and_turned_body_has_the_same_properties_turned(rng):
    vertices, triangles = torus(12)
    vertices = vertices * [1.0, 0.7, 1.3] + 0.1 * np.sin(vertices[:, [1, 2, 0]])
    mass = mass_properties(vertices, triangles)
    for _ in range(10):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.linalg.det(turn)
        shift = rng.normal(size=3) * 10
        moved = mass_properties(vertices @ turn.T + shift, triangles)
        assert moved.volume == pytest.approx(mass.volume, rel=ROUNDING)
        np.testing.assert_allclose(moved.centre, turn @ mass.centre + shift, rtol=0, atol=100 * ROUNDING)
        np.testing.assert_allclose(
            moved.inertia, turn @ mass.inertia @ turn.T, rtol=0, atol=ROUNDING * mass.inertia.max()
        )


def test_powers_of_two_scale_bit_for_bit():
    vertices, triangles = torus(9)
    mass, scaled = mass_properties(vertices, triangles), mass_properties(vertices * 2.0**-20, triangles)
    assert scaled.volume == mass.volume * 2.0**-60
    np.testing.assert_array_equal(scaled.inertia, mass.inertia * 2.0**-100)


def test_trimesh_agrees():
    import trimesh

    vertices, triangles = torus(20)
    vertices = vertices * [1.0, 0.7, 1.3] + [0.3, -0.2, 0.1]
    peer = trimesh.Trimesh(vertices, triangles, process=False).mass_properties
    mass = mass_properties(vertices, triangles)
    assert mass.volume == pytest.approx(peer.volume, rel=SECOND_METHOD)
    np.testing.assert_allclose(mass.centre, peer.center_mass, rtol=0, atol=SECOND_METHOD)
    np.testing.assert_allclose(mass.inertia, peer.inertia, rtol=0, atol=SECOND_METHOD * mass.inertia.max())


def test_reversed_facets_enclose_a_negative_volume():
    vertices, triangles = cube()
    assert mass_properties(vertices, triangles[:, ::-1]).volume == pytest.approx(-1.0, rel=ROUNDING)


def test_centring_far_away_loses_nothing():
    vertices, triangles = cube(offset=(1e6, -1e6, 1e6))
    about = centred(vertices, mass_properties(vertices, triangles).centre)
    np.testing.assert_array_equal(about, cube(offset=3 * (-0.5,))[0])


def test_centre_of_area_of_an_open_box():
    vertices, triangles = cube()
    # without its top: four sides about z = 1/2 and the bottom at 0
    np.testing.assert_allclose(surface_centre(vertices, triangles[np.r_[:2, 4:12]]), [0.5, 0.5, 2 / 5], rtol=ROUNDING)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: box((1, 0, 1)), "box size must be 3 finite lengths greater than 0 m; got"),
        (lambda: prism(1, -1, 1), "prism base, height, thickness must be"),
        (lambda: prism(1, np.nan, 1), "prism base, height, thickness must be"),
        (lambda: TriangleMesh(np.zeros((3, 2)), np.zeros((1, 3), dtype=int)), r"shape \(n, 3\)"),
        (lambda: TriangleMesh(np.zeros((3, 3)), np.zeros((1, 3))), "integers"),
        (lambda: TriangleMesh(np.zeros((3, 3)), np.zeros((0, 3), dtype=int)), "at least one triangle"),
        (lambda: TriangleMesh(np.full((3, 3), np.inf), np.array([[0, 1, 2]])), "finite; vertex 0 is"),
        (lambda: TriangleMesh(np.zeros((3, 3)), np.array([[0, 1, 3]])), "vertices 0 to 2; got 3"),
    ],
)
def test_what_is_no_mesh_is_refused(make, words):
    with pytest.raises(MeshError, match=words):
        make()


def test_size_is_the_diameter_about_the_origin():
    assert box((2, 3, 6)).size == pytest.approx(7.0, rel=ROUNDING)
    assert box((1, 1, 1)).vertices.flags.writeable  # one array type for compiled kernels
