"""The `[fluid]` table of a scene, checked, and what else of the scene file a CFD client needs."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[Finite, Field(gt=0.0)]
NotNegative = Annotated[Finite, Field(ge=0.0)]
Vector = Annotated[tuple[Finite, Finite, Finite], Field(strict=False)]  # TOML has lists, no tuples


class FluidError(ValueError):
    """A fluid that does not fit its scene; the message says which key, what was given and what is allowed."""


class Table(BaseModel):
    """A table of the scene file: keys that are not listed are refused, and nothing is converted."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Drag(Table):
    """`[fluid] drag`: coefficients of the quadratic drag; see `comotion_mock_cfd.drag`."""

    form: NotNegative = 0.0
    """Cd of a facet moving face-on into the water."""
    friction: NotNegative = 0.0
    """Cf of a wetted facet moving in its own plane."""


class Heave(Table):
    """`[fluid] heave`: a free, wall-sided body whose heave period a run compares with theory."""

    body: str
    draught: Positive
    """At rest [m]: mass / (density x waterplane area)."""


class Fluid(Table):
    """`[fluid]`: water at rest or in a uniform current below a level, vacuum above (P22)."""

    density: Positive = 1000.0
    """[kg/m3]."""
    level: Finite = 0.0
    """Height of the free surface [m]."""
    current: Vector = (0.0, 0.0, 0.0)
    """Velocity of the water [m/s], world frame."""
    drag: Drag = Drag()
    added_mass: dict[str, NotNegative] = Field(default_factory=dict)
    """Added mass [kg] of every body of a region, or of one body (which wins); see `comotion_mock_cfd.added_mass`."""
    heave: Heave | None = None


class _SceneTable(BaseModel):
    """The keys of `[scene]` that concern the fluid side; the server checks the others."""

    model_config = ConfigDict(extra="ignore", strict=True)

    name: str = ""
    gravity: Vector = (0.0, 0.0, -9.81)
    duration: Positive
    dt: Positive


class _SceneFile(BaseModel):
    """The tables that concern the fluid side."""

    model_config = ConfigDict(extra="ignore", strict=True)

    scene: _SceneTable
    fluid: Fluid | None = None


@dataclass(frozen=True)
class FluidScene:
    """What a CFD client plays: a fluid, or vacuum, and for how long."""

    fluid: Fluid | None
    """None is vacuum: no forces."""
    gravity: float
    """Magnitude [m/s2], along -z. It makes the pressure here; the weight of the bodies is the server's."""
    dt: float
    """Step [s]."""
    duration: float
    """[s]; the last step is shortened to end there."""
    name: str = ""


def load_fluid(path: str | Path) -> FluidScene:
    """Read the fluid side of a scene file.

    Raises:
        FluidError: the water's surface would not be level: gravity is not along -z.
        pydantic.ValidationError: a key is unknown, missing or has a value that is not allowed.
        tomllib.TOMLDecodeError, OSError: the file cannot be read.
    """
    path = Path(path)
    with path.open("rb") as file:
        tables = _SceneFile.model_validate(tomllib.load(file))
    scene = tables.scene
    x, y, z = scene.gravity
    if tables.fluid is not None and (x != 0.0 or y != 0.0 or z > 0.0):
        raise FluidError(f"scene.gravity: a scene with [fluid] needs gravity along -z, or zero; got [{x}, {y}, {z}]")
    return FluidScene(tables.fluid, abs(z), scene.dt, scene.duration, scene.name or path.stem)
