"""Contact times of meshes with planes: closed forms, dense sampling, moving planes, restarts."""

from math import inf

import numpy as np
import pytest
from contact_cases import BEAM, CUBE, ELL, RING, SLAB
from triangle_families import turn

from comotion_server.geometry.motion import Motion, flights_of
from comotion_server.kernels.flight import fly
from comotion_server.kernels.impact_query import (
    CLOSING,
    CONTACT_TIME,
    COUNTS,
    FINDINGS,
    GAP,
    LATER,
    MEETS,
    NONE,
    NORMAL,
    OVERLAPS,
    POINT_A,
    POINT_B,
    STEPS,
    TIME,
    TOUCHES,
    new_memory,
)
from comotion_server.kernels.pair_window import new_work
from comotion_server.kernels.plane_impact import advance_plane
from comotion_server.kernels.time_of_impact import advance
from comotion_server.meshes import TriangleMesh
from comotion_server.meshes.mesh_store import MeshStore

TOLERANCE = 1e-9
CONTACT = 1e-12  # relative: rounding of angles and coordinates, a thousand times
UP = (0.0, 0.0, 1.0)
HALF = np.sqrt(0.5)
GROUND = Motion((np.eye(3), np.zeros(3)))
TRIAXIAL = np.diag([0.7, 1.0, 0.4])
ROTATIONS = {"held": {}, "triaxial top": {"inertia": TRIAXIAL}, "symmetric top": {"inertia": np.diag([0.7, 0.5, 0.5])}}


class Query:
    """A mesh and a plane; side 1: the plane is the second body."""

    def __init__(self, mesh, motion, plane=GROUND, normal=UP, side=1, tolerance=TOLERANCE):
        self.m, self.side, self.normal, self.tolerance = MeshStore.build([mesh]).arrays, side, normal, tolerance
        self.flights, self.bodies = flights_of((motion, plane) if side == 1 else (plane, motion))
        self.mesh, self.work, self.findings = mesh, new_work(), np.empty(FINDINGS)
        (self.memory,), _ = new_memory(1)
        self.counts = np.zeros(COUNTS, np.int64)

    def ask(self, end, key=inf, begin=None):
        if begin is not None:
            (self.memory,), _ = new_memory(1)
            self.memory[TIME] = begin
        bodies = (self.m, self.flights, self.bodies, 0, self.normal, self.side, 0, 1)
        limits = (float(end), float(key), self.tolerance, 1_000_000)
        return advance_plane(*bodies, *limits, self.memory, self.findings, self.work, self.counts)

    def height(self, t):
        """The least height of a vertex over the plane, from the flights alone."""
        states = [np.zeros((2, *s)) for s in ((3,), (3,), (3, 3), (3,), (3,))]
        for i in range(2):
            fly(self.flights, self.bodies, i, t, *(s[i] for s in states))
        x, R = states[0], states[2]
        mesh, plane = 1 - self.side, self.side
        corners = self.mesh.vertices @ R[mesh].T + x[mesh] - x[plane]
        return (corners @ (R[plane] @ self.normal)).min()


@pytest.mark.parametrize("rotation", ROTATIONS.values(), ids=ROTATIONS)
@pytest.mark.parametrize("spin", [1e-3, 1.0, 1e5])
@pytest.mark.parametrize("side", [0, 1])
def test_a_cube_spins_into_a_plane(spin, rotation, side):
    """An edge of a cube at a height comes down to it at pi/4 - acos(h sqrt 2), measured from flat."""
    height = 0.65
    query = Query(CUBE, Motion((np.eye(3), [0, 0, height]), angular_velocity=[spin, 0, 0], **rotation), side=side)
    assert query.ask(2.0 / spin) == MEETS
    time, found = (np.pi / 4 - np.arccos(height / HALF)) / spin, query.findings
    assert query.memory[TIME] < time
    assert found[CONTACT_TIME] == pytest.approx(time, rel=CONTACT)
    assert found[GAP] == pytest.approx(0.5 * TOLERANCE, rel=1e-5)
    # relative to the first body, whose origin is where the world is told from
    np.testing.assert_allclose(found[NORMAL : NORMAL + 3], [0, 0, -1.0 if side == 1 else 1.0], atol=1e-15)
    gap = found[POINT_B : POINT_B + 3] - found[POINT_A : POINT_A + 3]
    np.testing.assert_allclose(gap @ found[NORMAL : NORMAL + 3], found[GAP], rtol=1e-6)
    assert query.counts[STEPS] <= 12


def test_a_fall_takes_the_root_of_two_heights_over_gravity():
    query = Query(RING, Motion((np.eye(3), [0, 0, 3.0]), acceleration=[0, 0, -9.81]))
    assert query.ask(10.0) == MEETS
    low = RING.vertices[:, 2].min()
    assert query.findings[CONTACT_TIME] == pytest.approx(np.sqrt(2 * (3.0 + low) / 9.81), rel=CONTACT)
    assert query.counts[STEPS] <= 4
    away = Query(RING, Motion((np.eye(3), [0, 0, 3.0]), [1.0, 0, 0], acceleration=[0, 0, 1e-3]))
    assert away.ask(1e6) == NONE
    assert away.counts[STEPS] == 0


@pytest.mark.parametrize("side", [0, 1])
def test_a_plane_turns_up_to_a_cube_at_rest(side):
    """The normal turns about x: the plane reaches the corner at (y, z) after the angle atan(z / y)."""
    query = Query(
        CUBE,
        Motion((np.eye(3), [0, 3.0, 1.0])),
        Motion((np.eye(3), [0, 0, 0]), angular_velocity=[0.3, 0, 0]),
        side=side,
    )
    assert query.ask(10.0) == MEETS
    assert query.findings[CONTACT_TIME] == pytest.approx(np.arctan2(0.5, 3.5) / 0.3, rel=CONTACT)
    assert query.findings[CLOSING] == pytest.approx(0.3 * np.hypot(0.5, 3.5), rel=1e-6)


@pytest.mark.parametrize("shape", [CUBE, SLAB, BEAM, ELL, RING], ids=["cube", "slab", "beam", "ell", "ring"])
def test_agrees_with_dense_sampling(shape, rng):
    contacts = 0
    for _ in range(8):
        squares = rng.uniform(0.05, 1.0, size=3)
        R = turn(rng)
        top = R @ np.diag(squares.sum() - squares) @ R.T
        kind = [
            {},
            {"inertia": np.diag([0.3, 0.3, 0.5])},
            {"inertia": top},
            {"inertia": top, "torque": rng.normal(size=3)},
        ]
        motion = Motion(
            (turn(rng), [0, 0, rng.uniform(1.5, 3.0)]),
            rng.normal(size=3) - [0, 0, 1.0],
            3.0 * rng.normal(size=3),
            acceleration=[0, 0, rng.choice([0.0, -2.0])],
            **kind[rng.integers(4)],
        )
        plane = Motion((turn(rng), np.zeros(3)), 0.3 * rng.normal(size=3), rng.choice([0.0, 0.3]) * rng.normal(size=3))
        normal = tuple(plane.pose[0].T @ UP)
        query = Query(shape, motion, plane, normal, side=int(rng.integers(2)))
        status = query.ask(2.0)
        times = np.linspace(0.0, 2.0, 400)
        below = np.flatnonzero(np.array([query.height(t) for t in times]) <= 0.0)
        if status == NONE:
            assert len(below) == 0
            continue
        assert status == MEETS
        contacts += 1
        time = query.memory[TIME]
        assert len(below) == 0 or time < times[below[0]]
        assert query.height(time) == pytest.approx(0.5 * TOLERANCE, rel=1e-3)
        assert min(query.height(t) for t in np.linspace(0.0, time, 100)) >= 0.45 * TOLERANCE
        found = query.findings
        if found[CLOSING] > 0.1:
            assert query.height(found[CONTACT_TIME] - 1e-12) > 0.0 > query.height(found[CONTACT_TIME] + 1e-12)
    assert contacts > 3


def test_contact_times_do_not_depend_on_where_a_query_begins(rng):
    motion = Motion((turn(rng), [0, 0, 4.0]), [0.3, 0.1, -1.0], [1.0, 2.0, 0.5], inertia=TRIAXIAL)
    query = Query(ELL, motion)
    assert query.ask(10.0) == MEETS
    time = query.memory[TIME]
    for share in rng.random(20):
        assert query.ask(10.0, begin=share * time) == MEETS
        assert abs(query.memory[TIME] - time) <= 1e-13 * time
    key, ends = 0.0, []
    (query.memory,), _ = new_memory(1)
    while not ends or ends[-1] == LATER:
        ends.append(query.ask(10.0, key=key))
        key += 0.01
    assert ends[-1] == MEETS
    assert len(ends) > 3
    assert abs(query.memory[TIME] - time) <= 1e-13 * time


@pytest.mark.parametrize("gap", [0.3, 0.9])
def test_touching_is_a_contact_if_it_closes(gap):
    for speed, status in ((-1.0, TOUCHES if gap < 0.5 else MEETS), (1.0, NONE), (1e-6, NONE), (0.0, NONE)):
        query = Query(CUBE, Motion((np.eye(3), [0, 0, 0.5 + gap * TOLERANCE]), [0.2, 0, speed]))
        assert query.ask(10.0) == status
    assert Query(CUBE, Motion((np.eye(3), [0, 0, 0.4]))).ask(1.0) == OVERLAPS


def test_a_hop_comes_back_after_twice_its_speed_over_the_pull():
    query = Query(CUBE, Motion((np.eye(3), [0, 0, 0.5 + 0.5 * TOLERANCE]), [0, 0, 0.01], acceleration=[0, 0, -1.0]))
    assert query.ask(10.0) == MEETS
    assert query.memory[TIME] == pytest.approx(0.02, rel=1e-12)
    assert query.counts[STEPS] <= 4


def test_a_plane_is_a_large_box(rng):
    """The same contact as with the top face of a box, by the other kernel."""
    slab = TriangleMesh(SLAB.vertices * [40.0, 40.0, 1.0], SLAB.triangles)
    top = slab.vertices[:, 2].max()
    for _ in range(5):
        motion = Motion((turn(rng), [0, 0, 2.5]), [0.1, 0.2, -1.0], 2.0 * rng.normal(size=3), inertia=TRIAXIAL)
        plane, below = Query(CUBE, motion), Motion((np.eye(3), [0, 0, -top]))
        assert plane.ask(5.0) == MEETS
        m = MeshStore.build([CUBE, slab]).arrays
        flights, bodies = flights_of((motion, below))
        memory, witness = new_memory(1)
        findings, counts = np.empty(FINDINGS), np.zeros(COUNTS, np.int64)
        limits = (5.0, inf, TOLERANCE, 0.01, 1_000_000)
        state = (memory[0], witness[0], findings, new_work(), counts)
        assert advance(m, flights, bodies, 0, 1, 0, 1, *limits, *state) == MEETS
        assert findings[CONTACT_TIME] == pytest.approx(plane.findings[CONTACT_TIME], rel=CONTACT)
        assert memory[0, TIME] == pytest.approx(plane.memory[TIME], rel=CONTACT)
