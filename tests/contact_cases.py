"""Random pairs of moving bodies whose contact is asked for, by family, and an independent truth.

The truth samples whether the surfaces intersect, densely over the whole interval, and halves the first interval that
begins apart and ends in intersection. It may overlook a brush between two samples, but what it finds is there.
"""

from typing import NamedTuple

import numpy as np
from meshes_by_hand import l_shape, torus
from triangle_families import turn

from comotion_server.geometry.motion import Motion, flights_of
from comotion_server.kernels.jit import jit
from comotion_server.kernels.mesh_pair import closest_points
from comotion_server.kernels.motion_bounds import relate, settle, take_over
from comotion_server.kernels.pair_window import new_work
from comotion_server.meshes import TriangleMesh, box
from comotion_server.meshes.mesh_store import MeshStore


class Case(NamedTuple):
    """Two bodies and how they move from time 0 to t_max [s]; how often to look at them."""

    a: TriangleMesh
    motion_a: Motion
    b: TriangleMesh
    motion_b: Motion
    t_max: float
    samples: int

    @property
    def query(self):
        """What `time_of_impact` is given."""
        return self[:5]


CUBE, SLAB, BEAM = box([1.0, 1.0, 1.0]), box([1.4, 1.0, 0.3]), box([0.2, 0.3, 2.0])
ELL, RING, SMALL_RING = l_shape(), torus(16, 8), torus(12, 6, radius=0.8, tube=0.2)
WALL, BULLET, ROD = box([4.0, 4.0, 1e-3]), box([0.01, 0.01, 0.03]), box([2.0, 0.02, 0.02])


def _top(rng):
    """Inertia of some body of unit mass: any three moments that obey the triangle inequality, any axes."""
    squares, R = rng.uniform(0.05, 1.0, size=3), turn(rng)
    return R @ np.diag(squares.sum() - squares) @ R.T


def _rotation(rng, speed):
    """Keywords of a motion: a held angular velocity, a free top, or one under torque."""
    kind, w = rng.integers(4), speed * rng.normal(size=3)
    if kind == 0:
        return {"angular_velocity": w}
    if kind == 1:
        return {"angular_velocity": w, "inertia": np.diag([0.3, 0.3, 0.5])}
    torque = rng.normal(size=3) * speed**2 * 0.3 if kind == 3 else np.zeros(3)
    return {"angular_velocity": w, "inertia": _top(rng), "torque": torque}


def _thrown(rng, a, b, apart, t_max, samples):
    """Two tumbling bodies, `apart` from each other, that roughly head for each other."""
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    aim = rng.normal(size=3) - 1.5 * n
    motion_a = Motion((turn(rng), rng.normal(size=3)), rng.normal(size=3), **_rotation(rng, 2.0))
    motion_b = Motion(
        (turn(rng), motion_a.pose[1] + apart * n),
        motion_a.velocity + aim,
        acceleration=rng.normal(size=3) if rng.random() < 0.5 else np.zeros(3),
        **_rotation(rng, 2.0),
    )
    return Case(a, motion_a, b, motion_b, t_max, samples)


def convex(rng):
    a, b = (rng.choice([CUBE, SLAB, BEAM]) for _ in range(2))
    return _thrown(rng, a, b, rng.uniform(2.2, 4.0), 2.0, 1500)


def ell(rng):
    return _thrown(rng, ELL, rng.choice([ELL, BEAM, SLAB]), rng.uniform(3.2, 5.0), 2.0, 1500)


def linked(rng):
    """Two rings through each other."""
    motion_a = Motion((np.eye(3), np.zeros(3)), 0.3 * rng.normal(size=3), **_rotation(rng, 1.0))
    across = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    place = np.array([1.0, 0, 0]) + 0.1 * rng.normal(size=3)
    motion_b = Motion((across, place), 0.3 * rng.normal(size=3), **_rotation(rng, 1.0))
    return Case(RING, motion_a, SMALL_RING, motion_b, 2.0, 800)


def bullet(rng):
    """1000 m/s at a wall of 1 mm, from any side, spinning."""
    R, n = turn(rng), rng.normal(size=3)
    speed = 1000.0 * n / np.linalg.norm(n)
    at = R @ np.array([*rng.uniform(-2.1, 2.1, size=2), 0.0])
    duration = 0.01
    motion_a = Motion((R, np.zeros(3)), **({} if rng.random() < 0.5 else {"angular_velocity": rng.normal(size=3)}))
    rotation = {"angular_velocity": 100.0 * rng.normal(size=3)}
    motion_b = Motion((turn(rng), at - speed * duration * rng.uniform(0.2, 0.8)), speed, **rotation)
    return Case(WALL, motion_a, BULLET, motion_b, duration, 30_000)


def fast_spin(rng):
    """A rod at 1e5 rad/s that drifts towards a box."""
    spin = rng.normal(size=3)
    spin *= 1e5 / np.linalg.norm(spin)
    kind = {"angular_velocity": spin}
    if rng.random() < 0.5:
        kind["inertia"] = np.diag([0.004, 0.33, 0.33] if rng.random() < 0.5 else [0.3, 0.33, 0.4])
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    motion_a = Motion((turn(rng), np.zeros(3)), **kind)
    motion_b = Motion((turn(rng), 2.5 * n), -5000.0 * n + 500.0 * rng.normal(size=3))
    return Case(ROD, motion_a, CUBE, motion_b, 5e-4, 6000)


FAMILIES = {"convex": convex, "ell": ell, "linked": linked, "bullet": bullet, "fast spin": fast_spin}


@jit
def _distance(m, flights, bodies, t, witness, work):
    relative = relate(flights, bodies, t, work.states, work.R)
    last = m.size.shape[0] - 1
    d, _, _, _, witness[0], witness[1] = closest_points(
        m, 0, last, work.R, relative.offset, np.inf, witness[0], witness[1], work.walk
    )
    return d


@jit
def _first_intersection(m, flights, bodies, t_max, samples, work):
    """(time just before, time just after) the first intersection seen; (inf, inf): none."""
    witness = np.full(2, -1)
    before = 0.0
    take_over(flights, bodies, 0, 1, work.flights, work.bodies)
    flights, bodies = work.flights, work.bodies
    if _distance(m, flights, bodies, 0.0, witness, work) == 0.0:
        return 0.0, 0.0
    for k in range(1, samples + 1):
        t = t_max * k / samples
        if _distance(m, flights, bodies, t, witness, work) == 0.0:
            while True:
                middle = 0.5 * (before + t)
                if not before < middle < t:
                    return before, t
                if _distance(m, flights, bodies, middle, witness, work) == 0.0:
                    t = middle
                else:
                    before = middle
        before = t
        if k % 20 == 0:
            settle(flights, bodies, t, work.states)
    return np.inf, np.inf


class Truth:
    """What the independent way says about a case."""

    def __init__(self, case):
        self.case = case
        self._m = MeshStore.build([case.a, case.b]).arrays
        self._flights, self._bodies = flights_of((case.motion_a, case.motion_b))
        self._work = new_work()

    def contact(self):
        """Times [s] just before and just after the first intersection that sampling sees."""
        return _first_intersection(self._m, self._flights, self._bodies, self.case.t_max, self.case.samples, self._work)

    def distance(self, t):
        """Distance [m] of the surfaces at time t, 0 where they intersect; from no witness."""
        return _distance(self._m, self._flights, self._bodies, t, np.full(2, -1), self._work)


def faults(case, answer, tolerance):
    """What is wrong with an answer, in words; and whether there was a contact that does not graze."""
    truth = Truth(case)
    _, after = truth.contact()
    found = []
    if after == 0.0:
        return ([] if answer.status == "overlapping" else ["overlap not seen"]), False
    if answer.status == "none":
        return (["missed"] if after <= case.t_max else []), False
    if answer.status not in {"hit", "touching"}:
        return [f"ended {answer.status}"], False
    if answer.time >= after:
        found.append(f"late by {answer.time - after}")
    gap = truth.distance(answer.time)
    if not 0.0 < gap <= tolerance * (1 + 1e-3):
        found.append(f"gap {gap} of {tolerance}")
    speed = np.linalg.norm(np.subtract(case.motion_a.velocity, case.motion_b.velocity))
    steep = answer.closing_speed > 0.1 * speed
    if steep:
        late = answer.contact_time * (1.0 + 1e-9)
        early = answer.contact_time * (1.0 - 1e-9)
        if truth.distance(early) == 0.0 or truth.distance(late) > 0.0:
            found.append(f"contact time {answer.contact_time!r} but first intersection seen {after!r}")
    return found, steep
