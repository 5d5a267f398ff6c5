"""The matrix of stiff and extreme cases: what must happen, what was measured, pass or fail."""

from time import perf_counter

from comotion.report.cells import Cell
from comotion.report.findings import Findings, Table
from comotion.report.study import Progress

COLUMNS = ["case", "value", "what must happen", "criterion", "measured", "pass", "seconds", "explained"]


def all_cells() -> list[Cell]:
    """The whole matrix."""
    from comotion.report import extreme_bodies, extreme_crowds, extreme_input, extreme_meshes, extreme_symmetry

    modules = (extreme_bodies, extreme_meshes, extreme_crowds, extreme_input, extreme_symmetry)
    return [cell for module in modules for cell in module.cells()]


def study(*, quick: bool, say: Progress) -> Findings:
    """Every cell; in the quick report those that take under a second."""
    rows, passed = [], 0
    cells = [cell for cell in all_cells() if not (quick and cell.long)]
    for cell in cells:
        say(cell.name)
        begin = perf_counter()
        try:
            measured, why = cell.measure(), cell.explained
        except Exception as error:  # noqa: BLE001 - a cell that ends so has failed
            measured, why = float("nan"), f"{type(error).__name__}: {error} {cell.explained}".strip()
        good = measured <= cell.limit
        passed += good
        seconds = perf_counter() - begin
        rows.append([cell.case, cell.value, cell.required, cell.criterion, measured, good, seconds, why])
    table = Table("Stiff and extreme cases", COLUMNS, rows)
    return Findings(tables=[table], notes=[f"{passed} of {len(cells)} cells pass. Lengths in m, times in s."])
