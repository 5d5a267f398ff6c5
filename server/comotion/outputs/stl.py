"""Surfaces of single steps as binary STL: one file per region, as a CFD solver takes its boundaries.

Format: 80 bytes of text, the number of triangles, then per triangle its normal, three corners (float32, little-endian)
and two bytes of nothing. A coordinate in the file is the float32 nearest to the one of the run.
"""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.shading import face_normals

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
HEADER_BYTES = 80


@dataclass(frozen=True)
class StepChoice:
    """Steps that were asked for: `3,10` single ones, `100:500` and `0:1000:50` ranges with both ends, `all`, `last`.

    Step 0 is the state at the start.
    """

    ranges: tuple[tuple[int, int, int], ...] = ()
    last: bool = False

    @classmethod
    def of(cls, text: str) -> Self:
        """The choice in an option's text; ValueError when there is none."""
        ranges, last = [], False
        for part in text.split(","):
            if part == "last":
                last = True
            elif part == "all":
                ranges.append((0, 2**53, 1))
            elif re.fullmatch(r"\d+(:\d+){0,2}", part):
                first, *rest = (int(number) for number in part.split(":"))
                ranges.append((first, rest[0] if rest else first, max(rest[1], 1) if len(rest) > 1 else 1))
            else:
                raise ValueError(f"expected steps such as 100 or 10,20 or 0:1000:50 or all or last, got {part!r}")
        return cls(tuple(ranges), last)

    def __contains__(self, step: int) -> bool:
        return any(first <= step <= end and (step - first) % stride == 0 for first, end, stride in self.ranges)


class StlFiles:
    """Writes the regions of a run, `<region>_step<step>.stl`; a region that never moves is written once."""

    def __init__(self, folder: Path, triangles: Mapping[str, NDArray[np.uint32]], still: Collection[str] = ()) -> None:
        """Write into a folder, which is made; `still` regions never move."""
        folder.mkdir(exist_ok=True)
        self._folder = folder
        self._triangles = triangles
        self._names = _file_names(triangles)
        self._still = set(still)
        self._done: set[str] = set()

    def write(self, step: int, time: float, vertices: Mapping[str, NDArray[np.float64]]) -> None:
        """The regions given, with vertices [m], shape (n, 3), world frame, at a time [s]."""
        for region, points in vertices.items():
            if region in self._done & self._still:
                continue
            self._done.add(region)
            path = self._folder / f"{self._names[region]}_step{step:07d}.stl"
            write_stl(path, points, self._triangles[region], f"comotion {region} step {step} time {time!r} s")


def write_stl(path: Path, points: NDArray[np.float64], triangles: NDArray[np.uint32], title: str) -> None:
    """One file; the title's first 80 ASCII characters stand at its beginning."""
    facets = np.zeros(len(triangles), TRIANGLE)
    normals = face_normals(points, triangles.astype(np.int64))
    facets["normal"] = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    facets["corners"] = points[triangles]
    text = title.encode("ascii", "replace")[:HEADER_BYTES].ljust(HEADER_BYTES)
    path.write_bytes(text + np.uint32(len(triangles)).astype("<u4").tobytes() + facets.tobytes())


def _file_names(regions: Mapping[str, object]) -> dict[str, str]:
    """A file name for every region: its own where it can be one, all different."""
    names: dict[str, str] = {}
    for region in regions:
        plain = re.sub(r"[^A-Za-z0-9_.-]", "_", region).lstrip(".") or "region"
        while plain.lower() in {name.lower() for name in names.values()}:
            plain += "_"
        names[region] = plain
    return names
