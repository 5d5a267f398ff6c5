"""Who may meet whom: every body has a room of its own, a sphere somewhat larger than itself that it stays in a while.

Two bodies can only meet while their rooms do. A body that comes to the end of its room gets a new one around it: only
then neighbours are looked for, in the 27 cells about it, so that the work follows what moves. Cells are as wide as the
largest room and hashed (Teschner, Heidelberger, Mueller, Pomeranets, Gross 2003, "Optimized spatial hashing for
collision detection of deformable objects"): space has no end, and two cells that share a list cost time alone. The
few bodies that are much larger than most (a hull, banks, a container, a plane) are in no cell and compared with all.
"""

from math import floor, inf
from typing import NamedTuple

import numpy as np

from comotion_server.kernels.flight import motion_of
from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.motion_bounds import covering_time
from comotion_server.kernels.vectors import along, dot, length, row, sub

ROOM = 0.3  # of a body's radius: what its room is larger; more: fewer new rooms, more neighbours
LEAD = 0.6  # of that: how far a new room lies ahead of the body
OFF_GRID = -1
LARGE = 4.0  # times the median radius: bodies above it are compared with all, if they are few
FEW, SHARE = 8, 64  # how many large bodies there may be at least, and one of how many bodies


class Cells(NamedTuple):
    """Rooms of n bodies, and the cells they are in."""

    width: np.ndarray  # (1,) [m]
    head: np.ndarray  # (buckets,) int64 first body of each list; buckets is a power of two
    next: np.ndarray  # (n,) int64 next body in the list
    previous: np.ndarray  # (n,) int64
    bucket: np.ndarray  # (n,) int64, OFF_GRID for large bodies
    large: np.ndarray  # (l,) int64 bodies that are compared with all
    centre: np.ndarray  # (n,3) of the rooms, world [m]
    room: np.ndarray  # (n,) their radii [m]
    spare: np.ndarray  # (n,) how far the body may be from the centre of its room [m]
    seen: np.ndarray  # (n + 1,) int64 when a body was last noted as a neighbour; the last one counts


@lean_jit
def _bucket(cells, x, y, z):
    return ((x * 73856093) ^ (y * 19349663) ^ (z * 83492791)) & (len(cells.head) - 1)


@lean_jit
def cell_of(cells, i):
    """The cell (x, y, z) in which the room of body i has its centre."""
    c, width = row(cells.centre, i), cells.width[0]
    return floor(c[0] / width), floor(c[1] / width), floor(c[2] / width)


@lean_jit
def _leave(cells, i):
    after, before, bucket = cells.next[i], cells.previous[i], cells.bucket[i]
    if before >= 0:
        cells.next[before] = after
    elif cells.head[bucket] == i:
        cells.head[bucket] = after
    if after >= 0:
        cells.previous[after] = before


@lean_jit
def _enter(cells, i):
    x, y, z = cell_of(cells, i)
    bucket = _bucket(cells, x, y, z)
    after = cells.head[bucket]
    cells.bucket[i], cells.next[i], cells.previous[i] = bucket, after, -1
    cells.head[bucket] = i
    if after >= 0:
        cells.previous[after] = i


@lean_jit
def is_amid(cells, i, x):
    """Whether body i at x (3,) has more than half of the way to the border of its room left."""
    D = sub(x, row(cells.centre, i))
    return 4.0 * dot(D, D) < cells.spare[i] * cells.spare[i]


@lean_jit
def make_room(cells, i, x, v):
    """A new room for body i, whose centre is at x (3,) [m] and moves at v (3,) [m/s]."""
    speed = length(v)
    ahead = LEAD * cells.spare[i] / speed if speed > 0.0 else 0.0
    cells.centre[i] = along(x, ahead, v)
    if cells.bucket[i] != OFF_GRID:
        _leave(cells, i)
        _enter(cells, i)


@lean_jit
def rooms_meet(cells, i, j):
    """Whether the rooms of two bodies overlap."""
    D, far = sub(row(cells.centre, i), row(cells.centre, j)), cells.room[i] + cells.room[j]
    return dot(D, D) <= far * far


@lean_jit
def leaving_time(cells, flights, i, time):
    """Until when [s] body i surely stays in its room, from local `time` on."""
    if not cells.room[i] < inf:
        return inf
    (x, v), a = motion_of(flights, i, time), row(flights.acceleration, i)
    D, spare = sub(x, row(cells.centre, i)), cells.spare[i]
    if a[0] != 0.0 or a[1] != 0.0 or a[2] != 0.0:
        return time + covering_time(spare - length(D), length(v), length(a))
    square, slope = dot(v, v), dot(D, v)
    left = spare * spare - dot(D, D)
    if square == 0.0:
        return inf
    if left <= 0.0:
        return time
    return time + left / (slope + np.sqrt(slope * slope + square * left))


@lean_jit
def neighbours(cells, i, found):
    """The bodies whose rooms may meet that of body i, each once and without i, to `found` (n,); returns how many."""
    count, tick = 0, cells.seen[-1] + 1
    cells.seen[-1] = tick
    cells.seen[i] = tick
    if cells.bucket[i] == OFF_GRID:
        for j in range(len(cells.room)):
            if j != i and rooms_meet(cells, i, j):
                cells.seen[j] = tick
                found[count] = j
                count += 1
        return count
    for j in cells.large:
        if rooms_meet(cells, i, j):
            cells.seen[j] = tick
            found[count] = j
            count += 1
    x, y, z = cell_of(cells, i)
    for k in range(27):
        j = cells.head[_bucket(cells, x + k % 3 - 1, y + k // 3 % 3 - 1, z + k // 9 - 1)]
        while j >= 0:
            if cells.seen[j] != tick and rooms_meet(cells, i, j):
                cells.seen[j] = tick
                found[count] = j
                count += 1
            j = cells.next[j]
    return count


@jit
def large_bodies(radius):
    """Which bodies (n,) are so large, and so few, that they are better compared with all others."""
    n = len(radius)
    order = np.sort(radius)
    bound = LARGE * order[n // 2]
    while bound < inf:
        large = radius > bound
        if large.sum() <= max(FEW, n // SHARE):
            return large
        bound *= 2.0
    return radius == inf


@jit
def new_cells(radius, x):
    """Rooms about bodies of some radii (n,) at x (n,3), inf for planes."""
    n = len(radius)
    large = large_bodies(radius)
    buckets = 2
    while buckets < 2 * n:
        buckets *= 2
    bucket = np.full(n, OFF_GRID)
    spare = ROOM * radius
    widest = 0.0
    for i in range(n):
        if not large[i]:
            widest = max(widest, radius[i])
    cells = Cells(
        np.full(1, max(2.0 * (1.0 + ROOM) * widest, 1e-300)),
        np.full(buckets, -1),
        np.full(n, -1),
        np.full(n, -1),
        bucket,
        np.flatnonzero(large),
        x.copy(),
        radius + spare,
        spare,
        np.zeros(n + 1, np.int64),
    )
    for i in range(n):
        if not large[i]:
            _enter(cells, i)
    return cells
