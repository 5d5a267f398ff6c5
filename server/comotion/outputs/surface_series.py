"""A time series of moving surfaces as one VTKHDF file, which ParaView 5.13 and later open.

Format: VTKHDF 2.3, type PolyData with a `Steps` group (VTK, "VTKHDF file format"). The triangles are stored once: every
step has the same offsets into them; only points are appended. All four topologies are there, empty ones too, because
the reader asks for each.
"""

from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

TOPOLOGIES = ("Vertices", "Lines", "Polygons", "Strips")
VERSION = (2, 3)
CHUNK_STEPS = 64  # entries of the per-step lists in one chunk of the file


class SurfaceSeries:
    """Writes `points` of one surface over time; the body of each triangle is the cell array `body`."""

    def __init__(
        self, path: Path, triangles: NDArray[np.int64], body_of_triangle: NDArray[np.int64], points: int
    ) -> None:
        self._file = h5py.File(path, "w")
        self._points = points
        root = self._file.create_group("VTKHDF")
        root.attrs["Version"] = VERSION
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        root["NumberOfPoints"] = [points]
        root.create_dataset("Points", (0, 3), maxshape=(None, 3), chunks=(max(points, 1), 3), dtype="<f8")
        for topology in TOPOLOGIES:
            _write_cells(root.create_group(topology), triangles if topology == "Polygons" else triangles[:0])
        root["CellData/body"] = body_of_triangle.astype(np.int32)
        self._root = root
        self._steps = _create_steps(root)

    def append(self, time: float, points: NDArray[np.float64]) -> None:
        """One more state: time [s] and all points [m], shape (n, 3), world frame."""
        step = int(self._steps.attrs["NSteps"])
        stored: Any = self._root["Points"]
        stored.resize((step + 1) * self._points, axis=0)
        stored[step * self._points :] = points
        for name, value in (("Values", time), ("PointOffsets", step * self._points)):
            _append(self._steps[name], value)
        for name in ("PartOffsets", "CellOffsets", "ConnectivityIdOffsets", "CellDataOffsets/body"):
            _append(self._steps[name], 0)
        _append(self._steps["NumberOfParts"], 1)
        self._steps.attrs["NSteps"] = step + 1

    def close(self) -> None:
        """Close the file; what was appended stays readable."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _write_cells(group: Any, triangles: NDArray[np.int64]) -> None:
    count = len(triangles)
    group["NumberOfConnectivityIds"] = [3 * count]
    group["NumberOfCells"] = [count]
    group["Offsets"] = 3 * np.arange(count + 1, dtype=np.int64)
    group["Connectivity"] = triangles.ravel()


def _create_steps(root: Any) -> Any:
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = 0
    for name, width, kind in (
        ("Values", (), "<f8"),
        ("PartOffsets", (), "<i8"),
        ("NumberOfParts", (), "<i8"),
        ("PointOffsets", (), "<i8"),
        ("CellOffsets", (len(TOPOLOGIES),), "<i8"),
        ("ConnectivityIdOffsets", (len(TOPOLOGIES),), "<i8"),
        ("CellDataOffsets/body", (), "<i8"),
    ):
        steps.create_dataset(name, (0, *width), maxshape=(None, *width), chunks=(CHUNK_STEPS, *width), dtype=kind)
    return steps


def _append(dataset: Any, value: float) -> None:
    dataset.resize(len(dataset) + 1, axis=0)
    dataset[-1] = value
