"""What the pair table does not ask again, and asks on several threads, is what it would have been told."""

import numpy as np
import pytest
from meshes_by_hand import l_shape, torus
from scenes_by_hand import free_box, scene_of
from triangle_families import turn

from comotion_server.kernels.mesh_pair import closest_points_of_pairs
from comotion_server.kernels.motion_budget import bounds_left, note_asked
from comotion_server.meshes import box
from comotion_server.meshes.mesh_store import MeshStore
from comotion_server.pair_table import PairTable
from comotion_server.pair_threads import FEWEST, PairThreads, thread_count
from comotion_server.world import World

ROUNDING = 1e-12  # [m] of distances in a scene of about 10 m


def small_turn(rng, angle):
    axis = rng.normal(size=3)
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


class Crowd:
    """Bodies of three shapes, and the distances of all their pairs."""

    def __init__(self, rng, count, spread):
        self.meshes = [torus(12, 6), l_shape(), box([1.0, 0.4, 2.0])]
        self.store = MeshStore.build(self.meshes)
        self.shapes = rng.integers(3, size=count)
        self.x, self.R = spread * rng.normal(size=(count, 3)), np.stack([turn(rng) for _ in range(count)])
        self.radius = 0.5 * self.store.size[self.shapes]
        self.pairs = np.array([(i, j) for i in range(count) for j in range(i + 1, count)])

    def outputs(self):
        k = len(self.pairs)
        return np.full((k, 2), -1), np.zeros(k), np.zeros((k, 3)), np.zeros((k, 3)), np.zeros((k, 3))

    def arguments(self, reach, out):
        return self.store.arrays, self.shapes, self.x, self.R, self.pairs, np.full(len(self.pairs), reach), *out

    def distances(self):
        out = self.outputs()
        closest_points_of_pairs(*self.arguments(np.inf, out))
        return out[1]


def test_what_is_left_of_a_bound_is_a_bound(rng):
    crowd = Crowd(rng, 20, 3.0)
    count, reach = len(crowd.pairs), np.full(len(crowd.pairs), 0.5)
    known = np.full(count, np.nan), np.zeros((count, 3, 3)), np.zeros((count, 3))
    asked = []
    for step in range(40):
        exact, left, poses = crowd.distances(), np.empty(count), (crowd.pairs, crowd.x, crowd.R)
        bounds_left(*poses, crowd.radius, *known, np.zeros(len(crowd.x)), left)
        assert (left <= exact + ROUNDING).all()
        rows = np.flatnonzero(left < reach)
        note_asked(rows, *poses, exact, *known)
        asked.append(len(rows))
        crowd.x += 0.02 * rng.normal(size=crowd.x.shape)
        crowd.R = np.stack([small_turn(rng, 0.02) @ R for R in crowd.R])
        if step == 20:  # put somewhere else altogether
            crowd.x[:5] = crowd.x[5:10] + 0.5
    assert asked[0] == count
    assert max(asked[1:20]) < 0.5 * count


def test_bodies_that_drift_together_are_asked_once(rng):
    crowd = Crowd(rng, 12, 4.0)
    count, reach = len(crowd.pairs), np.full(len(crowd.pairs), 1e-3)
    known = np.full(count, np.nan), np.zeros((count, 3, 3)), np.zeros((count, 3))
    left, distance = np.empty(count), crowd.distances()
    note_asked(np.arange(count), crowd.pairs, crowd.x, crowd.R, distance, *known)
    Q = turn(rng)
    crowd.x, crowd.R = crowd.x @ Q.T + [100.0, 0.0, 0.0], Q @ crowd.R
    bounds_left(crowd.pairs, crowd.x, crowd.R, crowd.radius, *known, np.zeros(12), left)
    assert (left[distance > reach] >= distance[distance > reach] - ROUNDING).all()
    motion = 0.1 * rng.random(12)
    later = np.empty(count)
    bounds_left(crowd.pairs, crowd.x, crowd.R, crowd.radius, *known, motion, later)
    spent = motion[crowd.pairs].sum(axis=1)
    np.testing.assert_allclose((left - later)[distance > 0.3], spent[distance > 0.3], atol=ROUNDING)


def test_threads_give_the_same_bits(rng):
    crowd = Crowd(rng, 25, 3.0)
    assert len(crowd.pairs) > FEWEST
    answers = []
    for threads in (1, 2, 3):
        out = crowd.outputs()
        PairThreads(threads).closest_points(np.arange(len(crowd.pairs)), *crowd.arguments(2.0, out))
        answers.append(b"".join(array.tobytes() for array in out))
    assert answers[0] == answers[1] == answers[2]


def test_few_pairs_start_no_thread(rng):
    crowd, threads = Crowd(rng, 4, 3.0), PairThreads(2)
    threads.closest_points(np.arange(len(crowd.pairs)), *crowd.arguments(2.0, crowd.outputs()))
    assert threads._pool is None


def test_number_of_threads_comes_from_the_environment(monkeypatch):
    monkeypatch.setenv("COMOTION_THREADS", "3")
    assert thread_count() == 3
    monkeypatch.setenv("COMOTION_THREADS", "none")
    with pytest.raises(ValueError, match="COMOTION_THREADS must be"):
        thread_count()
    monkeypatch.delenv("COMOTION_THREADS")
    assert thread_count() >= 1


def test_a_table_asks_distant_pairs_once_and_near_ones_each_time():
    plate = free_box("plate", (20.0, 20.0, 0.1), 1.0, position=(0.0, 0.0, -5.0))  # its sphere holds the others
    still, near = (free_box(name, (1.0, 1.0, 1.0), 1.0, position=(x, 0, 0)) for name, x in (("still", 0), ("near", 2)))
    world = World(scene_of(plate, still, near))
    world.state.velocity[world.names.index("near"), 0] = -1.0
    world.take_off(np.zeros((3, 3)), np.zeros((3, 3)))
    table = PairTable(world)
    table.refresh(0.0, 0.5)
    assert len(table.pairs) == 3
    names = sorted(world.names.index(name) for name in ("still", "near"))
    row = np.flatnonzero((table.pairs == names).all(axis=1))[0]
    for time in np.linspace(0.0, 0.5, 11):
        world.advance(time)
        before = table.last.offset.copy()
        closeness = table.measure(time, 1e-9)
        asked = (before != table.last.offset).any(axis=1)
        assert asked.all() if time == 0.0 else np.flatnonzero(asked) == [row]
        assert closeness.distance[row] == pytest.approx(1.0 - time, abs=ROUNDING)
