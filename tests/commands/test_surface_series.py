"""The VTKHDF series, read back by VTK's own reader."""

from types import SimpleNamespace

import numpy as np
import pytest

from comotion.outputs.surface import Surface
from comotion.outputs.surface_series import ImpactSeries, SurfaceSeries

TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype=np.uint32)

POSES = np.array([[1.0, 2, 3, 1, 0, 0, 0], [0.0, 0, 0, 1, 0, 0, 0], [0.0, 0, 0, 1, 0, 0, 0]])
TWISTS = np.array([[0.5, 0, 0, 0, 0, 2.0], [0.0] * 6, [0.0] * 6])


def region(name, *bodies):
    members = [SimpleNamespace(name=body, first_vertex=4 * i, vertex_count=4) for i, body in enumerate(bodies)]
    return SimpleNamespace(name=name, vertex_count=4 * len(bodies), bodies=members)


@pytest.fixture
def surface():
    vertices = {"a": TETRAHEDRON, "b": np.concatenate([TETRAHEDRON + 2, TETRAHEDRON + 4])}
    triangles = {"a": FACES, "b": np.concatenate([FACES, FACES + 4]).astype(np.uint32)}
    return Surface([region("a", "hull"), region("b", "floe0", "floe1")], vertices, triangles)


def test_surface_joins_regions_and_knows_each_triangles_body(surface):
    assert [body.name for body in surface.bodies] == ["floe0", "floe1", "hull"]
    assert surface.body_of_triangle.tolist() == [2] * 4 + [0] * 4 + [1] * 4
    np.testing.assert_array_equal(surface.points_of(surface.bodies[1]), TETRAHEDRON + 4)
    np.testing.assert_array_equal(surface.triangles_of(1), FACES)


def test_a_region_that_was_not_sent_stays_where_it_was(surface):
    surface.update({"a": TETRAHEDRON - 1})
    np.testing.assert_array_equal(surface.points[:4], TETRAHEDRON - 1)
    np.testing.assert_array_equal(surface.points[4:8], TETRAHEDRON + 2)


def test_vtk_reads_every_step_bit_for_bit(surface, tmp_path):
    reader_module = pytest.importorskip("vtkmodules.vtkIOHDF", reason="vtk is in the extra `view`")
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    path = tmp_path / "bodies.vtkhdf"
    states = [(0.0, surface.points), (0.25, surface.points + 0.1), (0.5, surface.points / 3)]
    with SurfaceSeries(path, surface, {}, None) as series:
        for time, points in states:
            series.append(time, points, POSES, TWISTS, np.ones(3))
    reader = reader_module.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(states)
    for step, (time, points) in enumerate(states):
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetClassName() == "vtkPolyData"
        assert reader.GetTimeValue() == time
        read = numpy_support.vtk_to_numpy(data.GetPoints().GetData())
        np.testing.assert_array_equal(read, points)
        cells = numpy_support.vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        np.testing.assert_array_equal(cells, surface.triangles)
        assert data.GetNumberOfCells() == len(surface.triangles)
        body = numpy_support.vtk_to_numpy(data.GetCellData().GetArray("body"))
        np.testing.assert_array_equal(body, surface.body_of_triangle)
        velocity = numpy_support.vtk_to_numpy(data.GetPointData().GetArray("velocity"))
        first = surface.bodies[0].first  # it alone turns, about z through its centre at (1, 2, 3), and goes along x
        own = points[first : first + 4]
        by_hand = np.stack([0.5 - 2.0 * (own[:, 1] - 2.0), 2.0 * (own[:, 0] - 1.0)], axis=1)
        np.testing.assert_allclose(velocity[first : first + 4, :2], by_hand, rtol=1e-6, atol=1e-6)  # float32
        assert not np.delete(velocity, np.s_[first : first + 4], axis=0).any()


def test_vtk_reads_the_impacts_of_every_state(tmp_path):
    reader_module = pytest.importorskip("vtkmodules.vtkIOHDF", reason="vtk is in the extra `view`")
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")

    def impact(x, a, b):
        return SimpleNamespace(
            time=x,
            body_a=a,
            body_b=b,
            point=(x, 0.0, 1.0),
            normal=(0.0, 0.0, 1.0),
            impulse=2.0 * x,
            approach_speed=0.5,
            friction=None if x < 2 else (1.0, 0.0, 0.0),
        )

    states = [[], [impact(1.0, "floe", "hull"), impact(2.0, "floe", "plane")], [], [impact(3.0, "floe", "hull")]]
    series = ImpactSeries(tmp_path / "impacts.vtkhdf", ["floe", "hull"])
    for number, impacts in enumerate(states):
        series.append(0.1 * number, impacts)
    series.close()
    reader = reader_module.vtkHDFReader()
    reader.SetFileName(str(tmp_path / "impacts.vtkhdf"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(states)
    for number, impacts in enumerate(states):
        reader.SetStep(number)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfPoints() == data.GetNumberOfVerts() == len(impacts)
        if not impacts:
            continue
        points = numpy_support.vtk_to_numpy(data.GetPoints().GetData())
        np.testing.assert_array_equal(points, [hit.point for hit in impacts])
        arrays = {
            name: numpy_support.vtk_to_numpy(data.GetPointData().GetArray(name)) for name in ("impulse", "body_b")
        }
        np.testing.assert_array_equal(arrays["impulse"][:, 2], [hit.impulse for hit in impacts])
        np.testing.assert_array_equal(arrays["impulse"][:, 0], [1.0 if hit.friction else 0.0 for hit in impacts])
        np.testing.assert_array_equal(arrays["body_b"], [{"hull": 1}.get(hit.body_b, -1) for hit in impacts])


def append_and_be_interrupted(path, surface):
    with SurfaceSeries(path, surface, {}, None) as series:
        series.append(0.0, surface.points, POSES, TWISTS, np.ones(3))
        raise KeyboardInterrupt


def test_a_series_that_was_cut_short_is_readable(surface, tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "bodies.vtkhdf"
    with pytest.raises(KeyboardInterrupt):
        append_and_be_interrupted(path, surface)
    with h5py.File(path) as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 1
        np.testing.assert_array_equal(file["VTKHDF/Points"], surface.points)
