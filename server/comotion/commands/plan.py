"""`comotion plan`: which stages a step of a scene runs, which it leaves out, and why."""

import argparse
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from comotion.commands.arguments import add_command, add_json, add_scene, scene_path

if TYPE_CHECKING:
    from comotion_server.plan import PlanLine

NAME = "plan"
EXAMPLES = """\
  comotion plan float_box
  comotion plan float_box drop channel
  comotion plan my_scene.toml --json
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "show what a step runs, what it leaves out, and why"
    description = "Show which stages a step of each scene runs, which it leaves out, and the reason for either."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    add_scene(parser, many=True)
    add_json(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Print one table per scene."""
    paths = [scene_path(name) for name in options.scene]
    from comotion_server.plan import Plan
    from comotion_server.scene import load_scene

    plans = [(scene.name, Plan(scene).explain()) for scene in map(load_scene, paths)]
    if options.json:
        print(json.dumps([{"scene": name, "stages": list(map(_as_data, lines))} for name, lines in plans], indent=2))
    else:
        print("\n\n".join(_table(name, lines) for name, lines in plans))
    return 0


def _as_data(line: "PlanLine") -> dict[str, str | bool]:
    return {"stage": line.stage, "kept": line.kept, "reason": line.reason}


def _table(name: str, lines: Sequence["PlanLine"]) -> str:
    width = max(len(line.stage) for line in lines)
    rows = [f"  {'runs' if line.kept else 'left out':<8}  {line.stage:<{width}}  {line.reason}" for line in lines]
    return "\n".join([name, *rows])
