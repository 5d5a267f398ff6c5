"""The hull: the committed file is what the generator makes, closed, and floats where it should."""

import math
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest

from comotion_mock_cfd import hull_form
from comotion_mock_cfd.box_form import SIZE, box_mesh
from comotion_mock_cfd.hydrostatics import hydrostatic_forces
from comotion_mock_cfd.scenes import FOLDER

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path):
    """Vertices [m] and triangles of a binary STL file, equal corners joined."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    assert len(data) == 84 + 50 * count
    facets = np.frombuffer(data, FACET, offset=84)
    vertices, index = np.unique(facets["corners"].reshape(-1, 3), axis=0, return_inverse=True)
    return vertices.astype(float), index.reshape(-1, 3), facets["normal"]


@pytest.mark.parametrize("name", ["hull", "hull_frame", "bank", "box"])
def test_the_committed_file_is_what_the_generator_writes(name, tmp_path):
    out = tmp_path / "out.stl"
    subprocess.run([sys.executable, "-m", f"comotion_mock_cfd.{name}_form", str(out)], check=True, timeout=60)
    assert out.read_bytes() == (FOLDER / f"{name}.stl").read_bytes()


@pytest.mark.parametrize("name", ["hull", "hull_frame", "bank", "box"])
def test_the_surface_is_closed_and_faces_outwards(name):
    vertices, triangles, normals = read_stl(FOLDER / f"{name}.stl")
    edges = Counter(map(tuple, triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).tolist()))
    assert set(edges.values()) == {1}  # no direction of an edge twice: manifold and consistently oriented
    assert all((b, a) in edges for a, b in edges)  # every edge has its neighbour: watertight
    assert len(vertices) - len(edges) // 2 + len(triangles) == 2  # Euler: one piece, no handles
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = np.cross(b - a, c - a) / 2
    assert np.linalg.norm(area, axis=1).min() > 1e-6
    assert np.einsum("ki,ki->", a, area) / 3 > 0.0
    unit = area / np.linalg.norm(area, axis=1, keepdims=True)
    # Normals were made before the corners were rounded to float32: 6e-8 of 1 m over facets of 25 mm.
    assert np.abs(normals - unit).max() < 1e-5


def test_the_hull_floats_at_its_design_draught():
    vertices, triangles, _ = read_stl(FOLDER / "hull.stl")
    assert 600 <= len(triangles) <= 1500
    force = hydrostatic_forces(vertices, triangles, 1000.0, 1.0, 0.0).sum(axis=0)
    assert force[2] == pytest.approx(125.0, rel=0.005)  # what the scene promises
    assert force[2] == pytest.approx(125.0, rel=1e-4)  # what was reached
    assert force[:2] == pytest.approx(0.0, abs=1e-9)


def test_the_form_volume_is_the_integral_of_the_offsets():
    z = np.linspace(-hull_form.DRAUGHT, 0.0, 20001)
    length = hull_form.LENGTH + z / math.tan(hull_form.STEM_ANGLE)
    area = 2 / 3 * hull_form.BEAM * (1 - (z / hull_form.DRAUGHT) ** 2) * length  # of a parabola between two ends
    step = z[1] - z[0]
    volume = step * (area.sum() - 0.5 * (area[0] + area[-1]))
    assert hull_form.form_volume() == pytest.approx(volume, rel=1e-8)  # trapezoids: (1/20000)^2


def test_main_dimensions_and_the_ice_bow():
    vertices, _ = hull_form.hull_mesh()
    at_waterline = vertices[vertices[:, 2] == 0.0]
    assert np.ptp(at_waterline[:, 0]) == hull_form.LENGTH
    assert np.ptp(at_waterline[:, 1]) == hull_form.BEAM
    assert vertices[:, 2].min() == -hull_form.DRAUGHT
    assert vertices[:, 2].max() == hull_form.FREEBOARD
    # The foremost point of every waterline lies on a stem that rises at 30 degrees.
    stem = np.array([vertices[vertices[:, 2] == z, 0].max() for z in np.unique(vertices[:, 2])])
    slope = np.diff(np.unique(vertices[:, 2])) / np.diff(stem)
    assert slope == pytest.approx(math.tan(math.radians(30.0)), rel=1e-12)
    # Port and starboard are mirror images.
    mirrored = np.unique(vertices * (1.0, -1.0, 1.0) + 0.0, axis=0)
    assert np.array_equal(mirrored, np.unique(vertices, axis=0))


def test_the_block_coefficient_is_what_the_page_says():
    block = hull_form.LENGTH * hull_form.BEAM * hull_form.DRAUGHT
    assert hull_form.form_volume() / block == pytest.approx(0.41, abs=0.005)


def test_the_box_has_its_size_and_stands_about_the_origin():
    vertices, triangles = box_mesh(SIZE)
    assert np.array_equal(vertices.max(axis=0), np.array(SIZE) / 2)
    assert np.array_equal(vertices.min(axis=0), -np.array(SIZE) / 2)
    assert triangles.shape == (12, 3)
