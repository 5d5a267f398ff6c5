"""A scene as the simulation takes it: checked, arrays expanded, bodies in the order of their names."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from collections.abc import Mapping

    from comotion_server.meshes import TriangleMesh
    from comotion_server.scene.pose_table import PoseTable

Floats = npt.NDArray[np.float64]
Locks = tuple[bool, bool, bool, bool, bool, bool]


@dataclass(frozen=True, eq=False)
class Free:
    """Moved by forces and impacts.

    Attributes:
        locked: along x, y, z and about x, y, z, world axes; rotation is locked about none, two or all three.
        reacts: whether impacts change its motion (P20: a body that pushes and is not pushed).
        thrust: constant force at the centre of mass [N], shape (3,), world frame.
    """

    locked: Locks = (False,) * 6
    reacts: bool = True
    thrust: Floats = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Fixed:
    """Never moves."""


@dataclass(frozen=True, eq=False)
class Prescribed:
    """Moves as told, whatever it hits.

    Attributes:
        velocity: of the centre of mass [m/s], shape (3,), world frame, constant; zero when there is a table.
        angular_velocity: [rad/s], shape (3,), world frame, constant; zero when there is a table.
        table: poses over time instead.
    """

    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    angular_velocity: Floats = field(default_factory=lambda: np.zeros(3))
    table: PoseTable | None = None


@dataclass(frozen=True, eq=False)
class Body:
    """One rigid body at time 0.

    Attributes:
        name: unique in the scene.
        region: the region of geometry exchange that its vertices belong to.
        motion: who moves it.
        mass: [kg]; nan for a fixed or prescribed body that was given none.
        inertia: about the centre of mass, body frame [kg m2], shape (3, 3); nan where the mass is.
        mesh: surface, vertices [m] about the centre of mass, body frame. Bodies alike share one object.
        position: centre of mass [m], shape (3,), world frame.
        quaternion: (w, x, y, z), body to world, of unit length.
        velocity: of the centre of mass [m/s], shape (3,), world frame.
        angular_velocity: [rad/s], shape (3,), world frame.
        material: what `[[material]]` pairs refer to, if anything.
    """

    name: str
    region: str
    motion: Free | Fixed | Prescribed
    mass: float
    inertia: Floats
    mesh: TriangleMesh
    position: Floats = field(default_factory=lambda: np.zeros(3))
    quaternion: Floats = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    angular_velocity: Floats = field(default_factory=lambda: np.zeros(3))
    material: str | None = None


@dataclass(frozen=True)
class Collisions:
    """How collisions are found and answered.

    Attributes:
        rule: the paper's queue to the letter, or read the other way: advance, then respond (P9, P10).
        restitution: where no pair of materials says otherwise (P11).
        substeps: N of the paper's queue (P10).
        parallel: the paper's criteria for near-parallel contacts, or none (P12).
        parallel_face: |cos| of two faces' normals from which they count as parallel (P12).
        parallel_edge: |cos| of an edge and a face's normal up to which they count as parallel (P12).
        tolerance: gap taken as contact by `paper-advance`, relative to the smaller body's size.
        budget: most responses in one step.
        material_pairs: restitution of two materials.
    """

    rule: Literal["paper", "paper-advance"] = "paper-advance"
    restitution: float = 0.3
    substeps: int = 2
    parallel: Literal["paper", "off"] = "paper"
    parallel_face: float = 0.999
    parallel_edge: float = 0.01
    tolerance: float = 1e-6
    budget: int = 10_000
    material_pairs: Mapping[frozenset[str], float] = field(default_factory=dict)

    def restitution_between(self, a: Body, b: Body) -> float:
        """Coefficient of restitution of two bodies: their materials' pair if there is one, else the default."""
        if a.material is None or b.material is None:
            return self.restitution
        return self.material_pairs.get(frozenset((a.material, b.material)), self.restitution)


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything the simulation needs to begin.

    Attributes:
        name: of the scene.
        gravity: [m/s2], shape (3,), world frame.
        duration: [s]; a CFD client may decide otherwise.
        dt: step [s]; a CFD client may decide otherwise.
        collisions: how collisions are found and answered.
        bodies: in the order of their names.
    """

    name: str
    gravity: Floats
    duration: float
    dt: float
    collisions: Collisions
    bodies: tuple[Body, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "bodies", tuple(sorted(self.bodies, key=lambda body: body.name)))

    @cached_property
    def regions(self) -> dict[str, tuple[Body, ...]]:
        """Bodies of each region, both in the order of their names."""
        members: dict[str, list[Body]] = {body.region: [] for body in self.bodies}
        for body in self.bodies:
            members[body.region].append(body)
        return {region: tuple(members[region]) for region in sorted(members)}
