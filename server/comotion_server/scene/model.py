"""A scene as the simulation takes it: checked, arrays expanded, bodies in the order of their names."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from comotion_server.scene.curved_shapes import Curved

if TYPE_CHECKING:
    from collections.abc import Mapping

    from comotion_server.meshes import TriangleMesh
    from comotion_server.scene.pose_table import PoseTable

Floats = npt.NDArray[np.float64]
Locks = tuple[bool, bool, bool, bool, bool, bool]
Rule = Literal["exact", "paper", "paper-advance", "paper-analytic"]

BY_RULE: Any = None
"""Stands for the value that a rule takes unless told otherwise."""


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
class Plane:
    """A half space, solid below: a floor or a wall without end, and without a surface mesh.

    Attributes:
        normal: unit, shape (3,), body frame, out of the solid; the plane holds the body's position.
    """

    normal: Floats

    @property
    def radius_about_centre(self) -> float:
        """It has no end [m]."""
        return np.inf


@dataclass(frozen=True, eq=False)
class Body:
    """One rigid body at time 0.

    Attributes:
        name: unique in the scene.
        region: the region of geometry exchange that its vertices belong to; without meaning for a plane.
        motion: who moves it.
        mass: [kg]; nan for a fixed or prescribed body that was given none.
        inertia: about the centre of mass, body frame [kg m2], shape (3, 3); nan where the mass is.
        shape: surface mesh, vertices [m] about the centre of mass, body frame, one object for bodies alike; or a plane;
            or what is exactly round.
        position: centre of mass [m], shape (3,), world frame.
        quaternion: (w, x, y, z), body to world, of unit length.
        velocity: of the centre of mass [m/s], shape (3,), world frame.
        angular_velocity: [rad/s], shape (3,), world frame.
        material: what `[[material]]` pairs refer to, if anything.
        frame: closed surface around the shape that it collides with instead, likewise about the centre of mass and one
            object for bodies alike (P17); None: it collides with its shape.
        scalable: whether healing may scale it (P16).
    """

    name: str
    region: str
    motion: Free | Fixed | Prescribed
    mass: float
    inertia: Floats
    shape: TriangleMesh | Plane | Curved
    position: Floats = field(default_factory=lambda: np.zeros(3))
    quaternion: Floats = field(default_factory=lambda: np.array([1.0, 0.0, 0.0, 0.0]))
    velocity: Floats = field(default_factory=lambda: np.zeros(3))
    angular_velocity: Floats = field(default_factory=lambda: np.zeros(3))
    material: str | None = None
    frame: TriangleMesh | None = None
    scalable: bool = True

    @property
    def collision_shape(self) -> TriangleMesh | Plane | Curved:
        """What other bodies collide with: its frame if it has one, else its shape."""
        return self.shape if self.frame is None else self.frame

    @property
    def mesh(self) -> TriangleMesh:
        """The surface mesh that it is.

        Raises:
            TypeError: it is a plane, or exactly round.
        """
        return self._mesh(self.shape)

    @property
    def collision_mesh(self) -> TriangleMesh:
        """The mesh that other bodies collide with.

        Raises:
            TypeError: it is a plane, or exactly round.
        """
        return self._mesh(self.collision_shape)

    def _mesh(self, shape: TriangleMesh | Plane | Curved) -> TriangleMesh:
        if isinstance(shape, Plane | Curved):
            raise TypeError(f'body "{self.name}" is a {type(shape).__name__.lower()}: it has no mesh')
        return shape

    @property
    def surface(self) -> TriangleMesh:
        """The triangles that a client gets: its mesh, or of a round shape one that is made for this (docs/shapes.md).

        Raises:
            TypeError: it is a plane, which has none.
        """
        return self.shape.mesh if isinstance(self.shape, Curved) else self.mesh


@dataclass(frozen=True)
class Collisions:
    """How collisions are found and answered.

    Attributes:
        rule: exact contact times and clusters of contacts; or the paper's queue to the letter, or read the other way:
            advance, then respond (P9, P10); or its queue for analytic bodies (P19).
        restitution: where no pair of materials says otherwise (P11).
        friction: Coulomb's coefficient, likewise; rule `exact`.
        simultaneous: contacts at the same time are answered together, or one after the other; rule `exact`.
        heal: what is pinched is scaled down: mass and inertia with it ("wear"), the geometry alone, or not (P16).
        scale_min: least scale that healing may come to.
        depth_min: least overlap that healing clears twice [m].
        merge: bodies that meet with restitution 0 become one (P11); rule `exact`.
        parallel: what carries the torque of level contacts: the whole patch (rule `exact`), the paper's criteria (P12;
            its rules), or nothing but the closest point.
        patch_angle: faces level within this angle [rad] touch as a whole; rule `exact`.
        substeps: N of the paper's queue (P10).
        parallel_face: |cos| of two faces' normals from which they count as parallel (P12).
        parallel_edge: |cos| of an edge and a face's normal up to which they count as parallel (P12).
        tolerance: gap taken as contact by `exact` and `paper-advance`, relative to the smaller body's size.
        budget: most responses in one step.
        material_pairs: restitution of two materials.
        material_frictions: friction of two materials.
    """

    rule: Rule = "exact"
    restitution: float = 0.3
    friction: float = 0.0
    simultaneous: Literal["together", "sequential"] = "together"
    merge: bool = False
    heal: Literal["wear", "geometry-only", "off"] = "off"
    scale_min: float = 0.5
    depth_min: float = 1e-5
    parallel: Literal["patch", "paper", "off"] = BY_RULE
    patch_angle: float = 1e-6
    substeps: int = 2
    parallel_face: float = 0.999
    parallel_edge: float = 0.01
    tolerance: float = BY_RULE
    budget: int = 10_000
    material_pairs: Mapping[frozenset[str], float] = field(default_factory=dict)
    material_frictions: Mapping[frozenset[str], float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        exact = self.rule == "exact"
        level = {"exact": "patch", "paper-analytic": "off"}.get(self.rule, "paper")
        for name, value in (("parallel", level), ("tolerance", 1e-9 if exact else 1e-6)):
            if getattr(self, name) is BY_RULE:
                object.__setattr__(self, name, value)

    def restitution_between(self, a: Body, b: Body) -> float:
        """Coefficient of restitution of two bodies: their materials' pair if there is one, else the default."""
        return _of_pair(self.material_pairs, a, b, self.restitution)

    def friction_between(self, a: Body, b: Body) -> float:
        """Coefficient of friction of two bodies, found in the same way."""
        return _of_pair(self.material_frictions, a, b, self.friction)


def _of_pair(of_materials: Mapping[frozenset[str], float], a: Body, b: Body, otherwise: float) -> float:
    if a.material is None or b.material is None:
        return otherwise
    return of_materials.get(frozenset((a.material, b.material)), otherwise)


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
        """Bodies of each region, both in the order of their names; planes have no surface to exchange."""
        members: dict[str, list[Body]] = {}
        for body in self.bodies:
            if not isinstance(body.shape, Plane):
                members.setdefault(body.region, []).append(body)
        return {region: tuple(members[region]) for region in sorted(members)}
