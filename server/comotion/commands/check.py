"""`comotion check`: is the scene sound, and what is in it?"""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from comotion.commands.arguments import add_command, add_json, add_scene, scene_path
from comotion.commands.errors import BAD_OUTCOME

if TYPE_CHECKING:
    from comotion_server.meshes.mesh_health import MeshHealth
    from comotion_server.scene import Problem
    from comotion_server.scene.scene_report import BodyReport, SceneReport

T = TypeVar("T")

NAME = "check"
EXAMPLES = """\
  comotion check channel
  comotion check my_scene.toml
  comotion check my_scene.toml --json

exit codes: 0 sound; 1 there are problems, one a line; 2 wrong use or no such scene
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "check a scene, its meshes and its fluid"
    description = "Check a scene file, the meshes it names, its [fluid], and that no bodies overlap at the start."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    add_scene(parser)
    add_json(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Print the report, or the problems."""
    path = scene_path(options.scene)
    report, problems = _examine(path)
    if options.json:
        data = {"ok": not problems, "problems": [problem.as_dict() for problem in problems]}
        print(json.dumps(data | {"scene": None if report is None else report.as_dict()}, indent=2))
    else:
        text = [] if report is None else [_text(report)]
        print("\n".join([*text, *map(str, problems)]))
    return BAD_OUTCOME if problems else 0


def _examine(path: Path) -> tuple["SceneReport | None", list["Problem"]]:
    from comotion.fluid_scene import load_fluid_scene
    from comotion_server.scene import check_scene
    from comotion_server.simulation import Simulation

    report, problems = _problems_of(check_scene, path)
    problems += [problem for problem in _problems_of(load_fluid_scene, path)[1] if problem.where.startswith("fluid")]
    if report is not None:
        problems += _problems_of(Simulation.load, path)[1]
    return report, problems


def _problems_of(read: Callable[[Path], T], path: Path) -> tuple[T | None, list["Problem"]]:
    from comotion_server.scene import SceneError

    try:
        return read(path), []
    except SceneError as error:
        return None, list(error.problems)


def _text(report: "SceneReport") -> str:
    regions = [
        f"  {region.name}: {_bodies_of(region.bodies)}, {region.vertices} vertices, {region.triangles} triangles"
        for region in report.regions
    ]
    shapes: dict[str, list[BodyReport]] = {}
    frames: dict[tuple[str, str], list[BodyReport]] = {}
    for body in report.bodies:
        shapes.setdefault(body.shape, []).append(body)
        if body.frame is not None:
            frames.setdefault((body.shape, body.frame), []).append(body)
    meshes = [line for shape, bodies in shapes.items() for line in _mesh(shape, bodies, bodies[0].health)]
    parts = ["regions", *regions, "bodies", *_bodies(report), "meshes", *meshes]
    if frames:
        parts += ["frames", *map(_frame, frames.values())]
    return "\n".join([f"scene {report.name}", *parts])


def _frame(bodies: list["BodyReport"]) -> str:
    size = f"{bodies[0].frame_triangles} triangles, least clearance {bodies[0].clearance:.6g} m"
    return f"  {bodies[0].frame} ({_whose(bodies)}): {size}"


def _whose(bodies: list["BodyReport"]) -> str:
    return _bodies_of(len(bodies)) if len(bodies) > 1 else bodies[0].name


def _bodies_of(count: int) -> str:
    return "1 body" if count == 1 else f"{count} bodies"


def _bodies(report: "SceneReport") -> list[str]:
    rows = [("name", "motion", "mass [kg]", "size [m]", "centre of mass [m]", "shape")]
    for body in report.bodies:
        mass = "-" if body.mass is None else f"{body.mass:.6g}"
        place = ", ".join(f"{x:.6g}" for x in body.position)
        rows.append((body.name, body.motion, mass, "-" if body.size is None else f"{body.size:.4g}", place, body.shape))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _mesh(shape: str, bodies: list["BodyReport"], health: "MeshHealth | None") -> list[str]:
    if health is None:
        return []
    notes = [f"    note: {note}" for note in bodies[0].notes]
    return [f"  {shape} ({_whose(bodies)})", *(f"    {line}" for line in health.table().splitlines()), *notes]
