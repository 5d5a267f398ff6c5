"""Findings as Markdown: a page per study, and the page that leads to them."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from comotion.report.findings import Chart, Findings, Table
from comotion.report.study import STUDIES, Study


@dataclass(frozen=True)
class Run:
    """When, where and how a study was run."""

    day: str
    machine: dict[str, Any]
    seconds: float
    error: str | None
    quick: bool


def write_study(study: Study, found: Findings, run: Run, folder: Path) -> None:
    """NAME.json and NAME.md."""
    data = {"study": study.name, "title": study.title, **asdict(run), **found.as_data()}
    (folder / f"{study.name}.json").write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    where = f"{run.day}, {'--quick' if run.quick else 'full'}, {run.seconds:.0f} s, on {_words(run.machine)}"
    parts = [f"# {study.title}", where, *found.notes, *map(_chart, found.charts), *map(_table, found.tables)]
    (folder / f"{study.name}.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def write_index(folder: Path) -> None:
    """README.md: every study that the folder holds, from whichever run, and the machines they ran on."""
    machines: list[str] = []
    rows = []
    for study in STUDIES:
        path = folder / f"{study.name}.json"
        if not path.is_file():
            continue
        data = json.loads(path.read_text(encoding="utf-8"))
        words = _words(data["machine"])
        if words not in machines:
            machines.append(words)
        size = "`--quick`" if data["quick"] else "full"
        number, load = machines.index(words) + 1, data["machine"]["load_at_start"]
        result = f"failed: {data['error']}" if data["error"] else "done"
        took = f"{data['seconds']:.0f} s"
        rows.append([f"[{study.title}]({study.name}.md)", result, took, size, data["day"], number, load])
    columns = ["study", "result", "took", "size", "day", "machine", "load at its start"]
    lines = [
        "# Report",
        (
            "Made by `comotion report`; every page has its numbers as JSON beside it. Errors are against exact answers,"
            " times are medians of warm runs. `--quick`: smallest sizes, few repeats."
        ),
        _table(Table("Studies", columns, rows)),
        "## Machines",
        *(f"{k}. {words}" for k, words in enumerate(machines, 1)),
    ]
    (folder / "README.md").write_text("\n\n".join(lines) + "\n", encoding="utf-8")


def _words(machine: dict[str, Any]) -> str:
    libraries = ", ".join(f"{name} {number}" for name, number in machine["libraries"].items())
    system = f"{machine['system']}, Python {machine['python']}"
    return f"{machine['processor']}, {machine['cores']} cores; {system}; {libraries}"


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
