"""`check` and `plan` on shipped scenes and on broken ones."""

import json

import pytest
from processes import run_command

SHIPPED = ("channel", "drop", "float_box")

BROKEN = """\
[scene]
name = "broken"
duration = 1.0
dt = 0.01

[[body]]
name = "box"
shape = { box = { size = [1.0, 1.0, 1.0] } }
mas = 2.0

[fluid]
densty = 1000.0
drag = { form = -1.0 }
"""

OVERLAPPING = """\
[scene]
name = "overlapping"
duration = 1.0
dt = 0.01

[[body]]
name = "left"
shape = { box = { size = [1.0, 1.0, 1.0] } }
mass = 2.0

[[body]]
name = "right"
shape = { box = { size = [1.0, 1.0, 1.0] } }
mass = 2.0
position = [0.5, 0.1, 0.2]
"""


@pytest.fixture
def scene_file(tmp_path):
    def write(text):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenes_are_sound(name):
    done = run_command("check", name, "--json")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["ok"]
    assert report["problems"] == []
    assert report["scene"]["name"] == name
    assert all(body["health"]["closed"] for body in report["scene"]["bodies"])


def test_check_shows_bodies_and_meshes():
    done = run_command("check", "float_box")
    assert done.returncode == 0
    assert "box   free    16" in done.stdout
    assert "extent        0.4 x 0.4 x 0.2 m" in done.stdout


def test_check_names_all_mistakes_of_scene_and_fluid_with_their_lines(scene_file):
    path = scene_file(BROKEN)
    done = run_command("check", path)
    assert done.returncode == 1
    assert f"{path}:9: body \"box\".mas: unknown key 'mas'; did you mean 'mass'?" in done.stdout
    assert f"{path}:12: fluid.densty: unknown key 'densty'; did you mean 'density'?" in done.stdout
    assert f"{path}:13: fluid.drag.form: must be at least 0; got -1.0" in done.stdout
    problems = json.loads(run_command("check", path, "--json").stdout)["problems"]
    assert [problem["line"] for problem in problems] == [9, 12, 13]


def test_check_finds_bodies_that_overlap_at_the_start(scene_file):
    done = run_command("check", scene_file(OVERLAPPING))
    assert done.returncode == 1
    assert "left" in done.stdout
    assert "right" in done.stdout


def test_plan_prints_a_table_per_scene():
    done = run_command("plan", *SHIPPED)
    assert done.returncode == 0
    tables = done.stdout.split("\n\n")
    assert [table.splitlines()[0] for table in tables] == list(SHIPPED)
    assert "left out  collisions         a lone body has nothing to collide with" in tables[2]


def test_plan_as_json_gives_a_reason_for_every_stage():
    plans = json.loads(run_command("plan", *SHIPPED, "--json").stdout)
    assert [plan["scene"] for plan in plans] == list(SHIPPED)
    stages = [[stage["stage"] for stage in plan["stages"]] for plan in plans]
    assert stages[0] == stages[1] == stages[2]
    assert all(stage["reason"] for plan in plans for stage in plan["stages"])


@pytest.mark.parametrize("command", ["plan", "run", "serve"])
def test_a_broken_scene_is_refused_in_words(command, scene_file):
    path = scene_file(BROKEN)
    done = run_command(command, path)
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == f"{path}:9: body \"box\".mas: unknown key 'mas'; did you mean 'mass'?"
    assert all(line.startswith(f"{path}:") for line in done.stderr.splitlines())


@pytest.mark.parametrize("command", ["run", "mock"])
def test_a_broken_fluid_is_refused_in_words(command, scene_file):
    path = scene_file(BROKEN.replace("mas =", "mass ="))
    done = run_command(command, path, *(["--run", "x"] if command == "mock" else []))
    assert done.returncode == 2
    assert f"{path}:12: fluid.densty: unknown key 'densty'; did you mean 'density'?" in done.stderr
    assert "Traceback" not in done.stderr
