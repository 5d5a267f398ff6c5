"""Shapes that are exactly round, given by a few lengths about their centre of mass (docs/shapes.md).

Nothing in a scene of them needs a mesh but a client that asks for vertices: `mesh` is made then, once for all bodies
with that shape.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from comotion_server.meshes import TriangleMesh

Floats = npt.NDArray[np.float64]

RESOLUTION = 16
"""Vertices around a shape unless told otherwise: its volume in triangles is a few per cent short."""


class Curved(ABC):
    """What all of them have in common."""

    resolution: int
    axis: int

    @property
    def kind(self) -> str:
        """What a scene file calls it."""
        return type(self).__name__.lower()

    @property
    @abstractmethod
    def label(self) -> str:
        """What a report calls it."""

    @property
    @abstractmethod
    def radius_about_centre(self) -> float:
        """Of the sphere about the centre that holds it [m]."""

    @property
    @abstractmethod
    def volume(self) -> float:
        """[m3]."""

    @property
    @abstractmethod
    def squared_radii(self) -> tuple[float, float]:
        """Moments of inertia over mass, about the axis and across it [m2]."""

    @property
    @abstractmethod
    def half_extents(self) -> tuple[float, float]:
        """Half of what it covers, along the axis and across it [m]."""

    @property
    @abstractmethod
    def profiles(self) -> tuple[Floats, ...]:
        """Lines (k, 2) of points (z, rho) [m] that give its surface as they turn about the axis, outside to the left.

        A line begins and ends on the axis, or where it began.
        """

    @property
    def inertia(self) -> Floats:
        """Of density 1 about the centre, body frame [m5], shape (3, 3)."""
        about, across = self.squared_radii
        return np.diag(np.where(np.arange(3) == self.axis, about, across)) * self.volume

    @property
    def outline(self) -> Floats:
        """Corners (8, 3) [m] of the box that it fills: where there is room for it."""
        along, across = self.half_extents
        half = np.where(np.arange(3) == self.axis, along, across)
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return np.asarray(signs * half)

    @property
    def vertex_count(self) -> int:
        """Of `mesh`, without making it."""
        return sum(int(np.where(line[:, 1] > 0.0, self.resolution, 1).sum()) for line in self._open_profiles())

    @cached_property
    def mesh(self) -> TriangleMesh:
        """A closed surface of triangles whose vertices lie on the shape, about the centre, body frame."""
        from comotion_server.meshes.revolved import revolved

        return revolved(self.profiles, self.resolution, self.axis)

    def _open_profiles(self) -> list[Floats]:
        return [line[:-1] if (line[0] == line[-1]).all() else line for line in self.profiles]


def _steps(length: float, radius: float, resolution: int) -> int:
    """Into how many parts a straight line [m] is cut: about as long as those around a radius [m], not too many."""
    return int(np.clip(np.ceil(length * resolution / (2.0 * np.pi * radius)), 1, 4 * resolution))


def _straight(ends: tuple[tuple[float, float], ...], radius: float, resolution: int) -> Floats:
    """Straight lines from end to end (z, rho) [m]; every end is met exactly."""
    parts = [np.array(ends[:1])]
    for (z, rho), (up, out) in pairwise(ends):
        share = np.linspace(0.0, 1.0, _steps(abs(up - z) + abs(out - rho), radius, resolution) + 1)[1:, None]
        parts.append((1.0 - share) * np.array([[z, rho]]) + share * np.array([[up, out]]))
    return np.vstack(parts)


def _arc(radius: float, resolution: int) -> Floats:
    """A quarter of a circle (z, rho) [m] from the axis, below, to its widest."""
    angle = np.linspace(0.0, 0.5 * np.pi, max(resolution // 4, 1) + 1)
    points = radius * np.stack((-np.cos(angle), np.sin(angle)), axis=1)
    points[0], points[-1] = (-radius, 0.0), (0.0, radius)
    return points


@dataclass(frozen=True)
class Sphere(Curved):
    """A sphere.

    Attributes:
        radius: [m].
        resolution: vertices around it.
    """

    radius: float
    resolution: int = RESOLUTION

    axis = 2

    @property
    def label(self) -> str:
        """What a report calls it."""
        return f"sphere of radius {self.radius:g} m"

    @property
    def radius_about_centre(self) -> float:
        """Of the sphere about the centre that holds it [m]."""
        return self.radius

    @property
    def volume(self) -> float:
        """[m3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

    @property
    def squared_radii(self) -> tuple[float, float]:
        """Moments of inertia over mass, about the axis and across it [m2]."""
        return 0.4 * self.radius**2, 0.4 * self.radius**2

    @property
    def half_extents(self) -> tuple[float, float]:
        """Half of what it covers, along the axis and across it [m]."""
        return self.radius, self.radius

    @property
    def profiles(self) -> tuple[Floats, ...]:
        """One line, from pole to pole."""
        arc = _arc(self.radius, self.resolution)
        return (np.vstack((arc, arc[-2::-1] * (-1.0, 1.0))),)


@dataclass(frozen=True)
class Capsule(Curved):
    """A cylinder with round ends.

    Attributes:
        radius: [m].
        length: of the cylinder: from the middle of one round end to that of the other [m].
        axis: 0, 1 or 2: which axis of the body it lies along.
        resolution: vertices around it.
    """

    radius: float
    length: float
    axis: int = 2
    resolution: int = RESOLUTION

    @property
    def label(self) -> str:
        """What a report calls it."""
        return f"capsule of radius {self.radius:g} m, length {self.length:g} m"

    @property
    def radius_about_centre(self) -> float:
        """Of the sphere about the centre that holds it [m]."""
        return self.radius + 0.5 * self.length

    @property
    def volume(self) -> float:
        """[m3]."""
        return np.pi * self.radius**2 * (self.length + 4.0 / 3.0 * self.radius)

    @property
    def squared_radii(self) -> tuple[float, float]:
        """Moments of inertia over mass, about the axis and across it [m2]; the ends have their centres 3 r / 8 out."""
        r, length = self.radius, self.length
        ends = 4.0 / 3.0 * r / (length + 4.0 / 3.0 * r)
        about = (1.0 - ends) * 0.5 * r * r + ends * 0.4 * r * r
        middle = r * r / 4.0 + length**2 / 12.0
        return about, (1.0 - ends) * middle + ends * (0.4 * r * r + length**2 / 4.0 + 3.0 / 8.0 * length * r)

    @property
    def half_extents(self) -> tuple[float, float]:
        """Half of what it covers, along the axis and across it [m]."""
        return self.radius_about_centre, self.radius

    @property
    def profiles(self) -> tuple[Floats, ...]:
        """One line, from pole to pole."""
        arc, h = _arc(self.radius, self.resolution), 0.5 * self.length
        side = _straight(((-h, self.radius), (h, self.radius)), self.radius, self.resolution)
        return (np.vstack((arc - (h, 0.0), side[1:-1], (arc[::-1] - (h, 0.0)) * (-1.0, 1.0))),)


@dataclass(frozen=True)
class Cylinder(Curved):
    """A solid cylinder.

    Attributes:
        radius: [m].
        length: [m].
        axis: 0, 1 or 2: which axis of the body it lies along.
        resolution: vertices around it.
    """

    radius: float
    length: float
    axis: int = 2
    resolution: int = RESOLUTION

    @property
    def label(self) -> str:
        """What a report calls it."""
        return f"cylinder of radius {self.radius:g} m, length {self.length:g} m"

    @property
    def radius_about_centre(self) -> float:
        """Of the sphere about the centre that holds it [m]."""
        return float(np.hypot(self.radius, 0.5 * self.length))

    @property
    def volume(self) -> float:
        """[m3]."""
        return np.pi * self.radius**2 * self.length

    @property
    def squared_radii(self) -> tuple[float, float]:
        """Moments of inertia over mass, about the axis and across it [m2]."""
        return 0.5 * self.radius**2, 0.25 * self.radius**2 + self.length**2 / 12.0

    @property
    def half_extents(self) -> tuple[float, float]:
        """Half of what it covers, along the axis and across it [m]."""
        return 0.5 * self.length, self.radius

    @property
    def profiles(self) -> tuple[Floats, ...]:
        """One line, from the middle of one end to that of the other."""
        return (_can(self.radius, 0.5 * self.length, self.resolution),)


@dataclass(frozen=True)
class Pipe(Curved):
    """A straight pipe.

    Attributes:
        inner_radius: of the bore [m].
        outer_radius: [m].
        length: [m].
        axis: 0, 1 or 2: which axis of the body it lies along.
        caps: whether flat discs, without thickness or mass, close both ends.
        resolution: vertices around it.
    """

    inner_radius: float
    outer_radius: float
    length: float
    axis: int = 2
    caps: bool = False
    resolution: int = RESOLUTION

    @property
    def label(self) -> str:
        """What a report calls it."""
        radii = f"pipe of radii {self.inner_radius:g} and {self.outer_radius:g} m, length {self.length:g} m"
        return radii + (", closed" if self.caps else "")

    @property
    def radius_about_centre(self) -> float:
        """Of the sphere about the centre that holds it [m]."""
        return float(np.hypot(self.outer_radius, 0.5 * self.length))

    @property
    def volume(self) -> float:
        """Of the wall [m3]."""
        return np.pi * (self.outer_radius - self.inner_radius) * (self.outer_radius + self.inner_radius) * self.length

    @property
    def squared_radii(self) -> tuple[float, float]:
        """Moments of inertia over mass, about the axis and across it [m2]."""
        both = self.outer_radius**2 + self.inner_radius**2
        return 0.5 * both, 0.25 * both + self.length**2 / 12.0

    @property
    def half_extents(self) -> tuple[float, float]:
        """Half of what it covers, along the axis and across it [m]."""
        return 0.5 * self.length, self.outer_radius

    @property
    def profiles(self) -> tuple[Floats, ...]:
        """The outline of the wall; of a closed pipe a shell outside and one about the bore, seen from inside."""
        h, r, R = 0.5 * self.length, self.inner_radius, self.outer_radius
        if self.caps:
            return _can(R, h, self.resolution), _can(r, h, self.resolution)[::-1]
        return (_straight(((-h, r), (-h, R), (h, R), (h, r), (-h, r)), R, self.resolution),)


def _can(radius: float, half: float, resolution: int) -> Floats:
    """The profile of a solid cylinder."""
    return _straight(((-half, 0.0), (-half, radius), (half, radius), (half, 0.0)), radius, resolution)
