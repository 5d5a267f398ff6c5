"""The schema for editors and the page for people say what the models check."""

import json
import re
from pathlib import Path

import pytest

from comotion_server.scene import tables
from comotion_server.scene.schema import schema_text

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "scenes.md").read_text(encoding="utf-8")
# Where each model's keys are listed: the heading of a section, or the first column of a table in it.
LISTED = {
    "## `[scene]`": tables.SceneTable,
    "## `[collisions]`": tables.CollisionsTable,
    "## `[[material]]`": tables.MaterialTable,
    "## `[[body]]`": tables.BodyTable,
    "## Shape": tables.ShapeTable,
    "| `box` |": tables.BoxTable,
    "| `prism` |": tables.PrismTable,
    "| `plane` |": tables.PlaneTable,
    "| `sphere` |": tables.SphereTable,
    "| `capsule` |": tables.CapsuleTable,
    "| `cylinder` |": tables.CylinderTable,
    "| `pipe` |": tables.PipeTable,
    "| `frame` |": tables.FrameTable,
    "## Motion": tables.MotionTable,
    "| `place` |": tables.PlaceTable,
    "| `grid` |": tables.GridTable,
    "| `random` |": tables.RandomTable,
}


def rows_below(heading):
    """Key -> (unit, default) of the first table at or below a line that begins so."""
    start = re.search(rf"^{re.escape(heading)}(?= type|\n)", PAGE, re.MULTILINE).start()
    lines = PAGE[start:].split("\n")
    ruler = next(k for k, line in enumerate(lines) if line.startswith("|---"))
    rows = {}
    for line in lines[ruler + 1 :]:
        if not line.startswith("|"):
            return rows
        key, _, unit, default, _ = (cell.strip() for cell in line.strip("|").split("|"))
        rows[key.strip("`")] = (unit, default.strip("`"))
    return rows


def expected(field):
    unit = (field.json_schema_extra or {}).get("unit", "")
    if field.is_required():
        return unit, "required"
    default = field.get_default(call_default_factory=True)
    return unit, "-" if default is None else json.dumps(default)


@pytest.mark.parametrize(("heading", "model"), LISTED.items(), ids=lambda value: getattr(value, "__name__", None))
def test_the_page_lists_every_key_with_its_unit_and_default(heading, model):
    assert rows_below(heading) == {key: expected(field) for key, field in model.model_fields.items()}


def test_an_array_has_the_keys_of_a_body_but_its_position():
    assert rows_below("## `[[array]]`") == {"place": ("", "required")}
    assert set(tables.ArrayTable.model_fields) ^ set(tables.BodyTable.model_fields) == {"place", "position"}


def test_the_committed_schema_is_up_to_date():
    """Otherwise: python -m comotion_server.scene.schema > docs/scene.schema.json."""
    assert (DOCS / "scene.schema.json").read_text(encoding="utf-8") == schema_text()


def test_the_example_of_the_page_is_a_scene(tmp_path):
    from mesh_forms import cube, write_stl

    from comotion_server.scene import load_scene

    text = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1]
    (tmp_path / "scene.toml").write_text(text)
    write_stl(tmp_path / "hull.stl", *cube())
    assert len(load_scene(tmp_path / "scene.toml").bodies) == 25


def test_no_key_may_be_null():
    assert "null" not in schema_text()
