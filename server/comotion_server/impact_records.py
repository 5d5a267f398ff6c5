"""What the event queue wrote down of impacts, as a step gives it back."""

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.impact_log import ROWS, ImpactLog
from comotion_server.results import Impact
from comotion_server.scene import Collisions
from comotion_server.touching import Pair, SoftImpact


def impacts_of(log: ImpactLog, settings: Collisions, names: tuple[str, ...], start_time: float) -> list[Impact]:
    """The contact points of all impacts of a step that began at `start_time` [s]."""
    count = log.total[ROWS]
    if count == 0:
        return []
    points, normals, impulses = (rows[:count].copy() for rows in (log.point, log.normal, log.impulse))
    along = np.einsum("ij,ij->i", impulses, normals)
    rubs = settings.friction > 0.0 or any(settings.material_frictions.values())
    return [
        Impact(start_time + time, names[a], names[b], point, normal, size, approach, e, settings.simultaneous, slip)
        for (a, b), time, point, normal, size, approach, e, slip in zip(
            log.bodies[:count].tolist(),
            log.contact_time[:count].tolist(),
            points,
            normals,
            along.tolist(),
            log.approach[:count].tolist(),
            log.restitution[:count].tolist(),
            impulses - along[:, None] * normals if rubs else [None] * count,
            strict=True,
        )
    ]


def totals_of(log: ImpactLog) -> dict[Pair, tuple[NDArray[np.float64], int]]:
    """Of each pair of bodies that had impacts: the sum of its impulses (3,) on b [N s], and how many impacts."""
    found: dict[Pair, tuple[float, float, float, int, float]] = {}
    count = log.total[ROWS]
    rows = zip(log.bodies[:count].tolist(), log.time[:count].tolist(), log.impulse[:count].tolist(), strict=True)
    for (a, b), time, (px, py, pz) in rows:
        x, y, z, impacts, last = found.get((a, b), (0.0, 0.0, 0.0, 0, None))
        found[a, b] = x + px, y + py, z + pz, impacts + (last != time), time
    return {pair: (np.array([x, y, z]), impacts) for pair, (x, y, z, impacts, _) in found.items()}


def soft_impacts_of(soft: list[SoftImpact], names: tuple[str, ...], start_time: float) -> list[Impact]:
    """Contacts that closed with e = 0 to come to rest."""
    found = []
    for impact in soft:
        a, b = impact.pair
        point, normal, size, speed = impact.point, impact.normal, impact.impulse, impact.approach
        time = start_time + impact.time
        found.append(Impact(time, names[a], names[b], point, normal, size, speed, 0.0, "soft"))
    return found
