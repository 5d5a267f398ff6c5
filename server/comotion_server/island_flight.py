"""How an island goes on from where its contacts are settled: on a flight as long as it is true."""

import numpy as np

from comotion_server.island import Island
from comotion_server.kernels.contacts import Contacts
from comotion_server.kernels.flight import fly_rows
from comotion_server.kernels.held_flight import STAGES, Course, new_course, straying, try_flight
from comotion_server.kernels.impact_cluster import BLOCKED, SOLVED
from comotion_server.resting import Resting
from comotion_server.touching import Touching

TURN = 0.02  # [rad] per sub-step at most; larger: contact forces are less well known on the way
STRAY = 0.125  # of delta: how far a flight may stray from its contacts on the way; above 0.4 they touch
ATTEMPTS = 60  # to find the length of a sub-step before it is taken as it is
SHORTEST = 1e-6  # of the first length tried: what has no motion for so long is blocked
LOCATED = 1e-7  # of the first length tried: how well is found where a contact parts or slides off
SLID = 1e-9  # of a body's size: how far beyond its face a point may be where it is found to have slid off
PARTED = 1e-3  # of the speed of a hop as high as delta: how fast a contact may open where it is found to have parted
STEADY = 1e-12  # of the free acceleration: what is left of less counts as none
STILL = 1e-9  # of the speed of a hop as high as delta: slower bodies stand still


def fly(rest: Resting, touching: Touching, time: float, until: float) -> Island | None:
    """An island on a flight as long as it is true, to `until` [s] at most; None where none is found."""
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
        if status != SOLVED:
            rest.possible(status, contacts, certificate)
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
    x, R, flown = scene.x[members].copy(), scene.R[members].copy(), [array[members] for array in scene.flights]
    fly_rows(island.touched, scene.flights, scene.bodies, island.begin, *rest.state)
    count = len(island.push)
    course, contacts = new_course(len(members), count), Contacts(*(column.copy() for column in island.contacts))
    status = try_flight(
        scene.solids, scene.flights, scene.bodies, contacts, count, members, island.touched, rest.free, island.begin,
        time - island.begin, rest.state, rest.trial, course, np.zeros(count, dtype=np.bool_), rest.room,
    )  # fmt: skip
    if status == SOLVED:
        island.course, island.end = course, time
    else:
        for array, kept in zip(scene.flights, flown, strict=True):
            array[members] = kept
    fly_rows(island.touched, scene.flights, scene.bodies, time, *rest.state)
    scene.x[members], scene.R[members] = x, R


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


def stands(rest: Resting, island: Island, touching: Touching) -> bool:
    """Whether nothing moves."""
    if touching.count == 0:
        return False
    scene, rows = rest.scene, island.members
    pull = float(np.linalg.norm(rest.acceleration[rows], axis=1).max())
    slow = STILL * np.sqrt(2.0 * pull * float(touching.delta.min()))
    turning = scene.solids.radius[rows] * np.linalg.norm(scene.w[rows], axis=1)
    return bool((np.linalg.norm(scene.v[rows], axis=1) + turning <= slow).all()) and rest.others_stand(island)


def _is_still(rest: Resting, island: Island, course: Course, touching: Touching) -> bool:
    """Whether nothing moves, and no force moves it."""
    scene, rows = rest.scene, island.members
    if not stands(rest, island, touching):
        return False
    pull = float(np.linalg.norm(rest.acceleration[rows], axis=1).max())
    lightness = np.maximum(scene.bodies.inverse_mass[rows].max(axis=1), 1e-300)
    weight = pull / lightness * scene.solids.radius[rows]
    acceleration, torque = (np.linalg.norm(k[0], axis=1) for k in (course.acceleration, course.torque))
    return bool((acceleration <= STEADY * pull).all() and (torque <= STEADY * weight).all())
