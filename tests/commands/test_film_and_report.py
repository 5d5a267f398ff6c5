"""Frames of a run, where impacts are marked, and the report."""

from types import SimpleNamespace

import numpy as np
import pytest
from cubes_by_hand import MOTION, scene_of

from comotion.outputs.camera import Camera
from comotion.outputs.film import Film, write_gif
from comotion.outputs.picture import SIZE, Still
from comotion.outputs.report import Report

image = pytest.importorskip("PIL.Image", reason="pillow is in the extra `view`")

AT_REST = np.zeros((0, 7)), np.zeros(0)  # poses and scales, which matter to frames alone


def impact(time, point, impulse=1.0, body="floe"):
    numbers = {"time": time, "point": point, "impulse": impulse, "approach_speed": 1.0, "restitution": 0.5}
    return SimpleNamespace(**numbers, body_a=body, body_b="hull", law="together")


def test_states_are_kept_at_their_interval_even_if_steps_are_longer():
    film = Film(0.25)
    for time in np.arange(0.0, 1.001, 0.01):
        film.add(time, np.zeros((1, 3)), *AT_REST)
    np.testing.assert_allclose(film.times, [0.0, 0.25, 0.5, 0.75, 1.0])
    coarse = Film(0.1)
    for time in (0.0, 0.35, 0.7):
        coarse.add(time, np.zeros((1, 3)), *AT_REST)
    assert coarse.times == [0.0, 0.35, 0.7]


def test_frames_show_the_states_and_mark_the_impact(tmp_path):
    surface = scene_of(floe=[1.0, 0, 0.2], hull=[-1.0, 0, 0.2])
    film = Film(0.1)
    film.add(0.0, surface.points, *AT_REST)
    film.add_impacts([impact(0.09, (1.0, 0.0, 0.7))])
    film.add(0.1, surface.points, *AT_REST)
    still = Still(surface, MOTION, 0.0)
    shown = []
    before = surface.points.copy()
    frames = film.draw(tmp_path / "frames", still, "a <scene>", lambda *counts: shown.append(counts))
    np.testing.assert_array_equal(surface.points, before)
    assert shown == [(1, 2), (2, 2)]
    first, second = (np.asarray(image.open(path).convert("RGB")).astype(int) for path in frames)
    assert first.shape == (*SIZE[::-1], 3)
    red = (second[..., 0] > second[..., 2] + 60) & (first[..., 0] <= first[..., 2] + 60)
    rows, columns = np.nonzero(red)
    x, y = Camera.on(still.view).pixel(np.array([1.0, 0.0, 0.7]))
    assert np.hypot(columns.mean() - x, rows.mean() - y) < 5.0  # pixels; the ring is 18 large
    write_gif(tmp_path / "a.gif", frames, 0.1)
    with image.open(tmp_path / "a.gif") as gif:
        assert (gif.n_frames, gif.info["duration"]) == (2, 100)


def test_the_camera_sees_all_points_and_fills_the_picture():
    low, high = np.array([-3.0, -1.0, 0.0]), np.array([5.0, 2.0, 0.3])
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), -1).reshape(-1, 3)
    camera = Camera.on(corners)
    places = np.array([camera.pixel(corner) for corner in corners]) / SIZE
    np.testing.assert_allclose(places.min(axis=0) + places.max(axis=0), 1.0, atol=0.01)  # in the middle
    assert np.ptp(places, axis=0).max() == pytest.approx(0.92, abs=0.01)


def test_the_report_needs_nothing_else_and_takes_no_name_as_html(tmp_path):
    bad = "<script>alert(1)</script>"
    opened = SimpleNamespace(plan=[SimpleNamespace(stage="s", kept=False, reason=bad)], regions=[])
    image.new("RGB", (4, 4)).save(tmp_path / "final.png")
    Report(
        title=bad,
        opened=opened,
        lines=[f"scene  {bad}"],
        warnings=[bad],
        motion={"a": "free"},
        largest=[impact(0.1, (0, 0, 0), body=bad)],
        version="1",
        folder=tmp_path,
        strip=[tmp_path / "final.png"],
        files=[bad],
    ).write(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "<script" not in page
    assert page.count("&lt;script&gt;alert(1)") >= 6
    assert "data:image/png;base64," in page
    assert "data:image/jpeg;base64," in page
    assert "http" not in page
