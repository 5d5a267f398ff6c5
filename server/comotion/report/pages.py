"""Findings as Markdown: a page per study, and the page that leads to them."""

import json
from pathlib import Path
from typing import Any

from comotion.report.findings import Chart, Findings, Table
from comotion.report.study import Study


def write_study(study: Study, found: Findings, machine: dict[str, Any], folder: Path) -> None:
    """NAME.json and NAME.md."""
    data = {"study": study.name, "title": study.title, "machine": machine, **found.as_data()}
    (folder / f"{study.name}.json").write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    parts = [f"# {study.title}", *found.notes, *map(_chart, found.charts), *map(_table, found.tables)]
    (folder / f"{study.name}.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def write_index(done: list[tuple[Study, float]], machine: dict[str, Any], folder: Path, *, quick: bool) -> None:
    """README.md: the machine, and each study with the time it took."""
    libraries = ", ".join(f"{name} {number}" for name, number in machine["libraries"].items())
    size = "--quick: smallest sizes, few repeats" if quick else "full"
    lines = [
        "# Report",
        (
            "Made by `comotion report`; every page has its numbers as JSON beside it. Errors are against exact answers,"
            " times are medians of warm runs."
        ),
        (
            f"Run: {size}. Machine: {machine['processor']}, {machine['cores']} cores, load"
            f" {machine['load_at_start']} at the start; {machine['system']}, Python {machine['python']}; {libraries}."
        ),
        "| study | took |\n|---|---|\n"
        + "\n".join(f"| [{study.title}]({study.name}.md) | {seconds:.0f} s |" for study, seconds in done),
    ]
    (folder / "README.md").write_text("\n\n".join(lines) + "\n", encoding="utf-8")


def _chart(chart: Chart) -> str:
    rows = [
        [curve.name, f"{curve.parameter} {p.label}", p.x, p.y, curve.slope()]
        for curve in chart.curves
        for p in curve.points
    ]
    columns = ["method", "parameter", chart.x_label, chart.y_label, "slope of the curve"]
    return f"![{chart.title}]({chart.name}.png)\n\n{_table(Table(chart.title, columns, rows))}"


def _table(table: Table) -> str:
    lines = [f"## {table.title}", "", f"| {' | '.join(table.columns)} |", "|" + "---|" * len(table.columns)]
    lines += [f"| {' | '.join(map(_cell, row))} |" for row in table.rows]
    return "\n".join(lines)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value).replace("|", "/")
