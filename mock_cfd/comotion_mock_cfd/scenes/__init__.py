"""The scenes that come with comotion: every command that takes a scene takes one of these names, too."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parent


def names() -> tuple[str, ...]:
    """Names of the shipped scenes, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def path_of(name: str) -> Path:
    """The file of a shipped scene.

    Raises:
        KeyError: there is none of that name.
    """
    if name not in names():
        raise KeyError(f"no shipped scene {name!r}; there are {', '.join(names())}")
    return FOLDER / f"{name}.toml"
