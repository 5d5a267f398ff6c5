"""A CSV file that is written row by row and readable while the run goes on."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

Cell = str | int | float


class CsvTable:
    """Columns carry their unit in the header, like `x [m]`; numbers are written so that they read back bit for bit."""

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self._file = path.open("w", newline="", encoding="utf-8")
        self._writer = csv.writer(self._file, lineterminator="\n")
        self._writer.writerow(columns)

    def write(self, rows: Iterable[Sequence[Cell]]) -> None:
        """Append rows and hand them to the operating system, so that a killed run keeps them."""
        self._writer.writerows(rows)
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()
