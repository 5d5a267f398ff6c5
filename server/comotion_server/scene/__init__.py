"""Scenes: reading and checking scene files, and the checked scene itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from comotion_server.scene.curved_shapes import Capsule, Curved, Cylinder, Pipe, Sphere
from comotion_server.scene.model import Body, Collisions, Fixed, Free, Plane, Prescribed, Scene
from comotion_server.scene.pose_table import PoseTable
from comotion_server.scene.scene_errors import Problem, SceneError

if TYPE_CHECKING:
    from comotion_server.scene.read_scene import check_scene, load_scene

__all__ = [
    "Body",
    "Capsule",
    "Collisions",
    "Curved",
    "Cylinder",
    "Fixed",
    "Free",
    "Pipe",
    "Plane",
    "PoseTable",
    "Prescribed",
    "Problem",
    "Scene",
    "SceneError",
    "Sphere",
    "check_scene",
    "load_scene",
]


def __getattr__(name: str) -> Any:
    """Names that need pydantic, which takes 0.2 s to import."""
    if name in ("load_scene", "check_scene"):
        from comotion_server.scene import read_scene

        return getattr(read_scene, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
