"""Two bodies that bounce off each other for a long time: every query starts where the last one ended, in contact."""

from dataclasses import dataclass, field
from math import inf

import numpy as np

from comotion_server.geometry.motion import flights_of
from comotion_server.kernels.flight import begin, fly
from comotion_server.kernels.impact import impulse_of, push
from comotion_server.kernels.impact_query import (
    COUNTS,
    LONGEST,
    MEETS,
    NORMAL,
    POINT_A,
    POINT_B,
    TIME,
    TOUCHES,
    forget_flight,
    new_memory,
)
from comotion_server.kernels.mesh_pair import closest_points, work_space
from comotion_server.kernels.motion_bounds import relate
from comotion_server.kernels.pair_window import new_work
from comotion_server.kernels.time_of_impact import advance
from comotion_server.meshes.mesh_store import MeshStore

FLOOR = 3.0  # times the speed of a hop as high as the tolerance


@dataclass
class Story:
    """What happened: how queries ended, the least sampled gap [m], the most steps of one pair of triangles."""

    ends: list = field(default_factory=list)
    times: list = field(default_factory=list)
    gap: float = inf
    longest: int = 0
    counts: np.ndarray = None
    energy: float = 0.0


class TwoBodies:
    """Bodies of given masses (inf: does not react) on flights, row 0 and row 1."""

    def __init__(self, meshes, motions, masses, near, tolerance):
        self.m = MeshStore.build(meshes).arrays
        self.flights, self.bodies = flights_of(motions)
        self.bodies.inverse_mass[:] = 1.0 / np.array(masses)[:, None]
        self.bodies.reacts[:] = np.isfinite(masses)
        self.near, self.tolerance = near, tolerance
        self.x, self.v, self.R, self.L, self.w = (np.zeros((2, *s)) for s in ((3,), (3,), (3, 3), (3,), (3,)))
        self.work, self.walk = new_work(), work_space()
        (self.memory,), (self.witness,) = new_memory(1)
        self.place(0.0)

    def place(self, time):
        for i in range(2):
            fly(self.flights, self.bodies, i, time, self.x[i], self.v[i], self.R[i], self.L[i], self.w[i])

    def take_off(self, time):
        """Both go on from where they are at a time, on new flights."""
        self.place(time)
        for i in range(2):
            begin(self.flights, self.bodies, i, time, self.x[i], self.v[i], self.R[i], self.L[i], self.w[i])
        forget_flight(self.memory, time)

    def gap(self, time):
        relative = relate(self.flights, self.bodies, time, self.work.states, self.work.R)
        return closest_points(self.m, 0, 1, self.work.R, relative.offset, inf, *self.witness, self.walk)[0]

    def query(self, end, counts, key=inf):
        findings = np.empty(12)
        limits = (end, key, self.tolerance, self.near, 1_000_000)
        memory = (self.memory, self.witness, findings)
        status = advance(self.m, self.flights, self.bodies, 0, 1, 0, 1, *limits, *memory, self.work, counts)
        return status, findings

    def bounce(self, time, found, restitution):
        """Answers a contact with an impulse, and lets both bodies take off again."""
        self.place(time)
        p, q, n = (found[k : k + 3] for k in (POINT_A, POINT_B, NORMAL))
        parts = (self.bodies, 0, 1, self.x, self.v, self.R, self.w, p, q, n)
        size, speed, ease, _ = impulse_of(*parts, 0.0, False)  # noqa: FBT003
        size += max(restitution * speed, self.least_bounce()) / ease
        for i, sign in ((0, -1.0), (1, 1.0)):
            point = p if i == 0 else q
            push(self.bodies, i, self.x, self.v, self.R, self.L, self.w, point, sign * size * n, True)  # noqa: FBT003
            begin(self.flights, self.bodies, i, time, self.x[i], self.v[i], self.R[i], self.L[i], self.w[i])
        forget_flight(self.memory, time)

    def least_bounce(self):
        """Speed [m/s] of a hop that clears the tolerance: lower ones are rest, which is not the query's matter."""
        pull = np.linalg.norm(self.flights.acceleration[1] - self.flights.acceleration[0])
        pull += sum(0.5 * self.m.size[i] * self.w[i] @ self.w[i] for i in range(2))
        return FLOOR * np.sqrt(2.0 * pull * self.tolerance)

    def energy(self):
        total = 0.0
        for i in range(2):
            if self.bodies.reacts[i]:
                mass = 1.0 / self.bodies.inverse_mass[i, 0]
                total += 0.5 * mass * self.v[i] @ self.v[i] + 0.5 * self.w[i] @ self.L[i]
        return total

    def run(self, impacts, restitution, end, samples=6):
        story, last = Story(counts=np.zeros(COUNTS, np.int64)), 0.0
        for _ in range(impacts):
            status, found = self.query(end, story.counts)
            story.ends.append(status)
            time = self.memory[TIME]
            for k in range(1, samples + 1):
                story.gap = min(story.gap, self.gap(last + (time - last) * k / samples))
            if status not in {MEETS, TOUCHES}:
                break
            story.times.append(time - last)
            last = time
            self.bounce(time, found, restitution)
        story.longest = int(story.counts[LONGEST])
        self.place(self.memory[TIME])
        story.energy = self.energy()
        return story
