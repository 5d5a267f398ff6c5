"""Collecting mistakes: from a place in the parsed scene to a line, a key and a sentence."""

from __future__ import annotations

import json
import re
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel

from comotion_server.scene.scene_errors import Problem, SceneError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic_core import ErrorDetails

    from comotion_server.scene.toml_lines import Path

LONGEST_VALUE = 60
"""Characters of a given value that a message repeats."""

COMPARISONS = {
    "greater_than": "greater than",
    "greater_than_equal": "at least",
    "less_than": "less than",
    "less_than_equal": "at most",
}
KINDS = {"float": "a number", "int": "a whole number", "bool": "true or false", "string": "text in quotes"}


class Problems:
    """All mistakes found so far in one scene file."""

    def __init__(self, file: str, raw: Mapping[str, Any], lines: Mapping[Path, int]) -> None:
        self.file = file
        self.raw = raw
        self.lines = lines
        self.found: list[Problem] = []
        self.blamed: set[Path] = set()  # tables with mistakes, for instance ("body", 0)

    def add(self, path: Path, message: str) -> None:
        """A mistake at a place of the scene file, for instance ("body", 0, "mass")."""
        self.blamed.add(path[:2])
        self.found.append(Problem(self.file, self._line(path), self._where(path), message))

    def add_from_file(self, error: SceneError, path: Path, name: str) -> None:
        """The mistakes in a file that the scene names: those on a line of their own stay there."""
        for problem in error.problems:
            if problem.line is None:
                self.add(path, f"{name}: {problem.message}")
            else:
                self.found.append(problem)

    def _line(self, path: Path) -> int | None:
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path)

    def _where(self, path: Path) -> str:
        if len(path) > 1 and isinstance(path[1], int):
            table = self.raw[str(path[0])][path[1]]
            name = table.get("name") if isinstance(table, dict) else None
            head, rest = f'{path[0]} "{name}"' if isinstance(name, str) else f"{path[0]} {path[1] + 1}", path[2:]
        else:
            head, rest = "".join(map(str, path[:1])), path[1:]
        return head + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in rest)


def path_of(error: ErrorDetails) -> Path:
    """Where in the document an error lies: pydantic's location without the tags of unions."""
    return tuple(key for key in error["loc"] if not str(key).startswith("<"))


def sentence(error: ErrorDetails, model: type[BaseModel]) -> str:
    """What is wrong, what is allowed and what was given, in our words.

    Args:
        error: one of pydantic's errors.
        model: the model that was validated.
    """
    path, context = path_of(error), error.get("ctx", {})
    unit = _unit(model, path)
    got = f"; got {shown(error['input'])}"
    match error["type"]:
        case "extra_forbidden":
            return unknown_key(str(path[-1]), list(_model_at(model, path[:-1]).model_fields))
        case "missing":
            return f"needed, but missing{_meaning(model, path)}"
        case "literal_error":
            return f"must be {context['expected']}{got}{_guess(error['input'], context['expected'])}"
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal" as kind:
            (limit,) = context.values()
            return f"must be {COMPARISONS[kind]} {limit:g}{unit}{got}"
        case "too_short" | "too_long":
            entries = context.get("min_length", context.get("max_length"))
            return f"must have {entries} entries{got}"
        case "finite_number":
            return f"must be a finite number{got}"
        case "string_pattern_mismatch":
            return f"must be made of letters, digits and _ . + -, and not begin with . + -{got}"
        case "value_error":
            return f"{context['error']}{got}"
        case "list_type" if len(path) == 1:
            return f"must be written as [[{path[0]}]], once for each"
        case "model_type" | "dict_type" | "model_attributes_type":
            return f"must be a table{got}"
        case kind if kind.endswith("_type"):
            expected = KINDS.get(kind.removesuffix("_type"), "a list of numbers")
            return f"must be {expected}{f' [{unit.strip()}]' * bool(unit)}{got}"
        case _:
            return f"{error['msg'][:1].lower()}{error['msg'][1:]}{got}"


def unknown_key(key: str, allowed: Sequence[str]) -> str:
    """What to say of a key that does not exist."""
    close = get_close_matches(key, allowed, n=1)
    return f"unknown key '{key}'" + (f"; did you mean '{close[0]}'?" if close else f"; allowed: {', '.join(allowed)}")


def shown(value: Any) -> str:
    """A value as the scene file writes it, cut to a readable length."""
    text = json.dumps(value, default=str, ensure_ascii=False).replace("NaN", "nan").replace("Infinity", "inf")
    return text if len(text) <= LONGEST_VALUE else text[:LONGEST_VALUE] + " ..."


def _guess(value: Any, expected: str) -> str:
    close = get_close_matches(str(value), re.findall(r"'([^']*)'", expected), n=1)
    return f"; did you mean '{close[0]}'?" if close else ""


def _model_at(model: type[BaseModel], path: Path) -> type[BaseModel]:
    """The model of the table at a path."""
    for key in path:
        if isinstance(key, str):
            model = _models_in(model.model_fields[key].annotation)[0]
    return model


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models_in(part)]


def _field(model: type[BaseModel], path: Path) -> Any:
    names = [key for key in path if isinstance(key, str)]
    return _model_at(model, tuple(names[:-1])).model_fields.get(names[-1])


def _unit(model: type[BaseModel], path: Path) -> str:
    extra = getattr(_field(model, path), "json_schema_extra", None) or {}
    return f" {extra['unit']}" if extra.get("unit", "1") != "1" else ""


def _meaning(model: type[BaseModel], path: Path) -> str:
    field = _field(model, path)
    unit = _unit(model, path)
    return f": {field.description.rstrip('.')}" + (f" [{unit.strip()}]" if unit else "") if field else ""
