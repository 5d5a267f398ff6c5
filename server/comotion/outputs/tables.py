"""The CSV tables of a run: poses, fluid wrenches, impacts, contacts, wear.

Quaternions are (w, x, y, z), body to world; everything else is in the world frame; `time` is the time at which the row
holds. Python writes the shortest digits that read back to the same float64.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.csv_table import CsvTable

if TYPE_CHECKING:
    from comotion_protocol.messages import Contact, Impact, Wear

POSES = (
    *("time [s]", "body", "x [m]", "y [m]", "z [m]", "qw", "qx", "qy", "qz"),
    *("vx [m/s]", "vy [m/s]", "vz [m/s]", "wx [rad/s]", "wy [rad/s]", "wz [rad/s]"),
)
WRENCHES = ("time [s]", "body", "fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]")
IMPACTS = (
    *("time [s]", "body_a", "body_b", "x [m]", "y [m]", "z [m]", "nx", "ny", "nz"),
    *("impulse [N s]", "approach_speed [m/s]", "restitution", "law"),
    *("friction_x [N s]", "friction_y [N s]", "friction_z [N s]"),
)
CONTACTS = (
    *("time [s]", "body_a", "body_b", "jx [N s]", "jy [N s]", "jz [N s]", "count"),
    *("held_x [N s]", "held_y [N s]", "held_z [N s]"),
)
WEAR = (
    *("time [s]", "body", "scale", "depth [m]", "mass [kg]", "px [N s]", "py [N s]", "pz [N s]"),
    *("lx [N m s]", "ly [N m s]", "lz [N m s]", "energy [J]"),
)
NOTHING = (0.0, 0.0, 0.0)


class Tables:
    """The tables in one folder."""

    def __init__(self, folder: Path) -> None:
        self._poses = CsvTable(folder / "poses.csv", POSES)
        self._wrenches = CsvTable(folder / "wrenches.csv", WRENCHES)
        self._impacts = CsvTable(folder / "impacts.csv", IMPACTS)
        self._contacts = CsvTable(folder / "contacts.csv", CONTACTS)
        self._wear = CsvTable(folder / "wear.csv", WEAR)

    def write_poses(
        self, time: float, names: Sequence[str], poses: NDArray[np.float64], twists: NDArray[np.float64]
    ) -> None:
        """Poses (bodies, 7) [m, 1] and twists (bodies, 6) [m/s, rad/s] at a time [s]."""
        self._poses.write(
            (time, name, *pose, *twist)
            for name, pose, twist in zip(names, poses.tolist(), twists.tolist(), strict=True)
        )

    def write_wrenches(self, time: float, names: Sequence[str], wrenches: NDArray[np.float64]) -> None:
        """Fluid force and moment about the centre of mass (bodies, 6) [N, N m], held over the step from a time [s]."""
        self._wrenches.write((time, name, *row) for name, row in zip(names, wrenches.tolist(), strict=True))

    def write_impacts(self, impacts: Iterable["Impact"]) -> None:
        """Every impact of a step; the impulse acts along the normal on body_b and against it on body_a."""
        for hit in impacts:
            numbers = (hit.impulse, hit.approach_speed, hit.restitution, hit.law, *(hit.friction or NOTHING))
            self._impacts.write([(hit.time, hit.body_a, hit.body_b, *hit.point, *hit.normal, *numbers)])

    def write_contacts(self, time: float, contacts: Iterable["Contact"]) -> None:
        """Impulse per pair over the step that ends at a time [s]; it acts on body_b, and its opposite on body_a."""
        self._contacts.write(
            (time, pair.body_a, pair.body_b, *pair.impulse, pair.count, *(pair.held or NOTHING)) for pair in contacts
        )

    def write_wear(self, wear: Iterable["Wear"]) -> None:
        """Every scaling of a body that was pinched, and what went with the mass it lost."""
        for worn in wear:
            lost = (worn.mass, *worn.momentum, *worn.angular_momentum, worn.energy)
            self._wear.write([(worn.time, worn.body, worn.scale, worn.depth, *lost)])

    def close(self) -> None:
        """Close all files."""
        for table in (self._poses, self._wrenches, self._impacts, self._contacts, self._wear):
            table.close()
