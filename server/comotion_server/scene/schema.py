"""The JSON schema of scene files, for editors that complete and check TOML (taplo and its plug-ins).

`python -m comotion_server.scene.schema > docs/scene.schema.json` writes it anew.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from comotion_server.scene.rules import PLACES, SHAPES
from comotion_server.scene.tables import SceneFile


def scene_schema() -> dict[str, Any]:
    """The schema, made from the models that scenes are checked with."""
    schema: dict[str, Any] = _without_null(SceneFile.model_json_schema())
    schema["$schema"] = "http://json-schema.org/draft-07/schema#"
    tables = schema["$defs"]
    tables["ShapeTable"]["oneOf"] = [{"required": [key]} for key in SHAPES]
    tables["PlaceTable"]["oneOf"] = [{"required": [key]} for key in PLACES]
    return schema


def schema_text() -> str:
    """The schema as the committed file has it."""
    return json.dumps(scene_schema(), indent=2) + "\n"


def _without_null(node: Any) -> Any:
    """TOML has no null: a key that may be left out is not a key that may be null."""
    if isinstance(node, list):
        return [_without_null(entry) for entry in node]
    if not isinstance(node, dict):
        return node
    node = {key: _without_null(value) for key, value in node.items() if value is not None}
    if node.get("unit", "1") != "1" and "description" in node:
        node["description"] += f" [{node['unit']}]"
    choices = [choice for choice in node.get("anyOf", []) if choice != {"type": "null"}]
    if len(choices) == 1:
        del node["anyOf"]
        node = choices[0] | node
    return node


if __name__ == "__main__":
    sys.stdout.write(schema_text())
