"""Contact points as rows of arrays: what patches give, laws answer and held contacts follow."""

from typing import NamedTuple

import numpy as np

from comotion_server.kernels.jit import jit

CORNER_FACE = 0  # vertex of a on a face of b; features: vertex, -1, triangle
FACE_CORNER = 1  # face of a under a vertex of b; features: triangle, -1, vertex
EDGES = 2  # two edges, normal to both; features: both vertices of a's, both of b's, a's x b's along the normal
CROSSING_A = 3  # two edges that cross in the plane of a face of a; features as EDGES, then that triangle
CROSSING_B = 4  # the same in the plane of a face of b
POINTS = 5  # a vertex on a vertex or on an edge, where no plane explains the gap; features as EDGES, a vertex with -1
SMOOTH = 6  # a sphere on a sphere, a plane or a pipe; features: the part of the pipe, then -1

BALL_FACE = 7  # a ball on a face of the other body; features: which ball of its body, triangle (-1: a plane)
BALL_EDGE = 8  # a ball on an edge; features: which ball, both vertices of the edge, both triangles (-1: none) there
BALL_CORNER = 9  # a ball on a corner; features: which ball, vertex
LINE_EDGE = 10  # the middle line of a capsule over an edge; features: -1, both vertices, both triangles
LINE_CORNER = 11  # the same over a corner; features: -1, vertex
CORES = 12  # two round bodies; features: of a and of b, which ball, or -1 where its middle line is met between its ends
PARTS = 13  # beside a cylinder; features: part of a and its number (`body_parts`), the same of b, which crossing

FULL = -1  # in the place of a number: there are more than there is room for
FEATURES = 5  # per contact: indices over all shapes, -1 where there is none


class Contacts(NamedTuple):
    """Points in contact, c rows; world frame, SI. A row stands for the pair of bodies a, b, a the lower row."""

    bodies: np.ndarray  # (c,2) int64 rows a, b
    kind: np.ndarray  # (c,) int64
    feature: np.ndarray  # (c,FEATURES) int64
    normal: np.ndarray  # (c,3) unit, from a to b
    arm_a: np.ndarray  # (c,3) from the centre of a to its point [m]
    arm_b: np.ndarray  # (c,3) from the centre of b to its point [m]
    gap: np.ndarray  # (c,) between the points along the normal [m]


@jit
def new_contacts(capacity):
    """Room for contacts."""
    return Contacts(
        np.empty((capacity, 2), np.int64),
        np.empty(capacity, np.int64),
        np.empty((capacity, FEATURES), np.int64),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
        np.empty((capacity, 3)),
        np.empty(capacity),
    )
