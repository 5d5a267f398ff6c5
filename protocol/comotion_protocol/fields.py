"""Strict reading of one map of a header: a missing key, a wrong type or a value out of range is refused by name.

Unknown keys are not looked at; nil in an optional key counts as absent (SPEC B8).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Self, TypeVar

from comotion_protocol import limits
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.messages import Vector

_T = TypeVar("_T")


class Fields:
    """One map, and where it stands in the message (`where`, for the error's text)."""

    def __init__(self, values: Any, where: str) -> None:
        if not isinstance(values, dict):
            raise refusal("wrong_type", "B8", where, "a map", values)
        self._values = values
        self._where = where

    def has(self, key: str) -> bool:
        """Whether the key is there and not nil."""
        return self._values.get(key) is not None

    def optional(self, read: Callable[[str], _T], key: str) -> _T | None:
        """What `read` finds under the key, or None if it is absent or nil."""
        return read(key) if self.has(key) else None

    def raw(self, key: str) -> Any:
        """The value as it came; refused if missing."""
        value = self._values.get(key)
        if value is None:
            raise RemoteProtocolError("missing", "B8", f"{self._name(key)} is missing", {"field": self._name(key)})
        return value

    def flag(self, key: str) -> bool:
        """A boolean."""
        value = self.raw(key)
        if type(value) is not bool:
            raise refusal("wrong_type", "B8", self._name(key), "a boolean", value)
        return value

    def text(self, key: str, longest: int = limits.NAME_LENGTH) -> str:
        """A string of 1 to `longest` characters."""
        value = self.raw(key)
        if type(value) is not str:
            raise refusal("wrong_type", "B8", self._name(key), "a string", value)
        if not 0 < len(value) <= longest:
            raise refusal("out_of_range", "B10", self._name(key), f"1 to {longest} characters", value)
        return value

    def choice(self, key: str, allowed: Sequence[str]) -> Any:
        """One of the strings allowed."""
        value = self.text(key)
        if value not in allowed:
            raise refusal("out_of_range", "B11", self._name(key), f"one of {', '.join(allowed)}", value)
        return value

    def count(self, key: str, least: int = 0) -> int:
        """An integer from `least` to 2^53 - 1."""
        value = self.raw(key)
        if type(value) is not int:
            raise refusal("wrong_type", "B8", self._name(key), "an integer", value)
        if not least <= value <= limits.COUNT_MAX:
            raise refusal("out_of_range", "B11", self._name(key), f"an integer from {least} to 2^53 - 1", value)
        return value

    def real(self, key: str) -> float:
        """A float of any value."""
        value = self.raw(key)
        if type(value) is not float:
            raise refusal("wrong_type", "B8", self._name(key), "a float", value)
        return value

    def finite(self, key: str) -> float:
        """A float that is neither NaN nor infinite."""
        value = self.real(key)
        if not math.isfinite(value):
            raise refusal("not_finite", "B9", self._name(key), "a finite number", value)
        return value

    def vector(self, key: str) -> Vector:
        """Three finite floats."""
        value = self.raw(key)
        if type(value) is not list or [type(x) for x in value] != [float, float, float]:
            raise refusal("wrong_type", "B8", self._name(key), "three floats", value)
        x, y, z = value
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            raise refusal("not_finite", "B9", self._name(key), "three finite floats", value)
        return (x, y, z)

    def version(self, key: str) -> tuple[int, int]:
        """Major and minor version."""
        value = self.raw(key)
        if type(value) is not list or len(value) != 2 or not all(type(n) is int and n >= 0 for n in value):
            raise refusal("wrong_type", "B8", self._name(key), "two integers", value)
        return (value[0], value[1])

    def map(self, key: str) -> Self:
        """A map inside this one."""
        return type(self)(self.raw(key), self._name(key))

    def texts(self, key: str) -> Mapping[str, str]:
        """A map of strings to strings."""
        inner = self.map(key)
        return {name: inner.text(name) for name in inner._values}  # noqa: SLF001  (of this class)

    def names(self, key: str) -> tuple[str, ...]:
        """A list of names."""
        inner = type(self)({str(n): item for n, item in enumerate(self._list(key))}, self._name(key))
        return tuple(map(inner.text, inner._values))  # noqa: SLF001  (of this class)

    def maps(self, key: str) -> list[Self]:
        """A list of maps."""
        value = self._list(key)
        return [type(self)(item, f"{self._name(key)}[{n}]") for n, item in enumerate(value)]

    def _list(self, key: str) -> list[Any]:
        value = self.raw(key)
        if type(value) is not list:
            raise refusal("wrong_type", "B8", self._name(key), "a list", value)
        return value

    def _name(self, key: str) -> str:
        return f"{self._where}.{key}" if self._where else key


def refusal(code: str, rule: str, field: str, expected: str, got: Any) -> RemoteProtocolError:
    """The error for one value: which field, what was expected, what came."""
    shown = repr(got)
    shown = shown if len(shown) <= 60 else f"{shown[:60]}..."
    return RemoteProtocolError(
        code,
        rule,
        f"{field or 'header'}: expected {expected}, got {shown}",
        {"field": field or "header", "expected": expected, "got": shown},
    )
