"""Added mass: a force against the last known acceleration of a body, spread over its vertices.

    f = -m_a a,    a = (velocity last received - velocity before) / (step between them)

The acceleration is one exchange old, as in every explicit coupling. So an error of it is multiplied by -m_a / m per
step, whatever the step size: the exchange diverges for m_a > m (Causin, Gerbeau, Nobile 2005, *Added-mass effect in the
design of partitioned algorithms*; Foerster, Wall, Ramm 2007). Only translation is loaded; an impact's jump of velocity
counts as an acceleration, which the body feels one step later.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from comotion_mock_cfd.fluid import FluidError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from comotion_mock_cfd.bodies import BodyTable
    from comotion_mock_cfd.water_line import Floats


class AddedMass:
    """Added mass of the bodies of a run, and the velocities they had."""

    def __init__(self, table: BodyTable, mass_of: Mapping[str, float], twists: Floats) -> None:
        """Begin with bodies that do not accelerate.

        Args:
            table: the bodies of the run.
            mass_of: added mass [kg] by the name of a region (each of its bodies) or of a body, which wins.
            twists: of all bodies at the beginning [m/s, rad/s], shape (bodies, 6).
        """
        known = {*table.names, *table.region_of}
        if unknown := sorted(set(mass_of) - known):
            raise FluidError(
                f"fluid.added_mass: {unknown[0]!r} is neither a body nor a region; there are {sorted(known)}"
            )
        mass = [
            mass_of.get(name, mass_of.get(region, 0.0))
            for name, region in zip(table.names, table.region_of, strict=True)
        ]
        self._table = table
        self._mass = np.array(mass)
        self._twists = twists
        self._acceleration = np.zeros((len(mass), 3))

    def observe(self, twists: Floats, dt: float) -> None:
        """Take the bodies' twists (bodies, 6) after a step of dt [s]."""
        self._acceleration = (twists[:, :3] - self._twists[:, :3]) / dt
        self._twists = twists

    def add_to(self, forces: Mapping[str, Floats], vertices: Mapping[str, Floats], centres: Floats) -> None:
        """Add the forces of added mass to nodal forces per region [N], (n, 3) each, in place.

        Args:
            forces: the sums to add to.
            vertices: positions [m], (n, 3) per region, world.
            centres: centres of mass [m], shape (bodies, 3), world.
        """
        for body in np.flatnonzero(self._mass):
            region, part = self._table.region_of[body], self._table.part_of[body]
            arms = vertices[region][part] - centres[body]
            forces[region][part] += spread_force(-self._mass[body] * self._acceleration[body], arms)


def spread_force(force: Floats, arms: Floats) -> Floats:
    """Nodal forces [N], shape (n, 3), with a given sum and no moment: the ones of least sum of squares.

    The conditions sum f_i = F and sum r_i x f_i = 0 with Lagrange's multipliers give f_i = F / n + m x s_i, where s_i
    is the arm from the vertices' mean r0, and J m = -r0 x F with J = sum (s.s 1 - s s^T).

    Args:
        force: F [N], shape (3,).
        arms: r_i, vertices relative to the point without moment (the centre of mass) [m], shape (n, 3).
    """
    mean = arms.mean(axis=0)
    around = arms - mean
    spread = np.vdot(around, around) * np.eye(3) - around.T @ around
    turn = np.linalg.solve(spread, -np.cross(mean, force))  # regular: the vertices of a closed body are in no line
    return force / len(arms) + np.cross(turn, around)
