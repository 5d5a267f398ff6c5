"""The picture of the last state: what is in it, and what draws it."""

import numpy as np
import pytest
from cubes_by_hand import MOTION, scene_of

from comotion.outputs import picture
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
