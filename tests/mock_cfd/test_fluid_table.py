"""The [fluid] table: defaults, and every refusal names its key."""

import pytest
from pydantic import ValidationError

from comotion_mock_cfd.fluid import Drag, Fluid, FluidError, Heave, load_fluid

SCENE = '[scene]\nname = "s"\nduration = 2.0\ndt = 0.01\n'


def load(tmp_path, text):
    path = tmp_path / "pool.toml"
    path.write_text(text, encoding="utf-8")
    return load_fluid(path)


def test_without_a_fluid_table_there_is_vacuum(tmp_path):
    scene = load(tmp_path, SCENE + "gravity = [1.0, 0.0, 3.0]\n")
    assert scene.fluid is None
    assert (scene.dt, scene.duration, scene.name) == (0.01, 2.0, "s")


def test_an_empty_fluid_table_is_fresh_water_at_rest(tmp_path):
    scene = load(tmp_path, SCENE + "[fluid]\n")
    assert scene.fluid == Fluid(density=1000.0, level=0.0, current=(0.0, 0.0, 0.0), drag=Drag(), added_mass={})
    assert scene.gravity == 9.81


def test_all_keys(tmp_path):
    text = "[scene]\nduration = 2\ndt = 1\ngravity = [0, 0, -1.62]\n"
    text += "[fluid]\ndensity = 1025\nlevel = -0.5\ncurrent = [1, 0, 0.5]\n"
    text += (
        'drag = { form = 1.1, friction = 0.003 }\nadded_mass = { ice = 0.2 }\nheave = { body = "b", draught = 0.1 }\n'
    )
    scene = load(tmp_path, text)
    assert scene.fluid == Fluid(
        density=1025.0,
        level=-0.5,
        current=(1.0, 0.0, 0.5),
        drag=Drag(form=1.1, friction=0.003),
        added_mass={"ice": 0.2},
        heave=Heave(body="b", draught=0.1),
    )
    assert scene.gravity == 1.62
    assert scene.name == "pool"  # the file's name, as for the server


@pytest.mark.parametrize(
    ("fluid", "key"),
    [
        ("densty = 1000.0", "densty"),
        ("density = 0.0", "density"),
        ("density = nan", "density"),
        ('density = "1000"', "density"),
        ("density = true", "density"),
        ("level = inf", "level"),
        ("current = [1.0, 0.0]", "current"),
        ('current = [1.0, 0.0, "0"]', "current"),
        ("drag = 1.0", "drag"),
        ("drag = { form = -1.0 }", "form"),
        ("drag = { lift = 1.0 }", "lift"),
        ("added_mass = { ice = -0.1 }", "ice"),
        ('heave = { body = "box" }', "draught"),
    ],
)
def test_a_wrong_key_or_value_is_refused_and_named(tmp_path, fluid, key):
    with pytest.raises(ValidationError) as caught:
        load(tmp_path, SCENE + "[fluid]\n" + fluid + "\n")
    errors = caught.value.errors()
    assert len(errors) == 1
    assert errors[0]["loc"][0] == "fluid"
    assert key in errors[0]["loc"]


@pytest.mark.parametrize("gravity", ["[0.0, 0.0, 9.81]", "[0.1, 0.0, -9.81]", "[0.0, -9.81, 0.0]"])
def test_water_needs_gravity_downwards(tmp_path, gravity):
    with pytest.raises(FluidError, match=r"scene\.gravity: .* along -z, or zero; got \["):
        load(tmp_path, SCENE + f"gravity = {gravity}\n[fluid]\n")


def test_water_without_gravity_has_no_pressure(tmp_path):
    assert load(tmp_path, SCENE + "gravity = [0, 0, 0]\n[fluid]\n").gravity == 0.0


def test_dt_and_duration_are_needed(tmp_path):
    with pytest.raises(ValidationError) as caught:
        load(tmp_path, "[scene]\n")
    assert [error["loc"] for error in caught.value.errors()] == [("scene", "duration"), ("scene", "dt")]
