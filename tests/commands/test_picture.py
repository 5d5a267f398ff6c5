"""The picture of the last state: what is in it, and what draws it."""

import numpy as np
import pytest
from cubes_by_hand import CORNERS, MOTION, scene_of

from comotion.outputs import picture
from comotion.outputs.frames import Frames
from comotion.outputs.picture import SIZE, Still, draw

matplotlib_image = pytest.importorskip("matplotlib.image", reason="matplotlib is in the extra `view`")


def brightness(path):
    """Grey values of the picture, shape (height, width)."""
    pixels = matplotlib_image.imread(path)[:, :, :3]
    assert pixels.shape[:2] == SIZE[::-1]
    return pixels.mean(axis=2)


@pytest.mark.parametrize("missing", [[], ["libegl1"]], ids=["shaded", "plain"])
def test_a_light_floe_and_a_dark_hull_are_seen(tmp_path, monkeypatch, missing):
    if not missing and picture.missing_graphics():
        pytest.skip(f"pyvista needs {picture.missing_graphics()}")
    monkeypatch.setattr(picture, "missing_graphics", lambda: missing)
    still = Still(scene_of(floe=[1.0, 0, 0.2], hull=[-1.0, 0, 0.2], bank=[0, 3.0, 0]), MOTION, 0.0)
    drawn_by = draw(tmp_path / "final.png", still)
    assert drawn_by == ("matplotlib" if missing else "pyvista")
    grey = brightness(tmp_path / "final.png")
    dark, light = grey < 0.3, (grey > 0.75) & (grey < 0.98)
    share = 0.01  # of the picture: each cube covers several times as much
    assert np.mean(dark) > share
    assert np.mean(light) > share
    assert np.nonzero(dark)[1].mean() < 0.4 * SIZE[0]  # the hull is on the left
    assert np.nonzero(light)[1].mean() > 0.55 * SIZE[0]  # and the floe on the right


def test_the_view_takes_in_what_moves():
    low, high = Still(scene_of(floe=[1.0, 0, 0], bank=[0, 30.0, 0]), MOTION, None).box
    assert np.all(low < [0.5, -0.5, -0.5])
    assert np.all(high > [1.5, 0.5, 0.5])
    assert high[1] < 1.0


def test_the_view_takes_in_what_is_still_if_it_is_small_and_near_or_around():
    near = scene_of(floe=[2.0, 0, 0], hull=[-2.0, 0, 0], bank=[0, 2.0, 0])
    assert Still(near, MOTION, None).view[:, 1].max() == 2.5
    far = scene_of(floe=[2.0, 0, 0], hull=[-2.0, 0, 0], bank=[0, 30.0, 0])
    assert Still(far, MOTION, None).view[:, 1].max() == 0.5
    around = scene_of(floe=[0, 0, 0], bank=[0, 0, 0])
    around.points_of(around.bodies[0])[:] *= 4.0
    assert Still(around, MOTION, None).view[:, 1].max() == 2.0


@pytest.mark.parametrize(
    ("centres", "water", "height"),
    [
        ({"floe": [0, 0, 0]}, 0.1, 0.1),  # on the water
        ({"floe": [0, 0, 1.0], "bank": [0, 0, 0]}, None, 0.5),  # on the floor's top
        ({"floe": [0, 0, 0.999], "bank": [0, 0, 0]}, None, 0.5),  # also when the body overlaps it a little
        ({"floe": [0, 0, 3.0], "bank": [0, 3, 6.0]}, None, 2.5),  # no floor below: at the bottom of all
    ],
)
def test_shadows_fall_on_water_floor_or_bottom(centres, water, height):
    assert Still(scene_of(**centres), MOTION, water).shadow_height == pytest.approx(height)


FRAMED = """
scene = { name = "framed", duration = 1.0, dt = 0.1 }
body = [
  { name = "floe", shape = { box = { size = [1.0, 2.0, 1.0] } }, mass = 1.0, frame = { scale = 1.5 } },
  { name = "bare", shape = { box = { size = [1.0, 1.0, 1.0] } }, mass = 1.0, position = [9.0, 0.0, 0.0] },
]
"""


def test_frames_move_and_shrink_with_their_bodies(tmp_path):
    (tmp_path / "framed.toml").write_text(FRAMED)
    frames = Frames.of_scene(tmp_path / "framed.toml", ["bare", "floe"])
    half = np.sqrt(0.5)
    poses = np.array([[9.0, 0, 0, 1, 0, 0, 0], [1.0, 2.0, 3.0, half, 0, 0, half]])
    frames.place(poses, np.array([1.0, 0.5]))
    corners = 0.5 * 1.5 * CORNERS * [2.0, 1.0, 1.0] + [1.0, 2.0, 3.0]  # a quarter turn about z
    found, expected = (sorted(np.round(points, 12).tolist()) for points in (frames.points, corners))
    assert found == expected
    assert frames.triangles.shape == (12, 3)


@pytest.mark.parametrize("missing", [[], ["libegl1"]], ids=["shaded", "plain"])
def test_a_frame_is_seen_and_what_is_in_it(tmp_path, monkeypatch, missing):
    if not missing and picture.missing_graphics():
        pytest.skip(f"pyvista needs {picture.missing_graphics()}")
    monkeypatch.setattr(picture, "missing_graphics", lambda: missing)
    (tmp_path / "framed.toml").write_text(FRAMED)
    surface = scene_of(floe=[0.0, 0, 0], hull=[5.0, 0, 0])
    frames = Frames.of_scene(tmp_path / "framed.toml", ["bare", "floe"])
    draw(tmp_path / "bare.png", Still(surface, MOTION, None))
    draw(tmp_path / "framed.png", Still(surface, MOTION, None, frames=frames))
    bare, framed = (matplotlib_image.imread(tmp_path / f"{name}.png")[:, :, :3] for name in ("bare", "framed"))
    changed = np.abs(framed - bare).max(axis=2) > 0.02
    assert 0.01 < changed.mean() < 0.5
    columns = np.nonzero(changed)[1]
    assert columns.max() < 0.6 * SIZE[0]  # around the floe on the left alone
    assert np.mean(framed[changed][:, 0] - framed[changed][:, 2]) > np.mean(bare[changed][:, 0] - bare[changed][:, 2])
