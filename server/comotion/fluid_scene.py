"""The fluid side of a scene file, with mistakes told in the same words and form as those of the server's side."""

import tomllib
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from comotion_mock_cfd.fluid import Fluid, FluidError, FluidScene, load_fluid
from comotion_server.scene.problems import Problems, path_of, sentence
from comotion_server.scene.scene_errors import Problem, SceneError
from comotion_server.scene.tables import SceneFile
from comotion_server.scene.toml_lines import lines_of

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails


def load_fluid_scene(path: Path) -> FluidScene:
    """The fluid side of the scene in a file.

    Raises:
        SceneError: every mistake in it.
    """
    try:
        return load_fluid(path)
    except ValidationError as error:
        raise SceneError(_problems(path, error)) from None
    except FluidError as error:
        raise SceneError([Problem(str(path), None, "", str(error))]) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SceneError([Problem(str(path), None, "", f"not TOML: {error}")]) from None
    except OSError as error:
        raise SceneError([Problem(str(path), None, "", f"cannot be read: {error.strerror}")]) from None


def _problems(path: Path, error: ValidationError) -> list[Problem]:
    text = path.read_text(encoding="utf-8-sig")
    problems = Problems(str(path), tomllib.loads(text), lines_of(text))
    for found in error.errors(include_url=False):
        problems.add(path_of(found), _sentence(found))
    return problems.found


def _sentence(found: "ErrorDetails") -> str:
    place = found["loc"]
    if place[0] != "fluid" or len(place) == 1:
        return sentence(found, SceneFile)
    if place[1] == "added_mass":  # its keys are names of regions and bodies: no model knows them
        return f"{found['msg'][:1].lower()}{found['msg'][1:]}; got {found['input']!r}"
    found["loc"] = place[1:]
    return sentence(found, Fluid)
