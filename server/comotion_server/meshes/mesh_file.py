"""Mesh files: STL, OBJ, PLY, OFF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.repair import LoadedMesh, repair
from comotion_server.meshes.stl_file import read_stl

FORMATS = (".stl", ".obj", ".ply", ".off")

MAX_FACETS = 50_000_000
"""More than this is a mistake or an attack; it would need over 20 GB to read."""


def load_mesh(path: str | Path) -> LoadedMesh:
    """A mesh file, welded, cleaned and oriented, in the coordinates of the file [m].

    Raises:
        MeshError: the file cannot be read, or holds no usable facet; the message does not repeat the file's name.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise MeshError(f"unknown kind of mesh file '{path.name}'; allowed: {', '.join(FORMATS)}")
    if path.is_dir():
        raise MeshError("cannot be read: it is a folder")
    try:
        return repair(*_read(path))
    except OSError as error:
        raise MeshError(f"cannot be read: {error.strerror}") from None


def _read(path: Path) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    limit = MAX_FACETS * 50
    if path.stat().st_size > limit:
        raise MeshError(f"the file has {path.stat().st_size} bytes; at most {limit} are read")
    if path.suffix.lower() == ".stl":
        corners = read_stl(path).reshape(-1, 3)
        return corners, np.arange(len(corners)).reshape(-1, 3)
    return _read_by_trimesh(path)


def _read_by_trimesh(path: Path) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    import trimesh

    try:
        mesh = trimesh.load_mesh(path, process=False)
        points, facets = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    except OSError:
        raise
    except Exception as error:  # noqa: BLE001 - trimesh raises whatever its parsers stumble upon
        raise MeshError(f"not a readable {path.suffix[1:].upper()} file ({type(error).__name__}: {error})") from None
    if points.ndim != 2 or points.shape[1] != 3 or facets.ndim != 2 or facets.shape[1] != 3:
        raise MeshError("there is no facet in the file")
    if len(facets) and not (facets.min() >= 0 and facets.max() < len(points)):
        raise MeshError(f"a facet refers to vertex {int(facets.max()) + 1}, but there are {len(points)}")
    return np.ascontiguousarray(points), facets
