"""What a study finds: curves of error against cost, and tables. Plain data, written by `pages.py`."""

from dataclasses import asdict, dataclass, field
from math import isfinite, log
from typing import Any

ROUNDING = 2.0**-52
"""The floor that figures show: errors below it are rounding."""

SPREAD = 1.5
"""Least ratio of the costs of a curve that a slope is fitted to; below it, noise is all there is."""

CORRELATED = 0.9
"""Least square of the correlation of a curve that a slope is fitted to."""


@dataclass(frozen=True)
class Point:
    """One run: what it cost, how wrong it was, and at which value of the curve's parameter."""

    x: float
    y: float
    label: str


@dataclass
class Curve:
    """All runs of one method."""

    name: str
    parameter: str
    points: list[Point] = field(default_factory=list)

    def slope(self) -> float | None:
        """Exponent p of y = c x^p, by least squares over the points above rounding; None where they are on no line."""
        seen = [(log(p.x), log(p.y)) for p in self.points if isfinite(p.y) and p.y > 10 * ROUNDING and p.x > 0]
        if len(seen) < 2 or max(seen)[0] - min(seen)[0] < log(SPREAD):
            return None
        mean_x, mean_y = (sum(column) / len(seen) for column in zip(*seen, strict=True))
        centred = [(x - mean_x, y - mean_y) for x, y in seen]
        xx, xy, yy = sum(x * x for x, _ in centred), sum(x * y for x, y in centred), sum(y * y for _, y in centred)
        return xy / xx if xy * xy > CORRELATED * xx * yy else None


@dataclass
class Chart:
    """A figure with logarithmic axes, a curve per method."""

    name: str
    title: str
    x_label: str
    y_label: str
    curves: list[Curve]
    floor: float | None = ROUNDING  # of y


@dataclass
class Table:
    """Rows under columns; cells are text, numbers, truth values or None."""

    title: str
    columns: list[str]
    rows: list[list[Any]]


@dataclass
class Findings:
    """Everything that one study found."""

    charts: list[Chart] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def as_data(self) -> dict[str, Any]:
        """Plain data for JSON; slopes with the curves; numbers that JSON does not have as text."""
        data = asdict(self)
        for chart, plain in zip(self.charts, data["charts"], strict=True):
            for curve, as_plain in zip(chart.curves, plain["curves"], strict=True):
                as_plain["slope"] = curve.slope()
        clean: dict[str, Any] = _finite(data)
        return clean


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if hasattr(value, "item"):
        value = value.item()
    return str(value) if isinstance(value, float) and not isfinite(value) else value
