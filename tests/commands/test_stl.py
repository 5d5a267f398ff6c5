"""STL files: read back by a second program, float32 by float32."""

import numpy as np
import pytest
import trimesh

from comotion.outputs.stl import StepChoice, StlFiles, write_stl

FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], dtype=np.uint32)


def test_every_coordinate_is_the_nearest_float32(tmp_path):
    points = np.array([[0.1, 0, 0], [1e3 + 1 / 3, 0, 0], [0, 1 / 7, 0], [0, 0, -1e-9]])
    write_stl(tmp_path / "a.stl", points, FACES, "a name with an ü")
    mesh = trimesh.load_mesh(tmp_path / "a.stl", process=False)
    np.testing.assert_array_equal(mesh.triangles, points.astype(np.float32)[FACES].astype(np.float64))
    assert (tmp_path / "a.stl").stat().st_size == 84 + 50 * len(FACES)
    assert not (tmp_path / "a.stl").read_bytes().startswith(b"solid")  # which would make it a text file


def test_normals_are_unit_and_outward(tmp_path):
    points = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]])
    write_stl(tmp_path / "a.stl", points, FACES, "")
    body = (tmp_path / "a.stl").read_bytes()[84:]
    normals = np.frombuffer(body, np.dtype([("n", "<f4", 3), ("rest", "V38")]))["n"]
    third = 3**-0.5
    np.testing.assert_allclose(normals, [[0, 0, -1], [0, -1, 0], [third] * 3, [-1, 0, 0]], atol=1e-7)


@pytest.mark.parametrize(
    ("text", "steps"),
    [("3", [3]), ("3,9", [3, 9]), ("2:4", [2, 3, 4]), ("0:8:4", [0, 4, 8]), ("all", list(range(10))), ("last", [])],
)
def test_steps_chosen(text, steps):
    choice = StepChoice.of(text)
    assert [step for step in range(10) if step in choice] == steps
    assert choice.last == (text == "last")


@pytest.mark.parametrize("text", ["", "x", "-1", "1:2:3:4", "1.5"])
def test_what_is_no_choice_of_steps(text):
    with pytest.raises(ValueError, match="expected steps such as"):
        StepChoice.of(text)


def test_regions_never_share_or_leave_the_folder(tmp_path):
    points = np.zeros((4, 3))
    names = ("../ice", "ICE", "ice", ".._ice")
    files = StlFiles(tmp_path / "stl", dict.fromkeys(names, FACES))
    files.write(7, 0.5, dict.fromkeys(names, points))
    assert len(list((tmp_path / "stl").iterdir())) == len(names)
    assert [path.name for path in tmp_path.iterdir()] == ["stl"]


def test_a_region_that_never_moves_is_written_once(tmp_path):
    files = StlFiles(tmp_path / "stl", {"bank": FACES, "ice": FACES}, still=["bank"])
    for step in (5, 10):
        files.write(step, 0.1 * step, {"bank": np.zeros((4, 3)), "ice": np.zeros((4, 3))})
    names = ["bank_step0000005.stl", "ice_step0000005.stl", "ice_step0000010.stl"]
    assert sorted(path.name for path in (tmp_path / "stl").iterdir()) == names
