"""The scene file's keys: types, units, limits, defaults. The JSON schema and every refusal are made from these."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag

from comotion_server.scene.curved_shapes import RESOLUTION

NAME_PATTERN = r"^[A-Za-z0-9_][A-Za-z0-9_.+-]*$"
"""Names become parts of message blocks, file names and columns: letters, digits and _ . + - only."""

QUATERNION_TOLERANCE = 1e-3
"""How far from 1 the length of a quaternion may be: three digits are enough (0.707). It is then made 1 exactly."""

INERTIA_TOLERANCE = 1e-9
"""Relative to the largest principal moment: a flat body, the limit of what can exist, may be given rounded."""

AXES = ("x", "y", "z", "rx", "ry", "rz")


class Table(BaseModel):
    """A table of the scene file: numbers stay numbers, unknown keys are mistakes."""

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


def quantity(unit: str, default: Any = ..., **limits: Any) -> Any:
    """A field with a unit ("1" for a pure number)."""
    return Field(default, json_schema_extra={"unit": unit}, **limits)


def _unit_quaternion(value: list[float]) -> list[float]:
    length = float(np.linalg.norm(value))
    if not abs(length - 1.0) <= QUATERNION_TOLERANCE:
        raise ValueError(f"must have length 1 (within {QUATERNION_TOLERANCE:g}); its length is {length:.6g}")
    return value


def _some_direction(value: list[float]) -> list[float]:
    if not any(value):
        raise ValueError("must point somewhere")
    return value


def _possible_inertia(value: list[list[float]]) -> list[list[float]]:
    inertia = np.array(value)
    largest = float(np.abs(inertia).max())
    if np.abs(inertia - inertia.T).max() > INERTIA_TOLERANCE * largest:
        raise ValueError("must be symmetric")
    low, middle, high = np.linalg.eigvalsh(0.5 * (inertia + inertia.T))
    moments = f"its principal moments are {low:.6g}, {middle:.6g}, {high:.6g} kg m2"
    if not low > 0.0:
        raise ValueError(f"must be positive definite; {moments}")
    if low + middle < high * (1.0 - INERTIA_TOLERANCE):
        raise ValueError(f"no body has it: the largest principal moment exceeds the sum of the others; {moments}")
    return value


def _possible_locks(value: list[str]) -> list[str]:
    if len(set(value)) < len(value):
        raise ValueError("names an axis twice")
    if sum(axis.startswith("r") for axis in value) == 1:
        raise ValueError("locks rotation about one axis; allowed: none, two (it turns about the third), or all three")
    return value


LARGEST = 1e30
"""No number may be larger: beyond it, and not far, products of products leave double precision."""

LENGTHS = {"ge": 1e-12, "le": 1e12}
"""Smallest and largest length [m] of a shape: below, volumes and moments of inertia vanish in double precision."""

MASSES = {"gt": 0, "le": LARGEST}

Name = Annotated[str, Field(pattern=NAME_PATTERN, max_length=100)]
Real = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Vector = Annotated[list[Real], Field(min_length=3, max_length=3)]
Lengths = Annotated[list[Annotated[float, Field(**LENGTHS)]], Field(min_length=3, max_length=3)]
Quaternion = Annotated[list[float], Field(min_length=4, max_length=4), AfterValidator(_unit_quaternion)]
Inertia = Annotated[list[Vector], Field(min_length=3, max_length=3), AfterValidator(_possible_inertia)]
Locks = Annotated[list[Literal["x", "y", "z", "rx", "ry", "rz"]], AfterValidator(_possible_locks)]
Direction = Annotated[Vector, AfterValidator(_some_direction)]
Resolution = Annotated[int, Field(ge=3, le=1024)]
Restitution = Annotated[float, Field(ge=0, le=1)]
Friction = Annotated[float, Field(ge=0, le=LARGEST)]


class SceneTable(Table):
    """The scene as a whole."""

    name: Name | None = None
    """Name of the scene; the file's name unless given."""
    gravity: Vector = quantity("m/s2", [0.0, 0.0, -9.81])
    """Acceleration of free fall, world frame."""
    duration: float = quantity("s", gt=0, le=LARGEST)
    """Time to simulate; a CFD client may decide otherwise."""
    dt: float = quantity("s", gt=0, le=LARGEST)
    """Time step; a CFD client may decide otherwise."""


class CollisionsTable(Table):
    """How collisions are found and answered."""

    rule: Literal["exact", "paper", "paper-advance", "paper-analytic"] = "exact"
    """Exact contact times; or the paper's queue: to the letter, read the other way, or that for spheres."""
    restitution: Restitution = quantity("1", 0.3)
    """Coefficient of restitution: 1 elastic, 0 plastic; pairs of materials may say otherwise."""
    friction: Friction = quantity("1", 0.0)
    """Coulomb's coefficient; pairs of materials may say otherwise. Rule `exact` only."""
    simultaneous: Literal["together", "sequential"] = "together"
    """Contacts at the same time are answered as one problem, or one after the other. Rule `exact` only."""
    heal: Literal["wear", "geometry-only", "off"] = "off"
    """Bodies that are pinched are scaled down, and their mass and inertia with them; the geometry alone; or not."""
    scale_min: Annotated[float, Field(gt=0, le=1)] = quantity("1", 0.5)
    """Least scale that healing may come to; bodies that would need less are blocked."""
    depth_min: float = quantity("m", 1e-5, gt=0)
    """Least overlap: healing clears twice that, or twice the overlap there is or would be in the step."""
    merge: bool = False
    """Bodies that meet with restitution 0 become one, but for those that move as told. Rule `exact` only."""
    parallel: Literal["patch", "paper", "off"] | None = None
    """Level faces touch as a whole ("patch", rule `exact`), or push without turning ("paper", the paper's rules)."""
    patch_angle: float = quantity("rad", 1e-6, ge=0, le=0.1)
    """Faces level within this angle touch as a whole. Rule `exact` only."""
    substeps: int = quantity("1", 2, ge=1, le=1_000_000)
    """N of the paper's queue: each advance covers the N-th part of the time to the earliest contact."""
    parallel_face: Annotated[float, Field(ge=0, le=1)] = quantity("1", 0.999)
    """Two faces are parallel where |cos| between their normals is at least this."""
    parallel_edge: Annotated[float, Field(ge=0, le=1)] = quantity("1", 0.01)
    """An edge and a face are parallel where |cos| between edge and normal is at most this."""
    tolerance: float | None = quantity("1", None, gt=0, le=0.1)
    """Gap that counts as contact, relative to the smaller body's size; not of rule `paper`."""
    budget: int = quantity("1", 10_000, ge=1, le=1_000_000_000)
    """Most impacts answered in one step."""


class MaterialTable(Table):
    """What holds between two materials."""

    between: Annotated[list[Name], Field(min_length=2, max_length=2)]
    """The two materials; a pair may name one twice."""
    restitution: Restitution | None = quantity("1", None)
    """Coefficient of restitution between them."""
    friction: Friction | None = quantity("1", None)
    """Coulomb's coefficient between them. Rule `exact` only."""


class BoxTable(Table):
    """A box about its centre."""

    size: Lengths = quantity("m")
    """Edges along x, y, z."""


class PrismTable(Table):
    """An isosceles triangle in the x-y plane, its base along x, extruded along z, about its centre of mass."""

    base: float = quantity("m", **LENGTHS)
    """Base of the triangle, along x."""
    height: float = quantity("m", **LENGTHS)
    """Height of the triangle over its base, along y."""
    thickness: float = quantity("m", **LENGTHS)
    """Thickness along z."""


class PlaneTable(Table):
    """A half space, solid below the plane: for fixed and prescribed bodies, rule `exact` only."""

    normal: Direction = quantity("1")
    """Out of the solid, of any length, body frame."""
    point: Vector = quantity("m", [0.0, 0.0, 0.0])
    """Of the plane, world frame; a `position` takes its place."""


class SphereTable(Table):
    """A sphere about its centre."""

    radius: float = quantity("m", **LENGTHS)
    """Of the sphere."""
    resolution: Resolution = quantity("1", RESOLUTION)
    """Vertices around it, for clients that ask for vertices."""


class CapsuleTable(Table):
    """A cylinder with round ends, about its centre."""

    radius: float = quantity("m", **LENGTHS)
    """Of the cylinder and the ends."""
    length: float = quantity("m", **LENGTHS)
    """Of the cylinder, without the round ends."""
    axis: Literal["x", "y", "z"] = "z"
    """Along which it lies, body frame."""
    resolution: Resolution = quantity("1", RESOLUTION)
    """Vertices around it, for clients that ask for vertices."""


class CylinderTable(Table):
    """A solid cylinder about its centre."""

    radius: float = quantity("m", **LENGTHS)
    """Of the cylinder."""
    length: float = quantity("m", **LENGTHS)
    """Of the cylinder."""
    axis: Literal["x", "y", "z"] = "z"
    """Along which it lies, body frame."""
    resolution: Resolution = quantity("1", RESOLUTION)
    """Vertices around it, for clients that ask for vertices."""


class PipeTable(Table):
    """A straight pipe about its centre: for fixed bodies, and prescribed ones that do not turn."""

    inner_radius: float = quantity("m", **LENGTHS)
    """Of the bore."""
    outer_radius: float = quantity("m", **LENGTHS)
    """Of the outer wall."""
    length: float = quantity("m", **LENGTHS)
    """Of the bore."""
    axis: Literal["x", "y", "z"] = "z"
    """Along which it lies, body frame."""
    caps: bool = False
    """Whether flat discs close both ends."""
    resolution: Resolution = quantity("1", RESOLUTION)
    """Vertices around it, for clients that ask for vertices."""


class ShapeTable(Table):
    """Exactly one shape."""

    stl: str | None = Field(None, min_length=1)
    """A mesh file (STL, OBJ, PLY or OFF, in metres), relative to the scene's folder."""
    box: BoxTable | None = None
    """A box."""
    prism: PrismTable | None = None
    """A triangular prism."""
    plane: PlaneTable | None = None
    """A plane without end."""
    sphere: SphereTable | None = None
    """A sphere, exactly round."""
    capsule: CapsuleTable | None = None
    """A cylinder with round ends, exactly round."""
    cylinder: CylinderTable | None = None
    """A cylinder, exactly round."""
    pipe: PipeTable | None = None
    """A pipe, exactly round."""


class FrameTable(Table):
    """What the body collides with in place of its shape: exactly one kind of closed surface around it."""

    stl: str | None = Field(None, min_length=1)
    """A mesh file of its own, in the coordinates of the shape, relative to the scene's folder."""
    scale: float | None = quantity("1", None, gt=1, le=1e6)
    """The shape, larger by this factor about the centre of mass."""
    offset: float | None = quantity("m", None, **LENGTHS)
    """The shape, its facets moved outward by this."""


class MotionTable(Table):
    """Prescribed motion: constant velocities, or a table of poses."""

    velocity: Vector = quantity("m/s", [0.0, 0.0, 0.0])
    """Of the centre of mass, world frame, constant."""
    angular_velocity: Vector = quantity("rad/s", [0.0, 0.0, 0.0])
    """World frame, constant."""
    table: str | None = Field(None, min_length=1)
    """A CSV file of poses over time (t,x,y,z,qw,qx,qy,qz), relative to the scene's folder."""


def _motion_kind(value: Any) -> str:
    return "<table>" if isinstance(value, dict | MotionTable) else "<word>"


Motion = Annotated[
    Annotated[Literal["free", "fixed"], Tag("<word>")] | Annotated[MotionTable, Tag("<table>")],
    Discriminator(_motion_kind),
]


class BodyKeys(Table):
    """What single bodies and the members of an array have in common."""

    name: Name
    """Unique in the scene."""
    shape: ShapeTable
    """The body's shape: exactly one of stl, box, prism, plane, sphere, capsule, cylinder, pipe."""
    frame: FrameTable | None = None
    """What it collides with in place of its shape, around it: exactly one of stl, scale, offset."""
    region: Name | None = None
    """Region of geometry exchange that the vertices belong to; the name unless given."""
    motion: Motion = "free"
    """free, fixed, or prescribed by velocities or a table of poses."""
    mass: float | None = quantity("kg", None, **MASSES)
    """A free body has a mass or a density."""
    density: float | None = quantity("kg/m3", None, **MASSES)
    """Mass over the volume that the surface encloses."""
    inertia: Inertia | None = quantity("kg m2", None)
    """About the centre of mass, body frame; of a solid of even density unless given."""
    quaternion: Quaternion = quantity("1", [1.0, 0.0, 0.0, 0.0])
    """Attitude w, x, y, z, body to world, about the centre of mass."""
    velocity: Vector = quantity("m/s", [0.0, 0.0, 0.0])
    """Initial velocity of the centre of mass, world frame; free bodies only."""
    angular_velocity: Vector = quantity("rad/s", [0.0, 0.0, 0.0])
    """Initial angular velocity, world frame; free bodies only."""
    material: Name | None = None
    """What [[material]] pairs refer to."""
    locked: Locks = Field(default_factory=list)
    """World axes along (x, y, z) and about (rx, ry, rz) which the body does not move; free bodies only."""
    reacts: bool = True
    """Whether impacts change its motion; free bodies only."""
    thrust: Vector = quantity("N", [0.0, 0.0, 0.0])
    """Constant force at the centre of mass, world frame; free bodies only."""
    scalable: bool = True
    """Whether healing may scale it down; free bodies only."""


class BodyTable(BodyKeys):
    """A rigid body."""

    position: Vector | None = quantity("m", None)
    """Centre of mass, world frame; where the mesh file puts it unless given, the origin for other shapes."""


class GridTable(Table):
    """Places on a grid, x fastest, then y, then z."""

    origin: Vector = quantity("m")
    """Centre of mass of the first member."""
    counts: Annotated[list[Annotated[int, Field(ge=1, le=1_000_000)]], Field(min_length=3, max_length=3)] = quantity(
        "1"
    )
    """Members along x, y, z."""
    spacing: Vector = quantity("m")
    """From one member to the next along x, y, z."""


class RandomTable(Table):
    """A random field in which no two members overlap, the same for the same seed."""

    low: Vector = quantity("m")
    """Lowest corner of the box that all members lie in."""
    high: Vector = quantity("m")
    """Highest corner; the same z as `low` puts all centres in that plane."""
    count: int = quantity("1", ge=1, le=1_000_000)
    """Number of members."""
    seed: int = quantity("1", ge=0, le=2**63 - 1)
    """Another seed is another field."""
    gap: float = quantity("m", 0.0, ge=0, le=1e12)
    """Least distance between the bounding circles (spheres) of any two members."""
    turn: Literal["none", "z"] = "none"
    """Whether members are turned at random about z."""


class PlaceTable(Table):
    """Exactly one way to place the members."""

    grid: GridTable | None = None
    """On a grid."""
    poses: str | None = Field(None, min_length=1)
    """A CSV file with a row per member (x,y,z or x,y,z,qw,qx,qy,qz), relative to the scene's folder."""
    random: RandomTable | None = None
    """A seeded random field without overlaps."""


class ArrayTable(BodyKeys):
    """Many like bodies, named after the array and numbered from 1 (floe-001 ...)."""

    place: PlaceTable
    """Where the members are: exactly one of grid, poses, random."""


class SceneFile(Table):
    """A scene of the comotion co-simulation server."""

    scene: SceneTable
    """The scene as a whole."""
    collisions: CollisionsTable = CollisionsTable()
    """How collisions are found and answered."""
    material: list[MaterialTable] = Field(default_factory=list)
    """Pairs of materials."""
    body: list[BodyTable] = Field(default_factory=list)
    """Rigid bodies."""
    array: list[ArrayTable] = Field(default_factory=list)
    """Many like bodies in one region."""
    fluid: dict[str, Any] = Field(default_factory=dict)
    """For the CFD client; not looked at here."""
