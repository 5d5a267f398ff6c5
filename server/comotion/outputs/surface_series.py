"""Time series as VTKHDF files, which ParaView 5.13 and later open: the moving surfaces, and the impacts on them.

Format: VTKHDF 2.3, type PolyData with a `Steps` group (VTK, "VTKHDF file format"). The triangles are stored once: every
step has the same offsets into them; only points are appended. All four topologies are there, empty ones too, because
the reader asks for each.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from comotion.outputs.surface import Surface

if TYPE_CHECKING:
    from comotion_protocol.messages import Impact

TOPOLOGIES = ("Vertices", "Lines", "Polygons", "Strips")
VERSION = (2, 3)
IMPACT_ARRAYS: tuple[tuple[str, tuple[int, ...], str], ...] = (
    ("Points", (3,), "<f8"),
    ("PointData/impulse", (3,), "<f8"),
    ("PointData/approach_speed", (), "<f8"),
    ("PointData/time", (), "<f8"),
    ("PointData/body_a", (), "<i4"),
    ("PointData/body_b", (), "<i4"),
)
CHUNK_STEPS = 64  # entries of the per-step lists in one chunk of the file


class SurfaceSeries:
    """Writes `points` and `velocity` of one surface over time; the body of each triangle is the cell array `body`.

    Beside it, in the group `comotion`: `names` and `motion` of the bodies in the order of their numbers, `poses`,
    `twists`, `scales` (P16), the body of each point, and as attribute the water level [m], if there is water.
    """

    def __init__(self, path: Path, surface: Surface, motion: Mapping[str, str], water_level: float | None) -> None:
        triangles, points = surface.triangles, len(surface.points)
        self._file = h5py.File(path, "w")
        self._points = points
        self._body_of_point = surface.body_of_point
        root = _create_root(self._file)
        root["NumberOfPoints"] = [points]
        root.create_dataset("Points", (0, 3), maxshape=(None, 3), chunks=(max(points, 1), 3), dtype="<f8")
        for topology in TOPOLOGIES:
            _write_cells(root.create_group(topology), triangles if topology == "Polygons" else triangles[:0])
        root.create_dataset("PointData/velocity", (0, 3), maxshape=(None, 3), chunks=(max(points, 1), 3), dtype="<f4")
        root["CellData/body"] = surface.body_of_triangle.astype(np.int32)
        self._root = root
        self._steps = _create_steps(root, ("CellDataOffsets/body", "PointDataOffsets/velocity"))
        self._own = _create_own(self._file, surface, motion, water_level)

    def append(
        self,
        time: float,
        points: NDArray[np.float64],
        poses: NDArray[np.float64],
        twists: NDArray[np.float64],
        scales: NDArray[np.float64],
    ) -> None:
        """One more state at a time [s]: all points [m], shape (n, 3); per body poses (7), twists (6), scale; world."""
        step = int(self._steps.attrs["NSteps"])
        arms = points - poses[self._body_of_point, :3]
        velocity = twists[self._body_of_point, :3] + np.cross(twists[self._body_of_point, 3:], arms)
        _extend(self._root["Points"], points)
        _extend(self._root["PointData/velocity"], velocity)
        for name, value in (("poses", poses), ("twists", twists), ("scales", scales)):
            _extend(self._own[name], value[None])
        for name in ("PointOffsets", "PointDataOffsets/velocity"):
            _append(self._steps[name], step * self._points)
        _append(self._steps["Values"], time)
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


class ImpactSeries:
    """Writes impacts since the state before as points with `impulse` [N s] on body b, `approach_speed`, bodies."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        self._rows = {name: row for row, name in enumerate(names)}
        self._file = h5py.File(path, "w")
        self._root = _create_root(self._file)
        self._root.create_dataset("NumberOfPoints", (0,), maxshape=(None,), chunks=(CHUNK_STEPS,), dtype="<i8")
        for name, width, kind in IMPACT_ARRAYS:
            self._root.create_dataset(name, (0, *width), maxshape=(None, *width), chunks=(1024, *width), dtype=kind)
        for topology in TOPOLOGIES:
            group = self._root.create_group(topology)
            for name in ("NumberOfConnectivityIds", "NumberOfCells", "Offsets", "Connectivity"):
                group.create_dataset(name, (0,), maxshape=(None,), chunks=(1024,), dtype="<i8")
        offsets = tuple(f"PointDataOffsets/{name.removeprefix('PointData/')}" for name, *_ in IMPACT_ARRAYS[1:])
        self._steps = _create_steps(self._root, offsets)

    def append(self, time: float, impacts: Sequence["Impact"]) -> None:
        """The impacts since the last state, at a state's time [s]."""
        step, before = int(self._steps.attrs["NSteps"]), len(self._root["Points"])
        for (name, width, _), values in zip(IMPACT_ARRAYS, self._arrays(impacts), strict=True):
            _extend(self._root[name], np.array(values, dtype=np.float64).reshape(-1, *width))
        _append(self._root["NumberOfPoints"], len(impacts))
        for topology in TOPOLOGIES:
            count, group = len(impacts) if topology == "Vertices" else 0, self._root[topology]
            _append(group["NumberOfCells"], count)
            _append(group["NumberOfConnectivityIds"], count)
            _extend(group["Offsets"], np.arange(count + 1))
            _extend(group["Connectivity"], np.arange(count))
        for name in self._steps:
            if name.endswith("Offsets") and name.startswith("Point"):
                for offsets in self._steps[name].values() if name == "PointDataOffsets" else [self._steps[name]]:
                    _append(offsets, before)
        at = [before, 0, 0, 0]
        _extend(self._steps["CellOffsets"], np.array([at]))
        _extend(self._steps["ConnectivityIdOffsets"], np.array([at]))
        for name, value in (("Values", time), ("PartOffsets", step), ("NumberOfParts", 1)):
            _append(self._steps[name], value)
        self._steps.attrs["NSteps"] = step + 1

    def close(self) -> None:
        """Close the file; what was appended stays readable."""
        self._file.close()

    def _arrays(self, impacts: Sequence["Impact"]) -> Iterator[list[Any]]:
        """Values in the order of `IMPACT_ARRAYS`; a body without a surface has number -1."""
        yield [hit.point for hit in impacts]
        yield [
            np.multiply(hit.impulse, hit.normal) + (hit.friction if hit.friction is not None else 0.0)
            for hit in impacts
        ]
        yield [hit.approach_speed for hit in impacts]
        yield [hit.time for hit in impacts]
        yield [self._rows.get(hit.body_a, -1) for hit in impacts]
        yield [self._rows.get(hit.body_b, -1) for hit in impacts]


def _create_root(file: Any) -> Any:
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = VERSION
    root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
    return root


def _create_own(file: Any, surface: Surface, motion: Mapping[str, str], water_level: float | None) -> Any:
    """What VTK has no place for: who the bodies are and how they are moved."""
    own = file.create_group("comotion")
    if water_level is not None:
        own.attrs["water_level"] = water_level
    own["body_of_point"] = surface.body_of_point.astype(np.int32)
    names = [body.name for body in surface.bodies]
    text = h5py.string_dtype("utf-8")
    own.create_dataset("names", data=names, dtype=text)
    own.create_dataset("motion", data=[motion.get(name, "free") for name in names], dtype=text)
    for name, width in (("poses", (7,)), ("twists", (6,)), ("scales", ())):
        shape = (len(names), *width)
        own.create_dataset(name, (0, *shape), maxshape=(None, *shape), chunks=(1, *map(_one, shape)), dtype="<f8")
    return own


def _one(count: int) -> int:
    return max(count, 1)  # a chunk is never empty


def _write_cells(group: Any, triangles: NDArray[np.int64]) -> None:
    count = len(triangles)
    group["NumberOfConnectivityIds"] = [3 * count]
    group["NumberOfCells"] = [count]
    group["Offsets"] = 3 * np.arange(count + 1, dtype=np.int64)
    group["Connectivity"] = triangles.ravel()


def _create_steps(root: Any, array_offsets: Sequence[str]) -> Any:
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = 0
    for name, width, kind in (
        ("Values", (), "<f8"),
        ("PartOffsets", (), "<i8"),
        ("NumberOfParts", (), "<i8"),
        ("PointOffsets", (), "<i8"),
        ("CellOffsets", (len(TOPOLOGIES),), "<i8"),
        ("ConnectivityIdOffsets", (len(TOPOLOGIES),), "<i8"),
        *((name, (), "<i8") for name in array_offsets),
    ):
        steps.create_dataset(name, (0, *width), maxshape=(None, *width), chunks=(CHUNK_STEPS, *width), dtype=kind)
    return steps


def _append(dataset: Any, value: float) -> None:
    dataset.resize(len(dataset) + 1, axis=0)
    dataset[-1] = value


def _extend(dataset: Any, values: NDArray[Any]) -> None:
    before = len(dataset)
    dataset.resize(before + len(values), axis=0)
    dataset[before:] = values
