"""The paper's criteria for near-parallel contacts (P12), judged by the faces that count at the contact points (P13)."""

import numpy as np

from comotion_server.contact_response import Touch
from comotion_server.kernels.features import contact_features, edge_cosine
from comotion_server.pair_table import PairTable
from comotion_server.scene import Collisions


class ParallelCriteria:
    """Whether faces, or an edge and a face, lie so flat on each other that the impulse must not turn the bodies."""

    def __init__(self, table: PairTable, settings: Collisions) -> None:
        self._table = table
        self._face, self._edge = settings.parallel_face, settings.parallel_edge

    def met(self, k: int, touch: Touch) -> bool:
        """For pair k of the table, touching as given."""
        table, state = self._table, self._table.world.state
        meshes, triangles = table.store.arrays, table.last.triangles[k]
        sides = []
        for body, point, direction, triangle in (
            (touch.a, touch.point_a, touch.normal, triangles[0]),
            (touch.b, touch.point_b, -touch.normal, triangles[1]),
        ):
            shape = table.shape_of_body[body]
            place = (meshes, shape, state.position[body], state.rotation[body], triangle, point)
            face = np.empty(3)
            contact_features(*place, direction, face)
            sides.append((place, face))
        (place_a, face_a), (place_b, face_b) = sides
        if abs(float(face_a @ face_b)) > self._face:
            return True
        return bool(min(edge_cosine(*place_a, face_b), edge_cosine(*place_b, face_a)) < self._edge)
