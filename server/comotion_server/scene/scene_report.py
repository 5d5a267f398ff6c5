"""What is in a scene, as plain data: for people to read before they start."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from comotion_server.scene.curved_shapes import Curved
from comotion_server.scene.model import Body, Fixed, Free, Plane, Scene

if TYPE_CHECKING:
    from comotion_server.meshes import TriangleMesh
    from comotion_server.meshes.mesh_health import MeshHealth
    from comotion_server.scene.bodies import MadeBody


@dataclass(frozen=True)
class BodyReport:
    """One body.

    Attributes:
        name: of the body.
        region: of geometry exchange.
        motion: "free", "fixed" or "prescribed".
        shape: what the scene calls it.
        mass: [kg], or None where there is none.
        principal_moments: of inertia about the centre of mass [kg m2], ascending, or None.
        volume: [m3], or None for a surface that encloses nothing.
        position: centre of mass [m], world frame.
        size: diameter [m] of the bounding sphere about the centre of mass; None for a plane.
        vertices: of its mesh.
        triangles: of its mesh.
        health: of its mesh; None for a plane and what is exactly round.
        frame: what the scene calls its frame, if it has one.
        frame_triangles: of the frame; 0 without one.
        clearance: least distance [m] between its surface and its frame's; None without one.
        notes: what is worth knowing and no mistake.
    """

    name: str
    region: str
    motion: str
    shape: str
    mass: float | None
    principal_moments: tuple[float, float, float] | None
    volume: float | None
    position: tuple[float, float, float]
    size: float | None
    vertices: int
    triangles: int
    health: MeshHealth | None
    frame: str | None
    frame_triangles: int
    clearance: float | None
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self) | {"health": self.health and self.health.as_dict()}


@dataclass(frozen=True)
class RegionReport:
    """One region of geometry exchange: its name and how much is in it."""

    name: str
    bodies: int
    vertices: int
    triangles: int


@dataclass(frozen=True)
class SceneReport:
    """A scene: its name, its regions and its bodies, in the order of their names."""

    name: str
    regions: tuple[RegionReport, ...]
    bodies: tuple[BodyReport, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "name": self.name,
            "regions": [asdict(region) for region in self.regions],
            "bodies": [body.as_dict() for body in self.bodies],
        }


def report_of(scene: Scene, made: list[MadeBody]) -> SceneReport:
    """The report of a scene whose bodies were made so."""
    regions = tuple(
        RegionReport(
            name,
            len(bodies),
            sum(len(body.surface.vertices) for body in bodies),
            sum(len(body.surface.triangles) for body in bodies),
        )
        for name, bodies in scene.regions.items()
    )
    bodies = tuple(_body_report(item) for item in sorted(made, key=lambda item: item.body.name))
    return SceneReport(scene.name, regions, bodies)


def _body_report(made: MadeBody) -> BodyReport:
    body, solid, frame = made.body, made.solid, made.frame
    moments = None if np.isnan(body.inertia).any() else np.linalg.eigvalsh(body.inertia)
    return BodyReport(
        name=body.name,
        region=body.region,
        motion=_motion_word(body),
        shape=solid.label,
        mass=None if np.isnan(body.mass) else body.mass,
        principal_moments=None if moments is None else _triple(moments),
        volume=None if np.isnan(solid.volume) else solid.volume,
        position=_triple(body.position),
        size=None if isinstance(body.shape, Plane) else _size(body.shape),
        vertices=0 if isinstance(body.shape, Plane) else len(body.surface.vertices),
        triangles=0 if isinstance(body.shape, Plane) else len(body.surface.triangles),
        health=solid.health,
        frame=None if frame is None else frame.label,
        frame_triangles=0 if frame is None else len(frame.mesh.triangles),
        clearance=None if frame is None else frame.clearance,
        notes=_notes(made),
    )


def _size(shape: TriangleMesh | Curved) -> float:
    return 2.0 * shape.radius_about_centre if isinstance(shape, Curved) else shape.size


def _motion_word(body: Body) -> str:
    if isinstance(body.motion, Free):
        return "free"
    return "fixed" if isinstance(body.motion, Fixed) else "prescribed"


def _notes(made: MadeBody) -> tuple[str, ...]:
    if not made.solid.flaws:
        return ()
    what = ", ".join(made.solid.flaws)
    return (f"not a closed surface: {what}; its position is its centre of area",)


def _triple(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
