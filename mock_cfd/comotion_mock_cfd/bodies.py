"""The bodies of a run in the order of their names, and which vertices are theirs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.nodal import wrench_about

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from comotion_mock_cfd.water_line import Floats
    from comotion_protocol.messages import Region


@dataclass(frozen=True)
class BodyTable:
    """Names, regions and vertices of all bodies; rows of poses, twists and wrenches are in this order."""

    names: tuple[str, ...]
    region_of: tuple[str, ...]
    """Region of every body."""
    part_of: tuple[slice, ...]
    """Every body's vertices within its region."""

    @classmethod
    def of(cls, regions: Sequence[Region]) -> BodyTable:
        """The table of an open reply's regions."""
        members = [(body, region.name) for region in regions for body in region.bodies]
        members.sort(key=lambda member: member[0].name)
        return cls(
            names=tuple(body.name for body, _ in members),
            region_of=tuple(region for _, region in members),
            part_of=tuple(slice(body.first_vertex, body.first_vertex + body.vertex_count) for body, _ in members),
        )

    def wrenches(self, forces: Mapping[str, Floats], vertices: Mapping[str, Floats], centres: Floats) -> Floats:
        """Force [N] and moment about the centre of mass [N m] on every body, shape (bodies, 6), world.

        Args:
            forces: nodal forces [N], (n, 3) per region.
            vertices: where they act [m], (n, 3) per region.
            centres: centres of mass [m], shape (bodies, 3).
        """
        rows = zip(self.region_of, self.part_of, centres, strict=True)
        return np.array([wrench_about(centre, vertices[r][part], forces[r][part]) for r, part, centre in rows])
