"""Surface meshes of rigid bodies: reading, repair, health, mass properties, and shapes that are their own meshes."""

from comotion_server.meshes.mass import MassProperties, mass_properties
from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.mesh_file import load_mesh
from comotion_server.meshes.mesh_health import MeshHealth
from comotion_server.meshes.repair import LoadedMesh
from comotion_server.meshes.shapes import box, prism
from comotion_server.meshes.triangle_mesh import TriangleMesh

__all__ = [
    "LoadedMesh",
    "MassProperties",
    "MeshError",
    "MeshHealth",
    "TriangleMesh",
    "box",
    "load_mesh",
    "mass_properties",
    "prism",
]
