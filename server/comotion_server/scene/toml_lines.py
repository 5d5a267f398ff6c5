"""On which line of a TOML text each key stands: `tomllib` does not say.

The text is walked once, taking for granted that it *is* TOML (parse it first): only where keys, values and strings
begin and end is looked at. A path is what leads to a value in the parsed document: ("body", 0, "shape", "stl").
"""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_right

Path = tuple[str | int, ...]

BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
BARE_VALUE = re.compile(r"[^,\]}\n#]*")
STRINGS = (  # longest opening first
    ('"""', re.compile(r'"""(?:[^\\]|\\.)*?"{3,5}', re.DOTALL)),
    ("'''", re.compile(r"'''.*?'{3,5}", re.DOTALL)),
    ('"', re.compile(r'"(?:[^"\\\n]|\\.)*"')),
    ("'", re.compile(r"'[^'\n]*'")),
)


def lines_of(text: str) -> dict[Path, int]:
    """The line, counted from 1, of every table, key and list entry of a valid TOML text."""
    return _Walk(text.replace("\r\n", "\n")).document()


class _Walk:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.newlines = [found.start() for found in re.finditer("\n", text)]
        self.lines: dict[Path, int] = {}
        self.table_counts: dict[Path, int] = {}  # tables so far of every [[array of tables]]

    def document(self) -> dict[Path, int]:
        prefix: Path = ()
        while self._skip_blank():
            if self.text.startswith("[", self.at):
                prefix = self._header()
            else:
                self._pair(prefix)
        return self.lines

    def _header(self) -> Path:
        start = self.at
        opening = "[[" if self.text.startswith("[[", self.at) else "["
        self.at += len(opening)
        path: Path = ()
        keys = self._dotted_key()
        for key in keys[:-1]:
            path += (key,)
            if path in self.table_counts:
                path += (self.table_counts[path] - 1,)
            self._note(path, start)
        path += (keys[-1],)
        self._note(path, start)
        if opening == "[[":
            count = self.table_counts.get(path, 0)
            self.table_counts[path] = count + 1
            path += (count,)
            self._note(path, start)
        self.at = self.text.index("]", self.at) + len(opening)
        return path

    def _pair(self, prefix: Path) -> None:
        start = self.at
        path = prefix
        for key in self._dotted_key():
            path += (key,)
            self._note(path, start)
        self.at = self.text.index("=", self.at) + 1
        self._value(path)

    def _value(self, path: Path) -> None:
        self._skip_blank()
        if self.text.startswith("[", self.at):
            self._entries(path, "]")
        elif self.text.startswith("{", self.at):
            self._entries(path, "}")
        elif self.text.startswith(('"', "'"), self.at):
            self._string()
        else:
            self._match(BARE_VALUE)

    def _entries(self, path: Path, closing: str) -> None:
        self.at += 1
        count = 0
        while self._skip_blank() and not self.text.startswith(closing, self.at):
            if self.text.startswith(",", self.at):
                self.at += 1
            elif closing == "}":
                self._pair(path)
            else:
                self._note((*path, count), self.at)
                self._value((*path, count))
                count += 1
        self.at += 1

    def _dotted_key(self) -> list[str]:
        keys = []
        while True:
            self._skip_blank()
            if self.text.startswith(('"', "'"), self.at):
                keys.append(str(tomllib.loads(f"key = {self._string()}")["key"]))
            else:
                keys.append(self._match(BARE_KEY))
            self._skip_blank()
            if not self.text.startswith(".", self.at):
                return keys
            self.at += 1

    def _string(self) -> str:
        pattern = next(pattern for opening, pattern in STRINGS if self.text.startswith(opening, self.at))
        return self._match(pattern)

    def _match(self, pattern: re.Pattern[str]) -> str:
        found = pattern.match(self.text, self.at)
        if found is None:
            raise ValueError(f"not TOML at character {self.at}")
        self.at = found.end()
        return found.group()

    def _skip_blank(self) -> bool:
        """Go to the next thing; whether there is one."""
        self._match(BLANK)
        return self.at < len(self.text)

    def _note(self, path: Path, at: int) -> None:
        self.lines.setdefault(path, bisect_right(self.newlines, at) + 1)
