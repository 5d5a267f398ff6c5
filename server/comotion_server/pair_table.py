"""The pairs that may come close within the step, and what is remembered of each (P9, P14).

A pair is kept while the bounding spheres of its bodies may meet before the step ends. Speeds are bounded with some
room; only when an impact makes a body faster than its bound is the table made again. A pair found far apart is asked
for its distance again only when the two bodies have moved, relative to each other, by what it had to spare. If they
cannot do that before the step ends, the pair is out of play: nobody asks where its bodies are on the way.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.broad_phase import pairs_in_reach
from comotion_server.kernels.closeness import measure, speed_bounds
from comotion_server.kernels.motion_budget import bounds_left, note_asked
from comotion_server.kernels.penetration import overlap_depth
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.pair_threads import PairThreads
from comotion_server.world import World

Array = NDArray[np.float64]

LOOK_AHEAD = 2.0  # steps: pairs are measured so early that one that may collide has a previous distance (P9)
ROOM = 1.5  # factor of speed that a body may gain before the table is made again; larger: more far pairs are measured
FURTHER = 3.0  # times the reach to which a pair is asked for its distance; larger: dearer questions, but fewer


class LastApart(NamedTuple):
    """Memory of each pair: k rows."""

    time: Array  # (k,) local time of the last measurement [s]; nan: none
    distance: Array  # (k,) at that time [m]
    point_a: Array  # (k,3) closest point of a when last apart, its body frame [m]
    point_b: Array  # (k,3) closest point of b when last apart, its body frame [m]
    normal: Array  # (k,3) unit, from a to b, world frame, when last apart
    triangles: NDArray[np.int64]  # (k,2) that held the closest points when last apart, within their shapes
    witness: NDArray[np.int64]  # (k,2) closest triangles now: where the next search starts; -1: none
    overlapping: NDArray[np.bool_]  # (k,) at the last measurement
    bound: Array  # (k,) of the distance when last asked [m]; nan: never
    turn: Array  # (k,3,3) attitude of b seen from a then
    offset: Array  # (k,3) place of b seen from a then [m]

    @classmethod
    def of(cls, count: int) -> Self:
        """Nothing remembered of `count` pairs."""
        return cls(
            time=np.full(count, np.nan),
            distance=np.zeros(count),
            point_a=np.zeros((count, 3)),
            point_b=np.zeros((count, 3)),
            normal=np.zeros((count, 3)),
            triangles=np.full((count, 2), -1, dtype=np.int64),
            witness=np.full((count, 2), -1, dtype=np.int64),
            overlapping=np.zeros(count, dtype=np.bool_),
            bound=np.full(count, np.nan),
            turn=np.zeros((count, 3, 3)),
            offset=np.zeros((count, 3)),
        )

    def copy(self) -> Self:
        """The same numbers in arrays of their own."""
        return type(self)(**{name: column.copy() for name, column in self._asdict().items()})


class Closeness(NamedTuple):
    """One measurement of all pairs: k rows, world frame."""

    distance: Array  # (k,) [m]; zero: the surfaces intersect
    approach: Array  # (k,) [m/s]; positive: coming closer
    point_a: Array  # (k,3) [m]
    point_b: Array  # (k,3) [m]
    normal: Array  # (k,3) unit, from a to b


class PairTable:
    """Candidate pairs of a world's bodies, by rows in the order of names."""

    def __init__(self, world: World) -> None:
        bodies = world.scene.bodies
        self.world = world
        self.store = MeshStore.build([body.collision_mesh for body in bodies])
        self.shape_of_body = self.store.shape_of_mesh
        self.radius = 0.5 * np.array([body.collision_mesh.size for body in bodies])
        self.pairs = np.empty((0, 2), dtype=np.int64)
        self.last = LastApart.of(0)
        self._threads = PairThreads()
        self._bound = np.zeros(world.body_count)  # of the speed of any point of each body [m/s]
        self._reach = np.zeros(world.body_count)  # how far its points may come [m]
        self._floor = np.empty(0)  # (k,) of the distance until the step ends [m]
        self.bodies_in_play = np.empty(0, dtype=np.int64)  # rows of those that some pair in play needs to have advanced

    def checkpoint(self) -> tuple[NDArray[np.int64], LastApart]:
        """The pairs and what is remembered of them."""
        return self.pairs.copy(), self.last.copy()

    def restore(self, kept: tuple[NDArray[np.int64], LastApart]) -> None:
        """Goes back to a checkpoint; the next step begins with `refresh`."""
        self.pairs, self.last = kept[0].copy(), kept[1].copy()

    def set_clock_back(self, seconds: float) -> None:
        """Keeps the memory true when the local clock is set back."""
        self.last.time[:] -= seconds

    def refresh(self, now: float, end: float) -> None:
        """Finds the pairs that may meet from local time `now` to `end` [s]; pairs known before keep their memory."""
        world = self.world
        speed_bounds(world.flights, world.bodies, end, self.radius, self._bound)
        self._bound *= ROOM
        self._reach = self._bound * ((end - now) * LOOK_AHEAD)
        pairs = np.empty((max(64, 2 * len(self.pairs)), 2), dtype=np.int64)
        arguments = (world.state.position, self.radius, self._reach, world.bodies.reacts)
        count = pairs_in_reach(*arguments, pairs)
        if count > len(pairs):
            pairs = np.empty((count, 2), dtype=np.int64)
            pairs_in_reach(*arguments, pairs)
        self._take_over(pairs[:count].copy())
        self._floor = self._bounds_left(self._bound * (end - now))
        in_play = self.pairs[self._floor < self._pair_reach()]
        self.bodies_in_play = np.unique(in_play)

    def _pair_reach(self) -> Array:
        """Distance (k,) [m] from which on a pair cannot come within the tolerance in the time looked ahead."""
        gap_allowed = self.world.scene.collisions.tolerance * self.smaller_size
        reach: Array = self._reach[self.pairs[:, 0]] + self._reach[self.pairs[:, 1]] + 2.0 * gap_allowed
        return reach

    def _bounds_left(self, motion: Array) -> Array:
        """Proven lower bounds (k,) of the distances after a `motion` (n,) [m] of the bodies from where they are."""
        state, last, left = self.world.state, self.last, np.empty(len(self.pairs))
        known = last.bound, last.turn, last.offset
        bounds_left(self.pairs, state.position, state.rotation, self.radius, *known, motion, left)
        return left

    def _take_over(self, pairs: NDArray[np.int64]) -> None:
        """Replaces the pairs; rows that stay keep what is remembered of them."""
        if np.array_equal(pairs, self.pairs):
            return
        last = LastApart.of(len(pairs))
        _, old, new = np.intersect1d(self._keys(self.pairs), self._keys(pairs), assume_unique=True, return_indices=True)
        for before, after in zip(self.last, last, strict=True):
            after[new] = before[old]
        self.pairs, self.last = pairs, last

    def _keys(self, pairs: NDArray[np.int64]) -> NDArray[np.int64]:
        return pairs[:, 0] * self.world.body_count + pairs[:, 1]

    @property
    def smaller_size(self) -> Array:
        """Diameter [m] of the smaller body of each pair (k,), which tolerances are relative to."""
        return 2.0 * np.minimum(self.radius[self.pairs[:, 0]], self.radius[self.pairs[:, 1]])

    def outruns(self, bodies: tuple[int, int], end: float) -> bool:
        """Whether an impact made one of these bodies faster than the table allows for."""
        bound = np.empty_like(self._bound)
        speed_bounds(self.world.flights, self.world.bodies, end, self.radius, bound)
        return any(bound[i] > self._bound[i] for i in bodies)

    def measure(self, now: float, tolerance: float) -> Closeness:
        """Distances and approach speeds of all pairs at local time `now`; `tolerance` is relative to the smaller."""
        world, pairs = self.world, self.pairs
        x, v, R, _, w = world.state.arrays
        count = len(pairs)
        gap_allowed = tolerance * self.smaller_size
        reach = self._pair_reach()
        distance, approach = np.empty(count), np.empty(count)
        p, q, n = (np.zeros((count, 3)) for _ in range(3))
        self._ask(reach, distance, p, q, n)
        measure(pairs, now, gap_allowed, x, v, R, w, reach, distance, p, q, n, approach, self.last)
        return Closeness(distance, approach, p, q, n)

    def _ask(self, reach: Array, distance: Array, p: Array, q: Array, n: Array) -> None:
        """Distances (k,) and, of pairs within `reach` [m], closest points p, q and normals n (k,3), all filled in.

        A pair that must be beyond its reach, as little as it has moved, is not asked: it gets a bound, and no points.
        """
        x, R, last = self.world.state.position, self.world.state.rotation, self.last
        # bodies out of play have not been advanced: what is left by their present poses is not to be looked at
        in_play = self._floor < reach
        distance[:] = np.where(in_play, self._bounds_left(np.zeros(self.world.body_count)), self._floor)
        rows = np.flatnonzero(in_play & ~(distance >= reach))
        self._threads.closest_points(
            rows, self.store.arrays, self.shape_of_body, x, R, self.pairs, FURTHER * reach, last.witness,
            distance, p, q, n,
        )  # fmt: skip
        note_asked(rows, self.pairs, x, R, distance, last.bound, last.turn, last.offset)

    def overlap_depth(self, k: int, normal: Array) -> float:
        """Depth [m] of an intersecting pair along the normal (3,) of its last state apart (P8)."""
        a, b = self.pairs[k]
        x, R, shape = self.world.state.position, self.world.state.rotation, self.shape_of_body
        return float(overlap_depth(self.store.arrays, shape[a], shape[b], x[a], R[a], x[b], R[b], normal))
