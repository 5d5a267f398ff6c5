"""The picture of the last state: what is in it, and what draws it."""

from types import SimpleNamespace

import numpy as np
import pytest

from comotion.outputs import picture
from comotion.outputs.picture import SIZE, Still, draw
from comotion.outputs.surface import Surface

matplotlib_image = pytest.importorskip("matplotlib.image", reason="matplotlib is in the extra `view`")

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # outward
FACES = np.array([triangle for a, b, c, d in QUADS for triangle in ((a, b, c), (a, c, d))], dtype=np.uint32)
MOTION = {"floe": "free", "hull": "prescribed", "bank": "fixed"}


def scene_of(**centres):
    """Unit cubes, one region each."""
    regions, vertices, triangles = [], {}, {}
    for name, centre in centres.items():
        body = SimpleNamespace(name=name, first_vertex=0, vertex_count=8)
        regions.append(SimpleNamespace(name=name, vertex_count=8, bodies=(body,)))
        vertices[name], triangles[name] = CORNERS + centre, FACES
    return Surface(regions, vertices, triangles)


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
    left, right = grey[:, : SIZE[0] // 2], grey[:, SIZE[0] // 2 :]
    share = 0.01  # of the half picture: each cube covers several times as much
    assert np.mean(left < 0.3) > share > np.mean(right < 0.3)  # the hull is on the left, and nothing dark on the right
    assert np.mean((right > 0.75) & (right < 0.98)) > share


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
