"""Runs studies in order and writes what they find."""

import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter
from typing import Any

from comotion.report.charts import draw
from comotion.report.findings import Findings
from comotion.report.machine import machine
from comotion.report.pages import Run, write_index, write_study
from comotion.report.study import Study

Say = Callable[[str], None]


@dataclass(frozen=True)
class Outcome:
    """A study that was run."""

    study: Study
    seconds: float
    error: str | None

    def as_data(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {"study": self.study.name, "seconds": self.seconds, "error": self.error}


def run_studies(studies: list[Study], folder: Path, *, quick: bool) -> list[Outcome]:
    """Run, write, draw; a study that ends with an error is reported and the next one runs.

    Each study is in the folder, and in its index, as soon as it is done; those that other runs left there stay.
    """
    folder.mkdir(parents=True, exist_ok=True)
    outcomes: list[Outcome] = []
    with _bar(studies) as (say, advance):
        for study in studies:
            here, today, error = machine(), datetime.now(UTC).date().isoformat(), None
            begin = perf_counter()
            try:
                found = study.run(quick=quick, say=lambda text, name=study.name: say(f"{name}: {text}"))  # type: ignore[misc]
                for chart in found.charts:
                    draw(chart, folder)
            except Exception as problem:  # noqa: BLE001 - the others are still wanted
                traceback.print_exc()
                error = f"{type(problem).__name__}: {problem}"
                found = Findings(notes=[f"This study failed: {error}"])
            outcome = Outcome(study, perf_counter() - begin, error)
            write_study(study, found, Run(today, here, outcome.seconds, error, quick), folder)
            write_index(folder)
            outcomes.append(outcome)
            advance(study.minutes)
    return outcomes


@contextmanager
def _bar(studies: list[Study]) -> Iterator[tuple[Say, Callable[[float], None]]]:
    """A bar over the studies' expected minutes, for people; nothing where nobody looks."""
    if not sys.stderr.isatty():
        yield (lambda _: None), (lambda _: None)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (BarColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=sum(study.minutes for study in studies))
        yield (lambda text: bar.update(task, description=text)), (lambda minutes: bar.advance(task, minutes))
