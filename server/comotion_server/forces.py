"""The forces a step is given: checked at the door, then summed to one wrench per body (P3).

Nodal forces act at the vertices *that were last sent*, so moments are taken about the centres that went with them.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from comotion_server.kernels.wrench import gather
from comotion_server.regions import Region, Sample
from comotion_server.results import Sums

Array = NDArray[np.float64]


class StepInputError(ValueError):
    """A step that was asked for with something that cannot be used; the state is untouched."""


@dataclass(frozen=True, slots=True)
class Wrenches:
    """Force [N] and moment [N m] about the centre of mass last sent, per body (n,3), world frame."""

    force: Array
    moment: Array

    def sums(self, centres: Array) -> Sums:
        """Totals, the moment about the world origin."""
        _, xy, xz, yx, _, yz, zx, zy, _ = np.einsum("ni,nj->ij", centres, self.force).ravel().tolist()
        turning = np.array([yz - zy, zx - xz, xy - yx])
        return Sums(self.force.sum(axis=0), self.moment.sum(axis=0) + turning)


def check_dt(dt: float) -> float:
    """A step size [s], positive and finite."""
    if isinstance(dt, bool) or not isinstance(dt, int | float) or not np.isfinite(dt) or dt <= 0.0:
        raise StepInputError(f"dt: expected a positive, finite number of seconds; got {dt!r}")
    return float(dt)


def check_array(name: str, given: ArrayLike, rows: int, columns: int) -> Array:
    """`given` as float64 of shape (rows, columns), all finite."""
    try:
        array = np.ascontiguousarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise StepInputError(f"{name}: expected an array of numbers of shape ({rows}, {columns})") from None
    if array.shape != (rows, columns):
        raise StepInputError(f"{name}: expected shape ({rows}, {columns}); got {array.shape}")
    if not np.isfinite(array).all():
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise StepInputError(f"{name}: expected finite numbers; got {array[row, column]} in row {row}, column {column}")
    return array


def no_wrenches(body_count: int) -> Wrenches:
    """Wrenches of bodies that no fluid touches."""
    return Wrenches(np.zeros((body_count, 3)), np.zeros((body_count, 3)))


def wrenches_given(wrenches: ArrayLike, body_count: int) -> Wrenches:
    """Wrenches (bodies, 6), force then moment about the centre of mass last sent."""
    array = check_array("wrenches", wrenches, body_count, 6)
    return Wrenches(array[:, :3].copy(), array[:, 3:].copy())


def wrenches_of_forces(forces: Mapping[str, ArrayLike], regions: Mapping[str, Region], sent: Sample) -> Wrenches:
    """Sums nodal forces [N], (n,3) per region, world frame; regions left out carry no force."""
    centres = sent.state.position
    result = no_wrenches(len(centres))
    checked = {}
    for name, given in forces.items():
        if name not in regions:
            raise StepInputError(f"forces: unknown region {name!r}; the regions are {', '.join(map(repr, regions))}")
        checked[name] = check_array(f'forces of region "{name}"', given, regions[name].vertex_count, 3)
    for name, nodal in checked.items():
        region = regions[name]
        count = len(region.rows)
        force, moment = np.empty((count, 3)), np.empty((count, 3))
        vertices = sent.vertices[name] if name in sent.vertices else region.vertices(sent.state)
        gather(nodal, vertices, region.first, region.count, centres[region.rows], force, moment, np.empty(6))
        if not (np.isfinite(force).all() and np.isfinite(moment).all()):
            raise StepInputError(f'forces of region "{name}": too large, their sum is not a finite number')
        result.force[region.rows], result.moment[region.rows] = force, moment
    return result
