"""Distance, intersection, overlap and contact times of two surface meshes: for notebooks, tests and other tools.

    from comotion_server.geometry import TriangleMesh, distance
    a = TriangleMesh(vertices, triangles)
    found = distance(a, (R_a, x_a), b, (R_b, x_b))
    found.distance, found.point_a, found.point_b, found.triangle_a, found.triangle_b

    from comotion_server.geometry import Motion, time_of_impact
    impact = time_of_impact(a, Motion((R_a, x_a), velocity=v), b, Motion((R_b, x_b)), t_max=1.0)
    impact.status, impact.time, impact.point, impact.normal

A pose is (R, x): the rotation (3, 3) from body to world and the position (3,) of the body's origin [m]. What a mesh
needs to be searched (its tree) is made at its first query and kept as long as the mesh.
"""

from comotion_server.geometry.contact_time import TimeOfImpact, time_of_impact
from comotion_server.geometry.motion import Motion, MotionError
from comotion_server.geometry.pair_queries import Closest, Overlap, distance, intersects, penetration
from comotion_server.geometry.pose import PoseError
from comotion_server.meshes import MeshError, TriangleMesh

__all__ = [
    "Closest",
    "MeshError",
    "Motion",
    "MotionError",
    "Overlap",
    "PoseError",
    "TimeOfImpact",
    "TriangleMesh",
    "distance",
    "intersects",
    "penetration",
    "time_of_impact",
]
