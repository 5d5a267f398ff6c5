"""Where the members of an array are."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from comotion_server.quaternions import quaternion_product
from comotion_server.scene.csv_table import read_poses

if TYPE_CHECKING:
    from pathlib import Path

    from comotion_server.scene.tables import GridTable, PlaceTable, RandomTable

Floats = npt.NDArray[np.float64]

TRIES = 2000
"""Random positions tried for one member before the field counts as full."""


class PlacementError(ValueError):
    """Members that do not fit; the message says why in one line."""


def member_poses(place: PlaceTable, attitude: Floats, vertices: Floats, folder: Path) -> tuple[Floats, Floats]:
    """Positions [m], shape (n, 3), and unit quaternions, shape (n, 4), of an array's members.

    Args:
        place: how to place them.
        attitude: quaternion that every member has before it is turned by its place.
        vertices: of a member [m], shape (n, 3), about its centre.
        folder: that file names are relative to.

    Raises:
        PlacementError: a random field does not fit.
        SceneError: bad rows in a file of poses.
    """
    if place.grid is not None:
        positions = _grid(place.grid)
        turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(positions), 1))
    elif place.random is not None:
        positions, turns = _random_field(place.random, vertices @ _rotation(attitude).T)
    else:
        positions, turns = read_poses(folder / str(place.poses))
    return positions, np.array([quaternion_product(turn, attitude) for turn in turns])


def member_count(place: PlaceTable) -> int:
    """Number of members that are asked for; 0 where a file decides."""
    if place.grid is not None:
        return math.prod(place.grid.counts)
    return place.random.count if place.random is not None else 0


def _grid(grid: GridTable) -> Floats:
    nx, ny, nz = grid.counts
    index = np.array([(i, j, k) for k in range(nz) for j in range(ny) for i in range(nx)], dtype=np.float64)
    positions: Floats = np.array(grid.origin) + index * np.array(grid.spacing)
    return positions


def _random_field(field: RandomTable, vertices: Floats) -> tuple[Floats, Floats]:
    """Random sequential placing: a position is kept when its bounding circle (sphere) is clear of all before.

    In a plane (`low` and `high` at the same z) circles about the z axis do, in space spheres. A grid of cells as large
    as the least distance leaves only neighbouring cells to look at.
    """
    low, high = np.array(field.low), np.array(field.high)
    axes = 2 if low[2] == high[2] else 3
    radius = float(np.linalg.norm(vertices[:, :axes], axis=1).max())
    apart = 2.0 * radius + field.gap
    margin = np.array([radius, radius, radius if axes == 3 else 0.0])
    low, room = low + margin, high - low - 2.0 * margin
    if (room < 0.0).any():
        around = "circle" if axes == 2 else "sphere"
        raise PlacementError(
            f"no member fits: 'low' and 'high' must be {2 * radius:.6g} m apart for the bounding {around} of one member"
        )
    random = np.random.Generator(np.random.PCG64(field.seed))
    cells: dict[tuple[int, ...], list[Floats]] = {}
    positions: list[Floats] = []
    for _ in range(field.count):
        for _ in range(TRIES):
            position = low + room * random.random(3)
            cell = tuple(int(c) for c in (position[:axes] - low[:axes]) // apart)
            if _clear(position, cell, cells, apart):
                cells.setdefault(cell, []).append(position)
                positions.append(position)
                break
        else:
            raise PlacementError(
                f"only {len(positions)} of {field.count} members found a place at {apart:.6g} m from centre to centre; "
                "take fewer members, a smaller gap or a larger box"
            )
    angles = 2.0 * np.pi * random.random(field.count) * (field.turn == "z")
    turns = np.stack((np.cos(angles / 2), 0 * angles, 0 * angles, np.sin(angles / 2)), axis=1)
    return np.array(positions), turns


def _clear(position: Floats, cell: tuple[int, ...], cells: dict[tuple[int, ...], list[Floats]], apart: float) -> bool:
    for step in itertools.product((-1, 0, 1), repeat=len(cell)):
        for other in cells.get(tuple(c + s for c, s in zip(cell, step, strict=True)), ()):
            if math.dist(position, other) < apart:
                return False
    return True


def _rotation(q: Floats) -> Floats:
    """Rotation matrix of a unit quaternion (w, x, y, z), body to world."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
