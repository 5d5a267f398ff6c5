"""Distance, intersection and overlap of two surface meshes in any pose: for notebooks, tests and other tools.

    from comotion_server.geometry import TriangleMesh, distance
    a = TriangleMesh(vertices, triangles)
    found = distance(a, (R_a, x_a), b, (R_b, x_b))
    found.distance, found.point_a, found.point_b, found.triangle_a, found.triangle_b

A pose is (R, x): the rotation (3, 3) from body to world and the position (3,) of the body's origin [m]. What a mesh
needs to be searched (its tree) is made at its first query and kept as long as the mesh.
"""

from comotion_server.geometry.pair_queries import Closest, Overlap, distance, intersects, penetration
from comotion_server.geometry.pose import PoseError
from comotion_server.meshes import MeshError, TriangleMesh

__all__ = [
    "Closest",
    "MeshError",
    "Overlap",
    "PoseError",
    "TriangleMesh",
    "distance",
    "intersects",
    "penetration",
]
