"""A progress bar on standard error, for people only: nothing is drawn when it goes to a file or a program."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from comotion.run_record import RunRecord

Show = Callable[[RunRecord], None]


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """A sign of life while something else works."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(text):
        yield


@contextmanager
def progress(duration: float) -> Iterator[Show]:
    """A bar over the simulated time [s] with steps and impacts; gives what redraws it."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.completed:.2f} of {task.total:g} s", markup=False),
        BarColumn(),
        TextColumn("{task.fields[steps]} steps, {task.fields[impacts]} impacts", markup=False),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=duration, steps=0, impacts=0)
        yield lambda record: bar.update(task, completed=record.time, steps=record.steps, impacts=record.impacts)


@contextmanager
def counting(text: str) -> Iterator[Callable[[int, int], None]]:
    """A bar over things that are done one after the other; gives what redraws it: so many done, of so many."""
    if not sys.stderr.isatty():
        yield lambda _, __: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    with Progress(
        TextColumn(text, markup=False), BarColumn(), MofNCompleteColumn(), console=Console(stderr=True)
    ) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)
