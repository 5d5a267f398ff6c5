"""How an island goes on where flights do not serve: by time-stepping, of first order (docs/rest.md, 5)."""

import numpy as np
from numpy.typing import NDArray

from comotion_server.island import Island
from comotion_server.island_flight import STRAY, stands
from comotion_server.judging import coming_up
from comotion_server.kernels.flight import fly_rows
from comotion_server.kernels.held_contacts import gaps_at, kinetic_energy, opening_speeds
from comotion_server.kernels.held_flight import correct
from comotion_server.kernels.impact_cluster import TOGETHER, collide, new_report, settle_velocities
from comotion_server.resting import Resting
from comotion_server.touching import Touching, approach_of

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

SHORTER = 6  # times a quarter: how much a step of time-stepping is shortened for contacts that are yet to close
LOOKS = 12  # at the gaps on the way, in a step of time-stepping
LATER = 10  # times at which that is done
GAIN = 1e-5  # of their kinetic energy: more than bodies may be given in advance for the turning of their contacts


def stride(rest: Resting, touching: Touching, time: float, h: float) -> Island | None:
    """`step` with an eye to contacts farther apart than delta: they may close within `h` [s], and no more.

    Where not all of that can be, the step is shorter, in the end without them.
    """
    for turn in range(SHORTER):
        island = step(rest, touching, time, h * 0.25**turn, ahead=True)
        if island is not None:
            return island
    return step(rest, touching.of(touching.near), time, h)


def step(rest: Resting, touching: Touching, time: float, h: float, *, ahead: bool = False) -> Island | None:
    """An island on a step `h` [s] of first order at constant velocities: those at its end.

    (Moreau 1988; Jean 1999.) Contacts that close stop at once; then come the forces, and contacts against them, as far
    as the step gets. `ahead`: both so that nothing is hit on the way. None where no motion is possible: velocities are
    as before then.
    """
    scene, members = rest.scene, touching.members
    nothing = np.zeros_like(rest.force)
    before = tuple(array[members].copy() for array in (scene.v, scene.L, scene.w))
    touching, at_once = _answer(rest, touching, time, h, ahead=ahead)
    start, hit = (scene.v[members].copy(), scene.L[members].copy()), touching.contacts.bodies
    impulse = None
    if at_once is not None:
        correct(scene.bodies, members, _gains_of_forces(rest, members, h), rest.state)
        touching, impulse = _answer(rest, touching, time, h, ahead=ahead)
    if at_once is None or impulse is None:
        for array, values in zip((scene.v, scene.L, scene.w), before, strict=True):
            array[members] = values
        return None
    rest.record.add_held(hit, at_once)
    rest.begin(members, nothing, nothing, time)
    island = Island(members, touching.bodies, touching.contacts, None, time, time + h, impulse / h)
    island.asleep = stands(rest, island, touching)
    island.change = scene.v[members] - start[0], scene.L[members] - start[1]
    return island


def _answer(rest: Resting, touching: Touching, time: float, h: float, *, ahead: bool) -> tuple[Touching, Array | None]:
    """What contacts do about velocities: all that count, impulses (c,3) on b [N s]; None where that is impossible."""
    impulse = _stop(rest, touching)
    if impulse is None or not ahead:
        return touching, impulse
    return _slow_down(rest, touching, impulse, time, h)


def _gains_of_forces(rest: Resting, members: Rows, h: float) -> tuple[Array, Array]:
    """What velocities and angular momenta (k,3) get in `h` [s] from all forces but those of contacts."""
    return h * rest.scene.bodies.inverse_mass[members] * rest.force[members], h * rest.torque[members]


def _stop(rest: Resting, touching: Touching) -> Array | None:
    """Contacts within delta close no more: impulses (c,3) on b [N s], of others none; None where that is impossible."""
    scene, closed, impulse = rest.scene, touching.of(touching.near), np.zeros((touching.count, 3))
    count = closed.count
    taken, report = np.zeros((count, 3)), new_report(count)
    parts = (scene.bodies, closed.contacts, count, np.zeros(count), closed.friction, TOGETHER)
    status = collide(*parts, scene.v, scene.R, scene.L, scene.w, taken, report)
    impulse[touching.near] = taken
    return impulse if rest.possible(status, closed.contacts, report.certificate[:count]) else None


def _slow_down(
    rest: Resting, touching: Touching, impulse: Array, time: float, h: float
) -> tuple[Touching, Array | None]:
    """No contact is closer than the middle of delta `h` [s] later, or than it is: all impulses; None where impossible.

    Gaps are not linear in time: they are looked up on the way, and what they lack is added to the speeds. Contacts
    that come up on the way are added to the others.
    """
    scene, nothing = rest.scene, np.zeros_like(rest.force)
    opening = np.minimum(0.5 * touching.delta - touching.contacts.gap, 0.0) / h
    before, given = kinetic_energy(scene.bodies, touching.members, scene.v, scene.L, scene.w), 0.0
    for _ in range(LOOKS):
        contacts, count = touching.contacts, touching.count
        push, exactly, certificate = np.zeros(count), np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
        parts = (scene.bodies, contacts, count, exactly, opening)
        status = settle_velocities(*parts, scene.v, scene.R, scene.L, scene.w, push, certificate)
        if not rest.possible(status, contacts, certificate):
            return touching, None
        impulse = impulse + push[:, None] * contacts.normal
        pushed = np.flatnonzero(push)
        given += float(push[pushed] @ approach_of(scene, contacts, pushed, ~scene.bodies.reacts))
        most = before + given + GAIN * (before + abs(given))
        if kinetic_energy(scene.bodies, touching.members, scene.v, scene.L, scene.w) > most:
            return touching, None
        rest.begin(touching.members, nothing, nothing, time)
        lack = _lack(rest, touching, time, h)
        speed, scale = np.empty(count), np.empty(count)
        opening_speeds(scene.solids, touching.copy(), count, rest.state, speed, scale)
        opening = np.where(lack > 0.0, speed + lack, opening)
        found = coming_up(rest, touching, np.setdiff1d(touching.pair, touching.pair[lack > 0.0]), time, h)
        if not lack.any() and found.count == 0:
            break
        touching, impulse = touching.joined(found), np.concatenate([impulse, np.zeros((found.count, 3))])
        opening = np.concatenate([opening, np.minimum(0.5 * found.delta - found.contacts.gap, 0.0) / h])
    return touching, impulse


def _lack(rest: Resting, touching: Touching, time: float, h: float) -> Array:
    """How much faster contacts (c,) would have to open [m/s] not to be too close in the next `h` [s]."""
    scene, after, lack = rest.scene, np.empty(touching.count), np.zeros(touching.count)
    least = np.minimum(0.5 * touching.delta, touching.contacts.gap)
    for later in h * np.linspace(1.0, 0.0, LATER, endpoint=False):
        fly_rows(touching.bodies, scene.flights, scene.bodies, time + later, *rest.trial)
        gaps_at(scene.solids, touching.copy(), touching.count, rest.trial, after)
        misses = least - after
        lack = np.where(misses > STRAY * touching.delta, np.maximum(lack, misses / later), lack)
    return lack
