"""How an island goes on from where its contacts are settled: on a flight as long as it is true, or by time-stepping."""

import numpy as np
from numpy.typing import NDArray

from comotion_server.island import Island
from comotion_server.judging import coming_up
from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.flight import fly_rows
from comotion_server.kernels.held_contacts import gaps_at, opening_speeds
from comotion_server.kernels.held_flight import STAGES, Course, correct, new_course, straying, try_flight
from comotion_server.kernels.impact_cluster import BLOCKED, SOLVED, TOGETHER, collide, new_report, settle_velocities
from comotion_server.resting import Resting
from comotion_server.touching import Touching

Array = NDArray[np.float64]

TURN = 0.02  # [rad] per sub-step at most; larger: contact forces are less well known on the way
STRAY = 0.125  # of delta: how far a flight may stray from its contacts on the way; above 0.4 they touch
LOOKS = 12  # at the gaps on the way, in a step of time-stepping
LATER = 10  # times at which that is done
SHORTER = 6  # times a quarter: how much a step of time-stepping is shortened for contacts that are yet to close
ATTEMPTS = 60  # to find the length of a sub-step before it is taken as it is
SHORTEST = 1e-6  # of the first length tried: what has no motion for so long is blocked
LOCATED = 1e-7  # of the first length tried: how well is found where a contact parts or slides off
SLID = 1e-9  # of a body's size: how far beyond its face a point may be where it is found to have slid off
PARTED = 1e-3  # of the speed of a hop as high as delta: how fast a contact may open where it is found to have parted
STEADY = 1e-12  # of the free acceleration: what is left of less counts as none
STILL = 1e-9  # of the speed of a hop as high as delta: slower bodies stand still


def fly(rest: Resting, touching: Touching, time: float, until: float) -> Island | None:
    """An island on a flight as long as it is true, to `until` [s] at most; None where no motion is possible."""
    scene, count, members = rest.scene, touching.count, touching.members
    bodies = touching.bodies
    spin = float(np.linalg.norm(scene.w[bodies], axis=1).max())
    h = first = min(until - time, TURN / spin) if spin > 0.0 else until - time
    free, certificate = rest.free, np.zeros(count, dtype=np.bool_)
    low, high = 0.0, np.inf  # until the first no contact parts, until the second one does
    for _ in range(ATTEMPTS):
        course, contacts = new_course(len(members), count), touching.copy()
        status = try_flight(
            scene.solids, scene.flights, scene.bodies, contacts, count, members, bodies, free, time, h,
            rest.state, rest.trial, course, certificate, rest.room,
        )  # fmt: skip
        if status == BLOCKED and h > SHORTEST * first:  # on the way, where contacts have gone past each other
            h *= 0.25
            continue
        if not rest.possible(status, contacts, certificate):
            rest.begin(members, rest.acceleration, rest.torque, time)
            return None
        stray = straying(scene.bodies, contacts, count, members, course, h, scene.R)
        limit = STRAY * float(touching.delta.min())
        if stray > limit:
            h *= max(0.1, 0.9 * (limit / stray) ** (1.0 / 3.0))
            continue
        parts, guess = _parting(rest, touching, course, h)
        if parts:
            high = h
        else:
            low = h
        if parts == (high - low <= LOCATED * first) or high == np.inf:
            break
        found = high - low <= LOCATED * first
        h = high if found else min(max(guess, 0.95 * low + 0.05 * high), 0.05 * low + 0.95 * high)
    push = course.force[0][:, None] * course.normal[0]
    island = Island(members, bodies, touching.contacts, course, time, time + h, push)
    island.asleep = _is_still(rest, island, course, touching)
    return island


def fly_again(rest: Resting, island: Island, time: float) -> None:
    """A flight that ends early, at `time` [s], with the length it has: its velocities are of fourth order then.

    Bodies stay where the flight has brought them, as others have met them there.
    """
    scene, members = rest.scene, island.members
    x, R = scene.x[members].copy(), scene.R[members].copy()
    fly_rows(island.touched, scene.flights, scene.bodies, island.begin, *rest.state)
    count = len(island.push)
    course, contacts = new_course(len(members), count), Contacts(*(column.copy() for column in island.contacts))
    status = try_flight(
        scene.solids, scene.flights, scene.bodies, contacts, count, members, island.touched, rest.free, island.begin,
        time - island.begin, rest.state, rest.trial, course, np.zeros(count, dtype=np.bool_), rest.room,
    )  # fmt: skip
    if status == SOLVED:
        island.course, island.end = course, time
    fly_rows(island.touched, scene.flights, scene.bodies, time, *rest.state)
    scene.x[members], scene.R[members] = x, R


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
    """An island on a step `h` [s] of first order at constant velocities: forces first, then contacts with e = 0.

    (Moreau 1988; Jean 1999.) `ahead`: such that nothing is hit on the way. None where no motion is possible: velocities
    are as before then.
    """
    scene, members = rest.scene, touching.members
    ease, nothing = scene.bodies.inverse_mass[members], np.zeros_like(rest.force)
    before = tuple(array[members].copy() for array in (scene.v, scene.L, scene.w))
    scene.v[members] += h * ease * rest.force[members]
    scene.L[members] += h * rest.torque[members]
    correct(scene.bodies, members, (np.zeros((len(members), 3)), np.zeros((len(members), 3))), rest.state)
    impulse = _stop(rest, touching)
    if impulse is not None and ahead:
        touching, impulse = _slow_down(rest, touching, impulse, time, h)
    if impulse is None:
        for array, values in zip((scene.v, scene.L, scene.w), before, strict=True):
            array[members] = values
        return None
    rest.begin(members, nothing, nothing, time)
    island = Island(members, touching.bodies, touching.contacts, None, time, time + h, impulse / h)
    island.asleep = _stands(rest, island, touching)
    return island


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
    for _ in range(LOOKS):
        contacts, count = touching.contacts, touching.count
        push, exactly, certificate = np.zeros(count), np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
        parts = (scene.bodies, contacts, count, exactly, opening)
        status = settle_velocities(*parts, scene.v, scene.R, scene.L, scene.w, push, certificate)
        if not rest.possible(status, contacts, certificate):
            return touching, None
        impulse = impulse + push[:, None] * contacts.normal
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


def _parting(rest: Resting, touching: Touching, course: Course, h: float) -> tuple[bool, float]:
    """Whether a contact has parted or slid off by the end of a sub-step `h` [s], and about when [s]."""
    last, half = STAGES - 1, 1
    slack = SLID * 2.0 * rest.scene.solids.radius[touching.contacts.bodies].min(axis=1)
    loaded, guesses = course.force[0] > 0.0, [0.5 * h]
    slides = loaded & (course.margin[0] > 0.0) & (course.margin[last] < -slack)
    if slides.any():
        m1, m2 = (course.margin[stage][slides] + 0.5 * slack[slides] for stage in (half, last))
        fall = np.where(m1 > m2, m1 - m2, np.inf)
        guesses.append(float((0.5 * h * (1.0 + m1 / fall)).min()))
    pull = float(np.linalg.norm(rest.acceleration[touching.members], axis=1).max())
    parts = loaded & (course.force[last] == 0.0)
    parts &= course.speed[last] > PARTED * np.sqrt(2.0 * pull * touching.delta)
    if parts.any():
        f0, f1 = course.force[0][parts], course.force[half][parts]
        fall = np.where((f1 > 0.0) & (f1 < f0), f0 - f1, np.inf)
        guesses.append(float((0.5 * h * f0 / fall).min()))
    guess = min(guesses[1:], default=guesses[0])
    return bool(slides.any() or parts.any()), guess


def _stands(rest: Resting, island: Island, touching: Touching) -> bool:
    """Whether nothing moves."""
    scene, rows = rest.scene, island.members
    pull = float(np.linalg.norm(rest.acceleration[rows], axis=1).max())
    slow = STILL * np.sqrt(2.0 * pull * float(touching.delta.min()))
    turning = scene.solids.radius[rows] * np.linalg.norm(scene.w[rows], axis=1)
    return bool((np.linalg.norm(scene.v[rows], axis=1) + turning <= slow).all()) and rest.others_stand(island)


def _is_still(rest: Resting, island: Island, course: Course, touching: Touching) -> bool:
    """Whether nothing moves, and no force moves it."""
    scene, rows = rest.scene, island.members
    if not _stands(rest, island, touching):
        return False
    pull = float(np.linalg.norm(rest.acceleration[rows], axis=1).max())
    lightness = np.maximum(scene.bodies.inverse_mass[rows].max(axis=1), 1e-300)
    weight = pull / lightness * scene.solids.radius[rows]
    acceleration, torque = (np.linalg.norm(k[0], axis=1) for k in (course.acceleration, course.torque))
    return bool((acceleration <= STEADY * pull).all() and (torque <= STEADY * weight).all())
