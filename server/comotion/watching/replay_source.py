"""A recorded run as the page sees it: all states at once, the page plays them."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.body_shapes import body_shapes
from comotion.outputs.surface import Surface
from comotion.watching.page_message import page_message
from comotion.watching.scene_message import scene_message
from comotion_protocol.messages import Region, RegionBody

IMPACTS_SHOWN = 20_000  # the largest ones


class ReplaySource:
    """Reads the folder of `comotion run --out`; see `LiveSource` for the interface."""

    def __init__(self, folder: Path) -> None:
        """Read `bodies.vtkhdf` and `impacts.csv`.

        Raises:
            OSError, KeyError: the folder holds no such series.
        """
        import h5py

        with h5py.File(folder / "bodies.vtkhdf") as file:
            root, own = file["VTKHDF"], file["comotion"]
            times, poses, scales = root["Steps/Values"][:], own["poses"][:], own["scales"][:]
            names, motion = own["names"].asstr()[:].tolist(), own["motion"].asstr()[:].tolist()
            level = own.attrs.get("water_level")
            surface = _surface(names, root["Points"], root["Polygons/Connectivity"][:], own["body_of_point"][:])
        shapes = body_shapes(surface, poses[0])
        kinds = dict(zip(names, motion, strict=True))
        water = None if level is None else float(level)
        origin = np.round(poses[0, :, :3].mean(axis=0)) if len(names) else np.zeros(3)
        arrays = {
            "times": times.astype("<f8"),
            "poses": np.concatenate([poses[:, :, :3] - origin, poses[:, :, 3:]], axis=2).astype("<f4"),
            "scales": scales.astype("<f4"),
            "impacts": _impacts(folder / "impacts.csv"),
        }
        self._first = [
            scene_message(folder.resolve().name, "replay", shapes, kinds, water),
            page_message({"kind": "film", "origin": origin.tolist()}, arrays),
        ]

    def enter(self) -> list[bytes]:
        """A page opens: all there is."""
        return self._first

    def leave(self) -> None:
        """A page closes."""

    def messages(self, seen: int) -> tuple[int, list[bytes]]:
        """Nothing more comes."""
        return seen, []


def _surface(names: list[str], points: Any, connectivity: NDArray[Any], body_of_point: NDArray[Any]) -> Surface:
    """The surface of the first state, each body as a region of its own."""
    triangles = connectivity.reshape(-1, 3)
    first = points[: len(body_of_point)]
    regions, vertices, faces = [], {}, {}
    for row, name in enumerate(names):
        rows = np.flatnonzero(body_of_point == row)  # a body's points lie together
        own = RegionBody(name=name, first_vertex=0, vertex_count=len(rows))
        regions.append(Region(name=name, vertex_count=len(rows), triangle_count=0, bodies=(own,)))
        vertices[name] = first[rows]
        faces[name] = (triangles[body_of_point[triangles[:, 0]] == row] - rows[0]).astype(np.uint32)
    return Surface(regions, vertices, faces)


def _impacts(path: Path) -> NDArray[np.float64]:
    """Time [s], point [m] and impulse [N s] of the largest impacts, shape (n, 5), in the order of time."""
    with path.open(encoding="utf-8") as file:
        names = ("time [s]", "x [m]", "y [m]", "z [m]", "impulse [N s]")
        rows = [[float(row[name]) for name in names] for row in csv.DictReader(file)]
    found = np.array(rows, dtype="<f8").reshape(-1, 5)
    largest = found[np.argsort(found[:, 4])[-IMPACTS_SHOWN:]]
    return largest[np.argsort(largest[:, 0], kind="stable")]
