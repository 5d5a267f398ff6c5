"""A whole run: what it writes, against what theory and its other files say."""

import csv
import json
import math

import h5py
import numpy as np
import pytest
import trimesh
from processes import run_command

STEP = 0.005  # [s] of the shipped scenes
HEAVE_ERROR = 0.005  # relative: drag and dt change the period of float_box by less
ROUNDING = 1e-9  # relative or [m]: far above float64 rounding of these sums, far below any step of the motion


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def column(rows, *names):
    return np.array([[float(row[name]) for name in names] for row in rows])


@pytest.fixture(scope="module")
def float_box(tmp_path_factory):
    folder = tmp_path_factory.mktemp("float_box")
    options = ("--json", "--frames", "3", "--stl", "0:300:150")
    done = run_command("run", "float_box", "--duration", "1.5", "--out", folder, *options)
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


@pytest.fixture(scope="module")
def drop(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drop")
    done = run_command("run", "drop", "--out", folder, "--sample", "end", "--resistance-of", "floor", "--frames", "0")
    assert done.returncode == 0, done.stderr
    return folder, done.stdout


def test_the_summary_is_printed_and_written(float_box):
    folder, summary = float_box
    assert json.loads((folder / "summary.json").read_text()) == summary
    assert summary["status"] == "ok"
    assert summary["steps"] == 300
    assert summary["simulated_s"] == pytest.approx(1.5, rel=ROUNDING)
    assert summary["impacts"] == summary["overlaps"] == 0
    assert 0.0 < summary["protocol_share"] < 1.0
    assert summary["wall_per_simulated_second"] == pytest.approx(summary["wall_s"] / 1.5, rel=ROUNDING)


def test_the_heave_period_is_that_of_theory(float_box):
    heave = float_box[1]["heave"]
    assert heave["theory_s"] == pytest.approx(2 * math.pi * math.sqrt(0.1 / 9.81), rel=ROUNDING)
    assert heave["cycles"] >= 1
    assert heave["period_s"] == pytest.approx(heave["theory_s"], rel=HEAVE_ERROR)


def test_poses_and_wrenches_obey_newton(float_box):
    """Velocity changes by (weight + fluid force) dt / m between samples, which lie dt apart."""
    folder, _ = float_box
    poses, wrenches = table(folder / "poses.csv"), table(folder / "wrenches.csv")
    assert len(poses) == 301
    assert len(wrenches) == 300
    np.testing.assert_allclose(np.diff(column(poses, "time [s]"), axis=0), STEP, rtol=1e-6)
    # Midpoint samples carry the velocity at the step's end: drift alone predicts the half step.
    gained = np.diff(column(poses, "vz [m/s]"), axis=0)
    force = column(wrenches, "fz [N]")
    np.testing.assert_allclose(gained, (force / 16.0 - 9.81) * STEP, atol=ROUNDING)


def test_series_poses_and_mesh_agree(float_box):
    folder, _ = float_box
    poses = column(table(folder / "poses.csv"), "time [s]", "x [m]", "y [m]", "z [m]")
    with h5py.File(folder / "bodies.vtkhdf") as file:
        times = file["VTKHDF/Steps/Values"][:]
        points = file["VTKHDF/Points"][:].reshape(len(times), -1, 3)
    assert np.all(np.diff(times) >= 0.02 - ROUNDING)
    centres = poses[np.searchsorted(poses[:, 0], times - ROUNDING), 1:]
    np.testing.assert_allclose(points.mean(axis=1), centres, atol=1e-8)  # the STL file's corners are float32


def test_pictures_are_drawn_as_far_as_there_is_something_to_draw(float_box, drop):
    assert (float_box[0] / "final.png").read_bytes().startswith(b"\x89PNG")
    assert not (float_box[0] / "resistance.png").exists()
    assert (drop[0] / "final.png").read_bytes().startswith(b"\x89PNG")
    assert (drop[0] / "resistance.png").read_bytes().startswith(b"\x89PNG")


def test_frames_plots_and_report_are_written(float_box, drop):
    names = {path.name for path in float_box[0].iterdir()}
    assert {"animation.gif", "books.png", "step_time.png", "bodies.glb", "impacts.vtkhdf", "steps.csv"} <= names
    assert len(list((float_box[0] / "frames").glob("*.png"))) == 3
    assert not (drop[0] / "frames").exists()
    for folder in (float_box[0], drop[0]):
        assert "wall time" in (folder / "report.html").read_text()
    steps = table(float_box[0] / "steps.csv")
    assert len(steps) == 300
    assert np.all(column(steps, "wait [s]") > 0.0)


def test_stl_files_are_the_surfaces_of_their_steps(float_box):
    """Corners of the box lie around its centre at the sample time of the step, to the rounding of float32."""
    folder, _ = float_box
    files = sorted((folder / "stl").iterdir())
    assert [path.name.rpartition("_step")[2] for path in files] == ["0000000.stl", "0000150.stl", "0000300.stl"]
    centres = column(table(folder / "poses.csv"), "x [m]", "y [m]", "z [m]")
    for path, step in zip(files, (0, 150, 300), strict=True):
        mesh = trimesh.load_mesh(path)
        assert mesh.is_watertight
        np.testing.assert_allclose(mesh.center_mass, centres[step], atol=1e-6)


def test_stl_without_a_folder_is_refused():
    done = run_command("run", "drop", "--stl")
    assert done.returncode == 2
    assert done.stderr == "comotion: --stl: say where to write the files by --out DIR\n"


def test_impacts_come_when_a_fall_of_half_a_metre_ends(drop):
    folder, out = drop
    impacts = table(folder / "impacts.csv")
    first = math.sqrt(2 * 0.5 / 9.81)
    expected = [first, 2 * first, 2.5 * first, 2.75 * first]  # each hop lasts half as long as the one before: e = 0.5
    found = column(impacts, "time [s]")[:, 0]
    for time in expected:
        assert np.min(np.abs(found - time)) < STEP
    assert {row["body_a"] for row in impacts} | {row["body_b"] for row in impacts} == {"box", "floor"}
    assert f"impacts         {len(impacts)}" in out


def test_contacts_sum_the_impulses_of_impacts(drop):
    folder, _ = drop
    impacts, contacts = table(folder / "impacts.csv"), table(folder / "contacts.csv")
    along_normals = column(impacts, "impulse [N s]") * column(impacts, "nx", "ny", "nz")
    total = column(contacts, "jx [N s]", "jy [N s]", "jz [N s]").sum(axis=0)
    np.testing.assert_allclose(total, along_normals.sum(axis=0), atol=1e-9)
    times = {(row["time [s]"], row["body_a"], row["body_b"]) for row in impacts}  # a patch gives a row for each point
    assert column(contacts, "count").sum() == len(times)


def test_an_output_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    done = run_command("run", "drop", "--out", tmp_path / "file" / "out")
    assert done.returncode == 2
    assert done.stderr == f"comotion: {tmp_path / 'file' / 'out'}: Not a directory\n"


def test_an_unknown_body_is_named(tmp_path):
    done = run_command("run", "drop", "--out", tmp_path, "--resistance-of", "flor")
    assert done.returncode == 2
    assert done.stderr == "comotion: --resistance-of: there is no body 'flor'; did you mean 'floor'?\n"
