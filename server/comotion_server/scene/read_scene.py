"""A scene file: TOML, checked key by key, then its meshes and tables, with every mistake reported at once."""

from __future__ import annotations

import re
import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from comotion_server.scene.bodies import BodyMaker, MadeBody
from comotion_server.scene.bores import too_large_for_pipes
from comotion_server.scene.curved_shapes import Capsule, Curved, Cylinder, Pipe
from comotion_server.scene.model import Collisions, Plane, Scene
from comotion_server.scene.problems import Problems, path_of, sentence, shown
from comotion_server.scene.rules import PAPER_RULES, body_rules, collisions_rules, exact_only_rules
from comotion_server.scene.scene_errors import Problem, SceneError
from comotion_server.scene.scene_report import SceneReport, report_of
from comotion_server.scene.tables import ArrayTable, BodyKeys, BodyTable, SceneFile
from comotion_server.scene.toml_lines import Path as Keys
from comotion_server.scene.toml_lines import lines_of


def load_scene(path: str | Path) -> Scene:
    """The scene in a file.

    Raises:
        SceneError: every mistake in it, and in the files that it names.
    """
    return _read(Path(path))[0]


def check_scene(path: str | Path) -> SceneReport:
    """What is in a scene: its bodies with masses and the health of their meshes, and its regions.

    Raises:
        SceneError: every mistake in it, and in the files that it names.
    """
    return report_of(*_read(Path(path)))


def _read(path: Path) -> tuple[Scene, list[MadeBody]]:
    text = _text(path)
    raw = _parsed(path, text)
    problems = Problems(str(path), raw, lines_of(text))
    file = _validated(raw, problems)
    made = _made(raw, path.parent, problems)
    _check_names(raw, made, problems)
    _check_materials(raw, problems)
    _check_collisions(raw, problems)
    if file is not None and not (file.body or file.array):
        problems.add((), "a scene needs at least one [[body]] or [[array]]")
    elif made and all(isinstance(item.body.shape, Plane) for item in made):
        problems.add((), "a scene needs at least one body that is no plane")
    _check_shapes(made, problems)
    if problems.found or file is None:
        raise SceneError(problems.found)
    return _scene(file, path, made), made


def _made(raw: dict[str, Any], folder: Path, problems: Problems) -> list[MadeBody]:
    """All bodies that can be made: those with mistakes are left out, so that the others' files are looked at, too."""
    maker = BodyMaker(folder, problems)
    for index, table in _tables(raw, "body"):
        if _rules_hold(table, ("body", index), BodyTable, problems):
            maker.add_body(BodyTable.model_validate(table), ("body", index))
    for index, table in _tables(raw, "array"):
        if _rules_hold(table, ("array", index), ArrayTable, problems):
            maker.add_array(ArrayTable.model_validate(table), ("array", index))
    return maker.made


def _rules_hold(table: dict[str, Any], keys: Keys, model: type[BodyKeys], problems: Problems) -> bool:
    for below, message in body_rules(table, list(model.model_fields)):
        problems.add((*keys, *below), message)
    return keys not in problems.blamed


def _text(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise SceneError([Problem(str(path), None, "", f"cannot be read: {error.strerror}")]) from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise SceneError([Problem(str(path), line, "", "not text in UTF-8")]) from None


def _parsed(path: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r" \(at (?:line (\d+), column \d+|end of document)\)$", str(error))
        line = int(place[1]) if place and place[1] else text.count("\n") + 1
        message = str(error)[: place.start()] if place else str(error)
        raise SceneError([Problem(str(path), line, "", f"not TOML: {message[:1].lower()}{message[1:]}")]) from None
    except RecursionError:
        raise SceneError([Problem(str(path), None, "", "not a scene: nested too deeply")]) from None


def _validated(raw: dict[str, Any], problems: Problems) -> SceneFile | None:
    try:
        return SceneFile.model_validate(raw)
    except ValidationError as error:
        for found in error.errors(include_url=False):
            problems.add(path_of(found), sentence(found, SceneFile))
        return None


def _tables(raw: dict[str, Any], kind: str) -> list[tuple[int, dict[str, Any]]]:
    """The tables of an array of tables, with their numbers, as far as they are tables at all."""
    entries = raw.get(kind)
    return (
        [(k, entry) for k, entry in enumerate(entries) if isinstance(entry, dict)] if isinstance(entries, list) else []
    )


def _check_names(raw: dict[str, Any], made: list[MadeBody], problems: Problems) -> None:
    owners: dict[str, Keys] = {}
    for index, table in _tables(raw, "body"):
        _claim(str(table.get("name")), ("body", index), owners, problems)
    clashed: set[Keys] = set()
    for name, keys in ((item.body.name, item.keys) for item in made if item.keys[0] == "array"):
        if keys not in clashed and not _claim(name, keys, owners, problems):
            clashed.add(keys)


def _claim(name: str, keys: Keys, owners: dict[str, Keys], problems: Problems) -> bool:
    owner = owners.setdefault(name, keys)
    if owner == keys or name == "None":
        return True
    problems.add((*keys, "name"), f"'{name}' is already the name of the {owner[0]} on line {problems.lines[owner]}")
    return False


def _check_materials(raw: dict[str, Any], problems: Problems) -> None:
    given = [table.get("material") for kind in ("body", "array") for _, table in _tables(raw, kind)]
    names = sorted({name for name in given if isinstance(name, str)})
    pairs: set[frozenset[str]] = set()
    for index, table in _tables(raw, "material"):
        between = table.get("between")
        if not isinstance(between, list) or not all(isinstance(name, str) for name in between):
            continue
        for place, name in enumerate(between):
            if name not in names:
                close = get_close_matches(name, names, n=1)
                guess = f"; did you mean '{close[0]}'?" if close else ""
                message = f"no body is of material '{name}'{guess or '; there are: ' + (', '.join(names) or 'none')}"
                problems.add(("material", index, "between", place), message)
        if frozenset(between) in pairs:
            problems.add(("material", index, "between"), f"there is an earlier [[material]] between {shown(between)}")
        pairs.add(frozenset(between))
        if not {"restitution", "friction"} & set(table):
            problems.add(("material", index), "needs 'restitution' or 'friction'")


def _check_shapes(made: list[MadeBody], problems: Problems) -> None:
    """What shapes of a scene do not go together in this version."""
    pipes = [item for item in made if isinstance(item.body.shape, Pipe)]
    meshes = [item for item in made if not isinstance(item.body.shape, Curved | Plane)]
    capsules = [item for item in made if isinstance(item.body.shape, Capsule)]
    cylinders = [item for item in made if isinstance(item.body.shape, Cylinder)]
    for kind, others in (("mesh", meshes), ("capsule", capsules), ("cylinder", cylinders)):
        if pipes and others:
            problems.add(
                (*pipes[0].keys, "shape"), f'not in one scene with a {kind}, as body "{others[0].body.name}" has'
            )
    for keys, message in too_large_for_pipes(made):
        problems.add(keys, message)


def _check_collisions(raw: dict[str, Any], problems: Problems) -> None:
    collisions = raw.get("collisions", {})
    if not isinstance(collisions, dict):
        return
    for below, message in collisions_rules(collisions):
        problems.add(("collisions", *below), message)
    if collisions.get("merge") is True or collisions.get("heal", "off") != "off":
        for kind in ("body", "array"):
            for index, table in _tables(raw, kind):
                for name in ("sphere", "capsule", "cylinder"):
                    if isinstance(shape := table.get("shape"), dict) and name in shape:
                        problems.add((kind, index, "shape", name), "'merge' and 'heal' are for meshes alone")
    if (rule := collisions.get("rule")) in PAPER_RULES:
        for kind in ("body", "array", "material"):
            for index, table in _tables(raw, kind):
                for below, message in exact_only_rules(kind, table, rule):
                    problems.add((kind, index, *below), message)


def _scene(file: SceneFile, path: Path, made: list[MadeBody]) -> Scene:
    pairs = [(frozenset(material.between), material) for material in file.material]
    return Scene(
        name=file.scene.name or _name_from(path),
        gravity=np.array(file.scene.gravity),
        duration=file.scene.duration,
        dt=file.scene.dt,
        collisions=Collisions(
            **file.collisions.model_dump(),
            material_pairs={pair: of.restitution for pair, of in pairs if of.restitution is not None},
            material_frictions={pair: of.friction for pair, of in pairs if of.friction is not None},
        ),
        bodies=tuple(item.body for item in made),
    )


def _name_from(path: Path) -> str:
    """The file's name as a name: other characters become dashes."""
    return re.sub(r"[^A-Za-z0-9_.+-]", "-", path.stem).lstrip(".+-") or "scene"
