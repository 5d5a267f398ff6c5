"""Figures of every step of a run: a table and two plots."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.csv_table import CsvTable

if TYPE_CHECKING:
    from comotion_mock_cfd.cfd_client import StepRecord

COLUMNS = (
    *("time [s]", "dt [s]", "status", "wait [s]", "impacts", "responses"),
    *("momentum_error", "angular_momentum_error", "energy_error"),
    *("overlaps", "overlap_max [m]", "rest_energy [J]", "shift_work [J]"),
)
DEEP, LIGHT, RED, GREEN = "#1f4e79", "#9ec3e0", "#b5482a", "#4b7f52"
LEAST_ERROR = 1e-18  # drawn for an error of zero, which a logarithm cannot show


@dataclass
class History:
    """One row per step, written to `steps.csv` and kept for the plots; `wait` is the time until the reply was there."""

    table: CsvTable
    rows: list[tuple[float, ...]]

    @classmethod
    def into(cls, folder: Path) -> "History":
        """A history that writes into a folder."""
        return cls(CsvTable(folder / "steps.csv", COLUMNS), [])

    def add(self, step: "StepRecord", wait: float) -> None:
        """Take one step, for whose reply the client waited this long [s]."""
        books, budget = step.reply.books, step.reply.budget
        errors = (books.momentum, books.angular_momentum, books.energy)
        energies = (books.rest_energy or 0.0, books.shift_work or 0.0)
        self.table.write(
            [
                (
                    *(step.time, step.dt, step.reply.status, wait, books.impacts, budget.used),
                    *(*errors, books.overlaps, books.overlap_max, *energies),
                )
            ]
        )
        self.rows.append((step.time, wait, books.impacts, *errors, *energies))

    def plot_books(self, path: Path) -> None:
        """Impacts, the errors in their balances, and what coming to rest took, against time."""
        time, _, impacts, *errors, rest, shift = self._columns()
        figure, (top, middle, low) = _figure(3)
        top.step(time, np.cumsum(impacts), color=DEEP)
        top.set(ylabel="impacts so far", title="Books of the impacts")
        for error, name, colour in zip(
            errors, ("momentum", "angular momentum", "energy"), (DEEP, GREEN, RED), strict=True
        ):
            met = impacts > 0
            middle.semilogy(time[met], np.maximum(error[met], LEAST_ERROR), ".", ms=4, color=colour, label=name)
        middle.set(ylabel="relative error of a step's\nworst impact")
        if np.any(impacts > 0):
            middle.legend(frameon=False, ncols=3, fontsize="small")
        else:
            middle.text(0.5, 0.5, "no impacts", transform=middle.transAxes, ha="center")
        low.plot(time, np.cumsum(rest), color=RED, label="taken by coming to rest")
        low.plot(time, np.cumsum(shift), color=GREEN, label="done to keep held contacts at their gap")
        low.set(ylabel="energy so far [J]", xlabel="time [s]")
        low.legend(frameon=False, fontsize="small")
        figure.savefig(path, dpi=110)

    def plot_step_time(self, path: Path) -> None:
        """How long each step took, with the impacts in it, against time."""
        time, wait, impacts, *_ = self._columns()
        figure, (top, low) = _figure(2)
        top.semilogy(time, 1e3 * wait, ".", ms=4, color=DEEP)
        median = 1e3 * float(np.median(wait))
        top.axhline(median, color=RED, linestyle="--", label=f"median: {median:.3g} ms")
        top.set(ylabel="step, until the reply is there [ms]", title="Time of a step")
        top.legend(frameon=False, fontsize="small")
        low.bar(time, impacts, width=np.diff(time, prepend=0.0), color=LIGHT, align="edge")
        low.set(ylabel="impacts in the step", xlabel="time [s]")
        figure.savefig(path, dpi=110)

    def close(self) -> None:
        """Close the table."""
        self.table.close()

    def _columns(self) -> tuple[NDArray[np.float64], ...]:
        return tuple(np.array(self.rows, dtype=np.float64).T)


def _figure(rows: int) -> tuple[Any, Any]:
    """A figure of rows that share the axis of time."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 1.2 + 2.2 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, sharex=True)
    for each in axes:
        each.spines[["top", "right"]].set_visible(False)
        each.grid(alpha=0.25)
    return figure, axes
