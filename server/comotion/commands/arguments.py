"""What several commands' arguments share: how a scene is named, numbers, guesses at what was meant."""

import argparse
import math
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comotion.commands.errors import UserError

if TYPE_CHECKING:
    from comotion.outputs.stl import StepChoice


def add_command(commands: Any, name: str, summary: str, description: str, examples: str) -> argparse.ArgumentParser:
    """A command's own parser, with its help text and examples."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=summary,
        description=description,
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    return parser


def add_scene(parser: argparse.ArgumentParser, *, many: bool = False) -> None:
    """The argument SCENE, or several of them."""
    text = "scene file (TOML), or the name of a shipped scene"
    action = parser.add_argument("scene", metavar="SCENE", nargs="+" if many else None, help=text)
    action.complete = {"bash": "_shtab_compgen_files", "zsh": "_files"}  # type: ignore[attr-defined]


def add_play(parser: argparse.ArgumentParser) -> None:
    """Options of the mock CFD client: how long, in which steps, sampled when."""
    parser.add_argument("--duration", metavar="S", type=positive, help="simulated time [s] (default: the scene's)")
    parser.add_argument("--dt", metavar="S", type=positive, help="step [s] (default: the scene's)")
    sample = "when forces are sampled: predicted middle of the step, or end of the last one (default: midpoint)"
    parser.add_argument("--sample", choices=("midpoint", "end"), default="midpoint", help=sample)


def add_network(parser: argparse.ArgumentParser) -> None:
    """What zenoh is told beyond its endpoints."""
    parser.add_argument(
        "--zenoh-config", metavar="F", type=Path, help="zenoh's own configuration file (TLS and the like)"
    )
    insecure = "allow an endpoint beyond this machine without TLS; for private networks only"
    parser.add_argument("--insecure", action="store_true", help=insecure)


def add_json(parser: argparse.ArgumentParser) -> None:
    """The option --json."""
    parser.add_argument("--json", action="store_true", help="print JSON for programs instead of text for people")


def scene_path(text: str) -> Path:
    """Path of the scene that the user named.

    Raises:
        UserError: neither a file nor a shipped scene.
    """
    from comotion_mock_cfd import scenes

    path = Path(text)
    if path.is_file():
        return path
    names = list(scenes.names())
    if text in names:
        return Path(scenes.path_of(text))
    raise UserError(
        f"there is no scene {text!r}{closest(text, names)}; give a scene file or a shipped scene: {', '.join(names)}"
    )


def positive(text: str) -> float:
    """A positive finite number; what argparse calls for an option in seconds."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"expected a positive number, got {text!r}")
    return value


def count(text: str) -> int:
    """A whole number from 0 on."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0 on, got {text!r}")
    return int(text)


def steps(text: str) -> "StepChoice":
    """Steps, as `--stl` takes them."""
    from comotion.outputs.stl import StepChoice

    try:
        return StepChoice.of(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def closest(word: str, known: Iterable[str]) -> str:
    """A guess at what was meant, ready to be put behind a refusal; empty when nothing is close."""
    matches = get_close_matches(word, list(known), n=1)
    return f"; did you mean {matches[0]!r}?" if matches else ""
