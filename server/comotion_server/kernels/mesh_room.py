"""Arrays that kernels of meshes work in: what they are, apart from the kernels, which a scene may do without."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.flight import Bodies, Flights


class Work(NamedTuple):
    """Arrays that a query uses; nothing in them means anything before or after."""

    flights: Flights  # of the two bodies
    bodies: Bodies
    states: tuple[np.ndarray, ...]  # x (2,3), v (2,3), R (2,3,3), L (2,3), w (2,3) of both bodies, world; (3,)
    R: np.ndarray  # (3,3) from b's axes to a's
    states_pair: tuple[np.ndarray, ...]  # the same for a pair of triangles on its own
    R_pair: np.ndarray
    nodes: np.ndarray  # (STACK_SIZE,2) int64
    walk: tuple[np.ndarray, ...]  # of the distance


class Directions(NamedTuple):
    """Directions of contact."""

    normal: np.ndarray  # (d,3) unit, from a to b, in the axes of a
    normal_b: np.ndarray  # (d,3) the other way, in the axes of b
    owner: np.ndarray  # (d,) int64 OF_A, OF_B or OF_NONE
    triangle: np.ndarray  # (d,) int64 with that normal; of the owner
    least: np.ndarray  # (d,) least distance of a pair with this direction [m]


class PatchPoints(NamedTuple):
    """Points of contact of one patch; vectors in the axes of a `View`."""

    kind: np.ndarray  # (k,) int64 as in `contacts`
    feature: np.ndarray  # (k,FEATURES) int64
    point_a: np.ndarray  # (k,3) [m]
    point_b: np.ndarray  # (k,3) [m]
    gap: np.ndarray  # (k,) [m]
    place: np.ndarray  # (k,2) in the plane of contact [m]
    order: np.ndarray  # (3 k,) int64 for `hull`


class PatchWork(NamedTuple):
    """Arrays that `manifold` and `gap_of_pair` use; nothing in them means anything before or after."""

    pairs: np.ndarray  # (p,2) int64 triangles of a, of b
    nodes: np.ndarray  # (STACK_SIZE,2) int64 of a walk
    directions: Directions
    points: PatchPoints
    R: np.ndarray  # (3,3) from b's axes to a's
    walk: tuple[np.ndarray, ...]  # of the distance
