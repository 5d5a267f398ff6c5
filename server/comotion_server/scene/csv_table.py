"""CSV files of poses: over time for a prescribed motion, one a member for an array."""

from __future__ import annotations

import csv
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from comotion_server.scene.pose_table import PoseTable
from comotion_server.scene.scene_errors import Problem, SceneError
from comotion_server.scene.tables import QUATERNION_TOLERANCE

if TYPE_CHECKING:
    from pathlib import Path

Floats = npt.NDArray[np.float64]

POSITION = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
MAX_ROWS = 1_000_000
"""More rows than this are refused; a pose for every millisecond of a quarter of an hour fits."""
HALF_TURN = 1e-6
"""Cosine of half the angle between two rows below which nobody can say which way round the body turns."""


def read_pose_table(path: Path) -> PoseTable:
    """Poses over time, columns t,x,y,z,qw,qx,qy,qz, strictly increasing times.

    Raises:
        SceneError: every bad row, by file and line.
    """
    rows, lines = _read_rows(path, (("t", *POSITION, *QUATERNION),))
    times, positions, quaternions = rows[:, 0], rows[:, 1:4], _unit_quaternions(path, rows[:, 4:], lines)
    problems = [
        Problem(str(path), lines[k + 1], "t", f"must increase from row to row; {times[k + 1]:g} follows {times[k]:g}")
        for k in np.flatnonzero(~(np.diff(times) > 0.0)).tolist()
    ]
    for k in range(1, len(quaternions)):  # q and -q are one attitude: take the side next to the row before
        cosine = float(quaternions[k] @ quaternions[k - 1])
        if abs(cosine) < HALF_TURN:
            message = "half a turn from the row before: which way round is not defined; add a row between"
            problems.append(Problem(str(path), lines[k], "qw,qx,qy,qz", message))
        quaternions[k] *= math.copysign(1.0, cosine)
    if problems:
        raise SceneError(problems)
    return PoseTable(*map(np.ascontiguousarray, (times, positions, quaternions)))


def read_poses(path: Path) -> tuple[Floats, Floats]:
    """Positions [m], shape (n, 3), and unit quaternions, shape (n, 4), columns x,y,z or x,y,z,qw,qx,qy,qz.

    Raises:
        SceneError: every bad row, by file and line.
    """
    rows, lines = _read_rows(path, (POSITION, (*POSITION, *QUATERNION)))
    if rows.shape[1] == len(POSITION):
        return rows, np.tile([1.0, 0.0, 0.0, 0.0], (len(rows), 1))
    return rows[:, :3], _unit_quaternions(path, rows[:, 3:], lines)


def _read_rows(path: Path, headers: tuple[tuple[str, ...], ...]) -> tuple[Floats, list[int]]:
    """Numbers, one row per line of the file, columns in the order of the header, and the lines they stand on."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            header = tuple(name.strip() for name in next(reader, []))
            if header not in headers:
                allowed = " or ".join(",".join(names) for names in headers)
                raise SceneError([Problem(str(path), 1, "", f"the header must be {allowed}; got {','.join(header)!r}")])
            return _numbers(path, reader, header)
    except OSError as error:
        raise SceneError([Problem(str(path), None, "", f"cannot be read: {error.strerror}")]) from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise SceneError([Problem(str(path), None, "", f"not a CSV file in UTF-8: {error}")]) from None


def _numbers(path: Path, reader: Any, header: tuple[str, ...]) -> tuple[Floats, list[int]]:
    rows: list[list[float]] = []
    lines: list[int] = []
    problems: list[Problem] = []
    for cells in reader:
        if not any(cell.strip() for cell in cells):
            continue
        row = [_number(cell) for cell in cells]
        if len(row) != len(header):
            problems.append(Problem(str(path), reader.line_num, "", f"must have {len(header)} columns; got {len(row)}"))
        problems += [
            Problem(str(path), reader.line_num, name, f"must be a finite number; got {cell.strip()!r}")
            for name, value, cell in zip(header, row, cells, strict=False)
            if not math.isfinite(value)
        ]
        rows.append(row)
        lines.append(reader.line_num)
        if len(rows) > MAX_ROWS:
            problems.append(Problem(str(path), reader.line_num, "", f"more than {MAX_ROWS} rows"))
            break
    if not rows:
        problems.append(Problem(str(path), None, "", "there is no row below the header"))
    if problems:
        raise SceneError(problems)
    return np.array(rows), lines


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _unit_quaternions(path: Path, quaternions: Floats, lines: list[int]) -> Floats:
    lengths = np.linalg.norm(quaternions, axis=1)
    problems = [
        Problem(str(path), lines[k], "qw,qx,qy,qz", f"must have length 1; its length is {lengths[k]:.6g}")
        for k in np.flatnonzero(np.abs(lengths - 1.0) > QUATERNION_TOLERANCE).tolist()
    ]
    if problems:
        raise SceneError(problems)
    return np.asarray(quaternions / lengths[:, None])
