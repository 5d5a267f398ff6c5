"""What the event queue wrote down of impacts, as a step gives it back."""

import numpy as np
from numpy.typing import NDArray

from comotion_server.kernels.impact_log import ROWS, ImpactLog
from comotion_server.results import Impact
from comotion_server.scene import Collisions
from comotion_server.touching import Pair, SoftImpact


def impacts_of(log: ImpactLog, settings: Collisions, names: tuple[str, ...], start_time: float) -> list[Impact]:
    """The contact points of all impacts of a step that began at `start_time` [s]."""
    impacts = []
    rubs = settings.friction > 0.0 or any(settings.material_frictions.values())
    for i in range(log.total[ROWS]):
        a, b = log.bodies[i].tolist()
        normal, impulse = log.normal[i].copy(), log.impulse[i]
        along = float(impulse @ normal)
        impacts.append(
            Impact(
                start_time + float(log.contact_time[i]),
                names[a],
                names[b],
                log.point[i].copy(),
                normal,
                along,
                float(log.approach[i]),
                float(log.restitution[i]),
                settings.simultaneous,
                impulse - along * normal if rubs else None,
            )
        )
    return impacts


def totals_of(log: ImpactLog) -> dict[Pair, tuple[NDArray[np.float64], int]]:
    """Of each pair of bodies that had impacts: the sum of its impulses (3,) on b [N s], and how many impacts."""
    found: dict[Pair, tuple[NDArray[np.float64], int]] = {}
    last: dict[Pair, float] = {}
    count = log.total[ROWS]
    for (a, b), time, impulse in zip(log.bodies[:count].tolist(), log.time[:count].tolist(), log.impulse, strict=False):
        total, impacts = found.get((a, b), (np.zeros(3), 0))
        found[a, b] = total + impulse, impacts + (last.get((a, b)) != time)
        last[a, b] = time
    return found


def soft_impacts_of(soft: list[SoftImpact], names: tuple[str, ...], start_time: float) -> list[Impact]:
    """Contacts that closed with e = 0 to come to rest."""
    found = []
    for impact in soft:
        a, b = impact.pair
        point, normal, size, speed = impact.point, impact.normal, impact.impulse, impact.approach
        time = start_time + impact.time
        found.append(Impact(time, names[a], names[b], point, normal, size, speed, 0.0, "soft"))
    return found
