"""Line numbers of keys: for every path of a parsed TOML text a line, and on it the key."""

import tomllib
from pathlib import Path

import pytest

from comotion_server.scene.toml_lines import lines_of

SCENES = Path(__file__).parents[2] / "mock_cfd" / "comotion_mock_cfd" / "scenes"

HARD = r'''
# [not.a.table]
top = 1  # comment with "quotes" and [brackets
"quoted key" = 'a # no comment'
'literal "key"' = "escaped \" quote ] } #"
a.b . "c.d" = 2
date = 1979-05-27 07:32:00Z
text = """
[[body]]
mass = 3 \""" still text """""
raw = \'\'\'
x = 1
\'\'\'

[table.inner] # comment ]
list = [1,
  [2, "]"], # comment ]
  { x = 1, y = [ 4 ] },
]
inline = { p = { q = 1 }, r.s = "}", t = '}' }
[[body]]
name = "a"
[body.shape]
size = [1, 2, 3]
[[body]]
name = "b"
[[body.part]]
x = 1
[[body.part]]
x = 2
[body.part.deep]
y = 3
[ spaced . out ]
z = true
'''.replace("\\'\\'\\'", "'''")


def paths_of(value, path=()):
    if path:
        yield path
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in entries:
        yield from paths_of(entry, (*path, key))


def test_every_path_has_its_line():
    lines = lines_of(HARD)
    assert set(lines) == set(paths_of(tomllib.loads(HARD)))
    rows = HARD.split("\n")
    for path, line in lines.items():
        if isinstance(path[-1], str):
            assert path[-1].replace('"', "") in rows[line - 1].replace('"', "").replace("\\", ""), path


@pytest.mark.parametrize(
    ("path", "row"),
    [
        (("top",), "top = 1  #"),
        (("a", "b", "c.d"), "a.b ."),
        (("table", "inner", "list", 1, 1), '  [2, "]"]'),
        (("table", "inner", "list", 2, "y", 0), "  { x = 1"),
        (("table", "inner", "inline", "r", "s"), "inline ="),
        (("body", 0, "shape", "size", 2), "size ="),
        (("body", 1, "name"), 'name = "b"'),
        (("body", 1, "part", 1, "deep", "y"), "y = 3"),
        (("spaced", "out", "z"), "z = true"),
    ],
)
def test_lines_by_example(path, row):
    assert HARD.split("\n")[lines_of(HARD)[path] - 1].startswith(row)


def test_lines_of_windows_files():
    windows = HARD.replace("\n", "\r\n")
    assert lines_of(windows) == lines_of(HARD)


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.toml")), ids=lambda path: path.stem)
def test_shipped_scenes(path):
    text = path.read_text()
    assert set(lines_of(text)) == set(paths_of(tomllib.loads(text)))
