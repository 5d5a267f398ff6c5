"""What must not be in any file of the repository."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

FORBIDDEN = {
    "an unfinished mark": re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X)\b|NotImplemented" r"Error"),
    "a path of some machine": re.compile(r"(^|[\s\"'(=])/(work|tmp|root|farm|home)/"),
    "a package registry's address": re.compile(
        r"pypi\.org|python[h]osted|npmjs\.(org|com)|crates\.io|proxy\.golang|index[-]url|https?://\S*/(simple|packages)/"
    ),
}
# What the images are built and run with has paths of its own inside the container.
OWN_PATHS = {"docker/Dockerfile.server", "docker/Dockerfile.mock"}


def text_files():
    """Files that git knows, with their text; binary ones are left out."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False)  # noqa: S607
    if listed.returncode != 0:
        pytest.skip("not a git work tree")
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if not path.is_file():
            continue
        raw = path.read_bytes()
        if b"\0" not in raw[:8192]:
            yield name, raw.decode("utf-8", errors="replace")


@pytest.mark.parametrize("what", FORBIDDEN)
def test_no_file_has(what):
    found = [
        f"{name}:{number}: {line.strip()[:80]}"
        for name, text in text_files()
        for number, line in enumerate(text.splitlines(), 1)
        if FORBIDDEN[what].search(line) and not (name in OWN_PATHS and "path" in what)
    ]
    assert found == []


def test_names_of_test_files_are_unique():
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert sorted(names) == sorted(set(names))


def test_every_line_of_the_changelog_belongs_to_a_version():
    text = (ROOT / "CHANGELOG.md").read_text()
    version = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert version is not None
    assert re.findall(r"^## \[(.+?)\]", text, re.MULTILINE)[0] == version[1]
