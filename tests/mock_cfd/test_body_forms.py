"""The meshes of the smaller bodies: files are what the generator writes, closed, with volumes by formula."""

import math
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest

from comotion_mock_cfd import body_forms
from comotion_mock_cfd.body_forms import FORMS
from comotion_mock_cfd.scenes import FOLDER

HANDLES = {"ring": 1}
FACETS = {"ball": 320, "cube": 12, "floe": 20, "jack": 60, "ring": 576}
FLOE_AREA = 1.5 * math.sqrt(3.0) * body_forms.FLOE_SIDE**2
VOLUMES = {
    "cube": body_forms.CUBE**3,
    "floe": FLOE_AREA * body_forms.FLOE_THICKNESS,
    "jack": 7 * body_forms.JACK_CELL**3,
    # polygons for circles: the sectors around the axis sheared to prisms, and the section of the tube
    "ring": 24
    * math.sin(math.pi / 12)
    * body_forms.RING_RADIUS
    * 6
    * math.sin(math.pi / 6)
    * body_forms.TUBE_RADIUS**2,
}


def volume_and_area(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return np.einsum("ij,ij->", a, normals) / 6.0, np.linalg.norm(normals, axis=1).sum() / 2.0


def test_the_committed_files_are_what_the_generator_writes(tmp_path):
    subprocess.run([sys.executable, "-m", "comotion_mock_cfd.body_forms", str(tmp_path)], check=True, timeout=60)
    for name in FORMS:
        assert (tmp_path / f"{name}.stl").read_bytes() == (FOLDER / f"{name}.stl").read_bytes()


@pytest.mark.parametrize("name", FORMS)
def test_closed_outward_and_of_its_genus(name):
    vertices, triangles = FORMS[name][0]()
    assert len(triangles) == FACETS[name]
    edges = Counter(map(tuple, triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert len(vertices) - len(edges) // 2 + len(triangles) == 2 - 2 * HANDLES.get(name, 0)
    assert volume_and_area(vertices, triangles)[0] > 0.0


@pytest.mark.parametrize("name", VOLUMES)
def test_volumes(name):
    assert volume_and_area(*FORMS[name][0]())[0] == pytest.approx(VOLUMES[name], rel=1e-13)


def test_the_ball_lies_on_its_sphere_with_corners_at_both_poles():
    vertices, triangles = body_forms.ball_mesh()
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), body_forms.BALL_RADIUS, rtol=1e-15)
    assert [*vertices[0], *vertices[11]] == [0, 0, -body_forms.BALL_RADIUS, 0, 0, body_forms.BALL_RADIUS]
    volume, area = volume_and_area(vertices, triangles)
    radius = 3 * volume / area  # of the sphere that touches all facets, on average
    assert 0.97 * body_forms.BALL_RADIUS < radius < body_forms.BALL_RADIUS


def test_cubes_of_a_polycube_share_no_inner_face():
    vertices, triangles = body_forms.polycube_mesh([(0, 0, 0), (1, 0, 0)], 2.0)
    assert volume_and_area(vertices, triangles) == (16.0, 40.0)
    assert len(vertices) == 12
