"""From checked tables to bodies: shapes loaded, masses computed, arrays expanded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.scene.csv_table import read_pose_table
from comotion_server.scene.frames import Frame, Frames
from comotion_server.scene.model import Body, Fixed, Free, Prescribed
from comotion_server.scene.placement import PlacementError, member_count, member_poses
from comotion_server.scene.scene_errors import SceneError
from comotion_server.scene.solids import Solid, Solids
from comotion_server.scene.tables import AXES, ArrayTable, BodyKeys, BodyTable

if TYPE_CHECKING:
    from pathlib import Path

    from comotion_server.scene.problems import Problems
    from comotion_server.scene.toml_lines import Path as Keys

Floats = npt.NDArray[np.float64]

MAX_BODIES = 1_000_000
MAX_VERTICES = 100_000_000
"""Of all bodies together: 2.4 GB for one set of world positions."""


@dataclass(frozen=True, eq=False)
class MadeBody:
    """A body, the solid it was made of, its frame if any, and the place in the scene file that asked for it."""

    body: Body
    solid: Solid
    frame: Frame | None
    keys: Keys


class _Parts(NamedTuple):
    """What a body, or all members of an array, are made of."""

    solid: Solid
    frame: Frame | None
    motion: Free | Fixed | Prescribed


class BodyMaker:
    """Makes bodies and collects what is wrong with them."""

    def __init__(self, folder: Path, problems: Problems) -> None:
        self.folder = folder
        self.problems = problems
        self.solids = Solids(folder)
        self.frames = Frames(folder)
        self.made: list[MadeBody] = []
        self.vertices = 0

    def add_body(self, table: BodyTable, keys: Keys) -> None:
        """The body of a `[[body]]` at `keys`."""
        parts = self._parts(table, keys)
        if parts is None or not self._room(1, parts.solid, keys):
            return
        motion = parts.motion
        if isinstance(motion, Prescribed) and motion.table is not None:
            position, quaternion = motion.table.pose(0.0)
        else:
            position = parts.solid.centre.copy() if table.position is None else np.array(table.position)
            quaternion = _unit(table.quaternion)
        self._add(table, table.name, parts, (position, quaternion), keys)

    def add_array(self, table: ArrayTable, keys: Keys) -> None:
        """The members of an `[[array]]` at `keys`, numbered so that the order of names is the order of places."""
        parts = self._parts(table, keys)
        if parts is None or not self._room(member_count(table.place), parts.solid, keys):
            return
        around = parts.solid.outline if parts.frame is None else parts.frame.mesh.vertices
        try:
            positions, quaternions = member_poses(table.place, _unit(table.quaternion), around, self.folder)
        except PlacementError as error:
            self.problems.add((*keys, "place", "random"), str(error))
            return
        except SceneError as error:
            self.problems.add_from_file(error, (*keys, "place", "poses"), str(table.place.poses))
            return
        if table.place.poses is not None and not self._room(len(positions), parts.solid, keys):
            return
        digits = max(3, len(str(len(positions))))
        for number, pose in enumerate(zip(positions, quaternions, strict=True), start=1):
            self._add(table, f"{table.name}-{number:0{digits}d}", parts, pose, keys)

    def _add(
        self,
        table: BodyKeys,
        name: str,
        parts: _Parts,
        pose: tuple[Floats, Floats],
        keys: Keys,
    ) -> None:
        solid, frame, motion = parts
        velocity, angular_velocity = np.array(table.velocity), np.array(table.angular_velocity)
        if isinstance(motion, Prescribed):
            velocity, angular_velocity = motion.velocity.copy(), motion.angular_velocity.copy()
            if motion.table is not None:
                velocity, angular_velocity = motion.table.twist(0.0)
        mass = _mass(table, solid)
        body = Body(
            name=name,
            region=table.region or table.name,
            motion=motion,
            mass=mass,
            inertia=_inertia(table, solid, mass),
            shape=solid.shape,
            position=pose[0],
            quaternion=pose[1],
            velocity=velocity,
            angular_velocity=angular_velocity,
            material=table.material,
            frame=None if frame is None else frame.mesh,
            scalable=table.scalable,
        )
        self.made.append(MadeBody(body, solid, frame, keys))

    def _parts(self, table: BodyKeys, keys: Keys) -> _Parts | None:
        solid, motion = self._solid(table, keys), self._motion(table, keys)
        if solid is None or motion is None:
            return None
        if table.frame is None:
            return _Parts(solid, None, motion)
        try:
            return _Parts(solid, self.frames.of(table.frame, solid), motion)
        except MeshError as error:
            (kind,) = table.frame.model_fields_set
            message = str(error) if table.frame.stl is None else f"{table.frame.stl}: {error}"
            self.problems.add((*keys, "frame", kind), message)
            return None

    def _solid(self, table: BodyKeys, keys: Keys) -> Solid | None:
        try:
            solid = self.solids.of(table.shape)
        except MeshError as error:
            self.problems.add((*keys, "shape", "stl"), f"{table.shape.stl}: {error}")
            return None
        needs_volume = "a free body" if table.motion == "free" else "a body with a density"
        if (table.motion == "free" or table.density is not None) and solid.flaws:
            found = ", ".join(solid.flaws)
            self.problems.add((*keys, "shape", "stl"), f"{solid.label}: {found}: {needs_volume} needs a closed surface")
            return None
        return solid

    def _motion(self, table: BodyKeys, keys: Keys) -> Free | Fixed | Prescribed | None:
        if table.motion == "free":
            x, y, z, rx, ry, rz = (axis in table.locked for axis in AXES)
            return Free((x, y, z, rx, ry, rz), table.reacts, np.array(table.thrust))
        if isinstance(table.motion, str):
            return Fixed()
        if table.motion.table is None:
            return Prescribed(np.array(table.motion.velocity), np.array(table.motion.angular_velocity))
        try:
            return Prescribed(table=read_pose_table(self.folder / table.motion.table))
        except SceneError as error:
            self.problems.add_from_file(error, (*keys, "motion", "table"), table.motion.table)
            return None

    def _room(self, count: int, solid: Solid, keys: Keys) -> bool:
        vertices = self.vertices + count * solid.vertex_count
        bodies = len(self.made) + count
        if bodies > MAX_BODIES:
            self.problems.add(keys, f"brings the scene to {bodies} bodies; at most {MAX_BODIES} are allowed")
        elif vertices > MAX_VERTICES:
            self.problems.add(keys, f"brings the scene to {vertices} vertices; at most {MAX_VERTICES} are allowed")
        else:
            self.vertices = vertices
            return True
        return False


def _mass(table: BodyKeys, solid: Solid) -> float:
    if table.mass is not None:
        return table.mass
    return np.nan if table.density is None else table.density * solid.volume


def _inertia(table: BodyKeys, solid: Solid, mass: float) -> Floats:
    if table.inertia is not None:
        inertia = np.array(table.inertia)
        return np.asarray(0.5 * (inertia + inertia.T))
    return np.asarray(solid.inertia * (mass / solid.volume))


def _unit(quaternion: list[float]) -> Floats:
    unit: Floats = np.array(quaternion) / np.linalg.norm(quaternion)
    return unit
