"""What repair does to broken surfaces: the solid stays what it was, and the account of it is right."""

from itertools import pairwise

import numpy as np
import pytest
from mesh_forms import cube, torus

from comotion_server.meshes import MeshError, mass_properties
from comotion_server.meshes.repair import repair

ROUNDING = 1e-12


def loose(vertices, triangles):
    """Every facet with three corners of its own, as STL files have them."""
    corners = np.asarray(vertices, dtype=float)[np.asarray(triangles)].reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def repaired_cube(triangles, vertices=None):
    return repair(*loose(cube()[0] if vertices is None else vertices, triangles))


def volume_of(mesh):
    return mass_properties(mesh.vertices, mesh.triangles).volume


def test_a_sound_cube_is_welded_and_left_as_it_is():
    mesh, health = repaired_cube(cube()[1])
    assert (health.corners_read, health.facets_read, health.vertices, health.triangles) == (36, 12, 8, 12)
    assert (health.shells, health.closed, health.problems, health.repairs) == (1, True, (), ())
    assert health.volume == pytest.approx(1.0, rel=ROUNDING)
    assert health.area == pytest.approx(6.0, rel=ROUNDING)
    assert health.extent == (1.0, 1.0, 1.0)
    assert health.smallest_edge == 1.0
    assert health.worst_aspect == pytest.approx(2.0, rel=ROUNDING)  # the diagonal over its height, sqrt 2 / sqrt(1/2)
    np.testing.assert_array_equal(mesh.vertices[mesh.triangles], cube()[0][cube()[1]])  # order of facets and corners
    np.testing.assert_array_equal(mesh.vertices[:3], cube()[0][cube()[1][0]])  # numbered by first appearance


def test_minus_zero_is_zero():
    vertices, triangles = cube()
    corners, facets = loose(vertices, triangles)
    corners[::2] *= np.where(corners[::2] == 0.0, -1.0, 1.0)
    assert repair(corners, facets).health.vertices == 8


def test_mixed_orientation_is_made_one(rng):
    vertices, triangles = torus(16)
    turned = rng.random(len(triangles)) < 0.3
    mesh, health = repair(*loose(vertices, np.where(turned[:, None], triangles[:, ::-1], triangles)))
    assert health.turned_facets == turned.sum()
    assert health.closed
    assert volume_of(mesh) == pytest.approx(mass_properties(vertices, triangles).volume, rel=ROUNDING)


def test_the_smaller_part_is_turned_and_then_the_whole_outward(rng):
    vertices, triangles = torus(16)
    turned = rng.random(len(triangles)) < 0.7
    mesh, health = repair(*loose(vertices, np.where(turned[:, None], triangles[:, ::-1], triangles)))
    assert health.turned_facets == (~turned).sum()
    assert health.turned_shells == 1
    assert volume_of(mesh) > 0


def test_an_inverted_cube_is_turned_and_said_so():
    mesh, health = repaired_cube(cube()[1][:, ::-1])
    assert health.repairs == ("1 shell turned inside out: the volume was negative",)
    assert volume_of(mesh) == pytest.approx(1.0, rel=ROUNDING)


@pytest.mark.parametrize("turned", [False, True])
def test_a_cavity_stays_a_cavity(turned):
    outer, triangles = cube(edge=3.0)
    inner, _ = cube(offset=(1.0, 1.0, 1.0))
    facets = np.concatenate((triangles, triangles[:, ::-1] + 8))
    mesh, health = repair(np.concatenate((outer, inner)), facets[:, ::-1] if turned else facets)
    assert health.shells == 2
    assert health.turned_shells == (2 if turned else 0)
    assert volume_of(mesh) == pytest.approx(26.0, rel=ROUNDING)


def test_one_inverted_part_beside_another_is_turned():
    apart, triangles = cube(offset=(5.0, 0.0, 0.0))
    mesh, health = repair(np.concatenate((cube()[0], apart)), np.concatenate((triangles, triangles[:, ::-1] + 8)))
    assert health.turned_shells == 1
    assert volume_of(mesh) == pytest.approx(2.0, rel=ROUNDING)


def test_an_open_cube_names_its_first_open_edge():
    _, health = repaired_cube(cube()[1][1:])
    assert not health.closed
    assert health.open_edges == 3
    assert np.isnan(health.volume)
    ends = {tuple(end) for end in health.first_bad_edge}
    missing = {tuple(vertex) for vertex in cube()[0][cube()[1][0]]}
    assert ends < missing
    assert health.problems[0].startswith("3 open edges (the first from (")


def test_a_third_facet_on_an_edge_is_not_a_manifold():
    vertices, triangles = cube()
    fin = np.array([[0, 1, 8]])
    _, health = repaired_cube(np.concatenate((triangles, fin)), np.concatenate((vertices, [[0.5, -1.0, 0.0]])))
    assert (health.non_manifold_edges, health.open_edges) == (1, 2)
    assert "1 edge with more than two facets" in health.problems


def test_a_moebius_strip_is_one_sided_and_a_klein_bottle_too():
    """A torus whose last row is joined on with a half twist is closed and has no outside."""
    count = 8
    i, j = (x.ravel() for x in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))

    def number(i, j):
        return np.where(i < count, i * count + j % count, (-j) % count)

    a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
    facets = np.concatenate((np.stack((a, b, c), axis=1), np.stack((a, c, d), axis=1)))
    _, health = repair(np.random.default_rng(1).normal(size=(count * count, 3)), facets)
    assert health.unorientable
    assert (health.open_edges, health.non_manifold_edges) == (0, 0)
    assert health.problems[0].startswith("a one-sided surface (the first from (")


def test_doubled_and_collapsed_facets_are_taken_out_and_counted():
    triangles = cube()[1]
    mesh, health = repaired_cube(
        np.concatenate((triangles, triangles[:2], triangles[3:4, ::-1], [[0, 0, 1], [5, 5, 5]]))
    )
    assert (health.doubled, health.zero_area, health.triangles) == (3, 2, 12)
    assert health.closed
    assert volume_of(mesh) == pytest.approx(1.0, rel=ROUNDING)


def test_cracks_of_single_precision_are_closed(rng):
    corners, facets = loose(*torus(16))
    corners = corners.astype(np.float32)
    split = rng.random(corners.shape) < 0.05
    corners[split] = np.nextafter(corners[split], np.float32(10.0))
    mesh, health = repair(corners.astype(float), facets)
    assert health.closed
    assert (health.vertices, health.triangles) == (256, 512)
    assert health.cracks > 0
    single = 1e-6  # two roundings to single precision
    assert volume_of(mesh) == pytest.approx(mass_properties(*torus(16)).volume, rel=single)


def test_a_real_slit_is_not_closed():
    corners, facets = loose(*cube())
    corners[:3, 2] -= 1e-5
    assert repair(corners, facets).health.open_edges > 0


def split_edge(parts):
    """A cube whose edge 0-1 has extra points on one side only, bridged by flat facets, as CAD programs write them."""
    vertices, triangles = cube()
    inner = [(k / parts, 0.0, 0.0) for k in range(1, parts)]
    chain = [0, *range(8, 8 + len(inner)), 1]
    whole = next(k for k, t in enumerate(triangles.tolist()) if {0, 1} < set(t))
    apex = next(c for c in triangles[whole] if c not in (0, 1))
    corners = triangles[whole].tolist()
    along = (corners.index(1) - corners.index(0)) % 3 == 1
    pieces = [(a, b, apex) if along else (b, a, apex) for a, b in pairwise(chain)]
    flat = [(chain[0], b, a) if along else (chain[0], a, b) for a, b in pairwise(chain[1:])]
    return np.array([*vertices, *inner]), np.array([*np.delete(triangles, whole, axis=0), *pieces, *flat])


@pytest.mark.parametrize("parts", [2, 4, 8])
def test_flat_facets_go_and_the_surface_stays_closed(parts):
    vertices, triangles = split_edge(parts)
    assert mass_properties(vertices, triangles).volume == pytest.approx(1.0, rel=ROUNDING)
    mesh, health = repair(*loose(vertices, triangles))
    assert health.zero_area == parts - 1
    assert health.closed, health.problems
    assert volume_of(mesh) == pytest.approx(1.0, rel=ROUNDING)
    np.testing.assert_allclose(
        mass_properties(mesh.vertices, mesh.triangles).inertia, np.eye(3) / 6, rtol=0, atol=ROUNDING
    )


@pytest.mark.parametrize("ratio", [1e-3, 1e-6])
def test_needles_are_kept(ratio):
    vertices, triangles = cube()
    vertices = vertices * [1.0, ratio, ratio]
    mesh, health = repair(*loose(vertices, triangles))
    assert (health.triangles, health.zero_area, health.closed) == (12, 0, True)
    assert volume_of(mesh) == pytest.approx(ratio**2, rel=ROUNDING)
    assert health.worst_aspect >= 1 / ratio


@pytest.mark.parametrize("offset", [1e6, 1e7])
def test_far_from_the_origin_nothing_is_lost(offset):
    vertices, triangles = cube(offset=3 * (offset,))
    mesh, health = repair(*loose(vertices, triangles))
    assert (health.vertices, health.triangles, health.repairs) == (8, 12, ())
    assert volume_of(mesh) == pytest.approx(1.0, rel=ROUNDING)


def test_unused_vertices_are_left_out():
    vertices, triangles = cube()
    mesh, _ = repair(np.concatenate(([[9.0, 9.0, 9.0]], vertices)), triangles + 1)
    np.testing.assert_array_equal(mesh.vertices, vertices)


def test_a_flat_pillow_has_no_volume():
    vertices, triangles = cube()
    _, health = repair(vertices * [1.0, 1.0, 0.0], triangles)
    assert not health.closed


@pytest.mark.parametrize(
    ("points", "facets", "words"),
    [
        (np.zeros((3, 3)), [[0, 1, 2]], "none of the 1 facets has an area"),
        (np.outer([0, 1, 3], [1, 1, 1]), [[0, 1, 2]], "none of the 1 facets has an area"),
        (
            [[0, 0, 0], [1, 0, 0], [0, np.nan, 0]],
            [[0, 1, 2]],
            r"1 of 3 vertices are not finite.*number 3, is \(0.0, nan, 0",
        ),
        ([[0, 0, 0], [1, 0, 0], [0, 1e300, 0]], [[0, 1, 2]], "beyond 1e\\+12 m"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "no facet in the file"),
    ],
)
def test_what_is_no_surface_is_refused(points, facets, words):
    with pytest.raises(MeshError, match=words):
        repair(np.asarray(points, dtype=float), np.asarray(facets, dtype=np.int64))


def test_the_account_as_data_and_as_text():
    _, health = repaired_cube(cube()[1][1:])
    data = health.as_dict()
    assert data["volume"] is None
    assert data["open_edges"] == 3
    assert data["problems"] == list(health.problems)
    assert "problem       3 open edges" in health.table()
