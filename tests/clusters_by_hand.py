"""Clusters of bodies and contacts made by hand, given straight to the impact law."""

from dataclasses import dataclass, field

import numpy as np

from comotion_server.kernels.contacts import POINTS, new_contacts
from comotion_server.kernels.flight import SPIN_FREE, SPIN_GIVEN, SPIN_NONE, Bodies
from comotion_server.kernels.impact_cluster import TOGETHER, collide, new_report


@dataclass
class Clump:
    """Bodies and contacts in the making; n rows of bodies, c of contacts."""

    mass: list = field(default_factory=list)
    moments: list = field(default_factory=list)
    reacts: list = field(default_factory=list)
    free: list = field(default_factory=list)
    spin: list = field(default_factory=list)
    v: list = field(default_factory=list)
    w: list = field(default_factory=list)
    R: list = field(default_factory=list)
    rows: list = field(default_factory=list)
    restitution: list = field(default_factory=list)
    friction: list = field(default_factory=list)

    def body(
        self, mass=1.0, moments=(1.0, 1.0, 1.0), v=(0, 0, 0), w=(0, 0, 0), *, free=(1, 1, 1), spin=SPIN_FREE, R=None
    ):
        for column, value in (
            (self.mass, mass),
            (self.moments, np.sort(np.asarray(moments, float))),
            (self.reacts, True),
            (self.free, np.asarray(free, float)),
            (self.spin, spin),
            (self.v, np.asarray(v, float)),
            (self.w, np.asarray(w, float)),
            (self.R, np.eye(3) if R is None else R),
        ):
            column.append(value)
        return len(self.mass) - 1

    def given(self, v=(0, 0, 0), w=(0, 0, 0)):
        """A body that does not react: fixed or prescribed."""
        row = self.body(1.0, (1.0, 1.0, 1.0), v, w, free=(0, 0, 0), spin=SPIN_GIVEN)
        self.reacts[row] = False
        return row

    def ball(self, v, mass=1.0):
        """A body that cannot turn."""
        return self.body(mass, v=v, spin=SPIN_NONE)

    def touch(self, a, b, normal, e, arm_a=(0, 0, 0), arm_b=(0, 0, 0), mu=0.0):
        n = np.asarray(normal, float)
        self.rows.append((a, b, n / np.linalg.norm(n), np.asarray(arm_a, float), np.asarray(arm_b, float)))
        self.restitution.append(e)
        self.friction.append(mu)

    def arrays(self):
        n = len(self.mass)
        moments = np.array(self.moments, float).reshape(n, 3)
        inverse = np.array(self.free).reshape(n, 3) / np.array(self.mass)[:, None]
        inverse[~np.array(self.reacts)] = 0.0
        bodies = Bodies(
            moments,
            np.tile(np.eye(3), (n, 1, 1)),
            np.array(self.spin, np.int64),
            inverse,
            np.zeros((n, 3)),
            np.array(self.reacts, np.bool_),
        )
        v, w, R = np.array(self.v).reshape(n, 3), np.array(self.w).reshape(n, 3), np.array(self.R).reshape(n, 3, 3)
        L = np.zeros((n, 3))
        for i in range(n):
            spin = self.spin[i]
            inertia = R[i] @ np.diag(moments[i]) @ R[i].T
            if spin == SPIN_FREE:
                L[i] = inertia @ w[i]
            elif spin >= 0:
                L[i, spin] = inertia[spin, spin] * w[i, spin]
        contacts = new_contacts(max(len(self.rows), 1))
        for i, (a, b, normal, arm_a, arm_b) in enumerate(self.rows):
            contacts.bodies[i], contacts.kind[i], contacts.feature[i] = (a, b), POINTS, -1
            contacts.normal[i], contacts.arm_a[i], contacts.arm_b[i], contacts.gap[i] = normal, arm_a, arm_b, 0.0
        return bodies, contacts, v.copy(), R.copy(), L, w.copy()


@dataclass
class Outcome:
    status: int
    v: np.ndarray
    L: np.ndarray
    w: np.ndarray
    impulse: np.ndarray
    report: object
    growth: float  # of the energy of reacting bodies
    scale: float  # the larger of that energy before and after


def energy_of(bodies, v, L, w):
    """Kinetic energy of what impacts can change."""
    total = 0.0
    for i in range(len(v)):
        if bodies.reacts[i]:
            W = bodies.inverse_mass[i]
            total += 0.5 * np.sum(v[i, W > 0] ** 2 / W[W > 0])
            if bodies.spin[i] == SPIN_FREE:
                total += 0.5 * L[i] @ w[i]
            elif bodies.spin[i] >= 0:
                total += 0.5 * L[i, bodies.spin[i]] * w[i, bodies.spin[i]]
    return total


def answer(clump, law=TOGETHER):
    """The clump after its impact."""
    bodies, contacts, v, R, L, w = clump.arrays()
    count = len(clump.rows)
    before = energy_of(bodies, v, L, w)
    impulse, report = np.zeros((count, 3)), new_report(count)
    e, mu = np.array(clump.restitution, float), np.array(clump.friction, float)
    status = collide(bodies, contacts, count, e, mu, law, v, R, L, w, impulse, report)
    after = energy_of(bodies, v, L, w)
    return Outcome(status, v, L, w, impulse, report, after - before, max(before, after))


def line(speeds, e, masses=None):
    """Touching balls along x."""
    clump = Clump()
    for i, speed in enumerate(speeds):
        clump.ball((speed, 0, 0), 1.0 if masses is None else masses[i])
    for i in range(len(speeds) - 1):
        clump.touch(i, i + 1, (1, 0, 0), e)
    return clump
