"""What the kernels need of one or two meshes, made once and kept as long as the meshes are."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from comotion_server.meshes.mesh_store import joined, prepared

if TYPE_CHECKING:
    from comotion_server.kernels.mesh_arrays import MeshArrays
    from comotion_server.meshes import TriangleMesh

_alone: WeakKeyDictionary[TriangleMesh, MeshArrays] = WeakKeyDictionary()
_together: WeakKeyDictionary[TriangleMesh, WeakKeyDictionary[TriangleMesh, MeshArrays]] = WeakKeyDictionary()


def arrays_of(a: TriangleMesh, b: TriangleMesh) -> tuple[MeshArrays, int]:
    """The bundle of two meshes, and which of its shapes is b; a is shape 0, and b too if it is the same mesh."""
    if a is b:
        return _arrays(a), 0
    partners = _together.setdefault(a, WeakKeyDictionary())
    if b not in partners:
        partners[b] = joined([_arrays(a), _arrays(b)])
    return partners[b], 1


def _arrays(mesh: TriangleMesh) -> MeshArrays:
    if mesh not in _alone:
        _alone[mesh] = joined([prepared(mesh)])
    return _alone[mesh]
