"""Rooms, cells and rows of pairs against all pairs compared."""

import numpy as np
from event_scenes import Part, Play

from comotion_server.kernels.event_queue import DONE
from comotion_server.kernels.neighbour_cells import rooms_meet
from comotion_server.meshes import box


def known(queue):
    return {tuple(pair) for pair in queue.pairs.bodies.tolist() if pair[0] >= 0}


def meeting(queue, reacts):
    n = len(reacts)
    return {
        (i, j) for i in range(n) for j in range(i + 1, n) if (reacts[i] or reacts[j]) and rooms_meet(queue.cells, i, j)
    }


def rows_of(queue, i):
    """Rows of body i by its list of links."""
    link, rows = queue.pairs.first[i], []
    while link >= 0:
        rows.append(link >> 1)
        link = queue.pairs.next[link]
    return rows


def scattered(rng, count, spread):
    """Small boxes that fly past each other, a few far larger ones, and two planes."""
    small = [Part(box([0.02, 0.01, 0.03]), spread * rng.normal(size=3), rng.normal(size=3)) for _ in range(count)]
    large = [Part(box([0.5, 0.5, 0.5]), 20.0 + 3.0 * i + np.zeros(3), (0.1, 0, 0), density=0.0) for i in range(3)]
    return small + large + [Part((0, 0, 1.0), (0, 0, -9.0)), Part((0, 0, -1.0), (0, 0, 9.0))]


def test_pairs_are_those_whose_rooms_meet(rng):
    parts = scattered(rng, 60, 0.15)
    parts = [part for part in parts if all(np.abs(np.subtract(part.x, o.x)).max() > 0.03 or o is part for o in parts)]
    play = Play(parts)
    queue, reacts = play.queue, play.scene.bodies.reacts
    assert len(queue.cells.large) == 5
    assert known(queue) == meeting(queue, reacts)
    for _ in range(10):
        assert play.step(0.02) == DONE
        assert known(queue) == meeting(queue, reacts)
        x, centre, spare = play.scene.x, queue.cells.centre, queue.cells.spare
        room = np.isfinite(spare)
        assert (np.linalg.norm(x - centre, axis=1)[room] <= spare[room] * (1 + 1e-12)).all()
    rows = np.flatnonzero(queue.pairs.bodies[:, 0] >= 0)
    assert queue.pairs.free_count[0] == len(queue.pairs.bodies) - len(rows)
    for i in range(len(reacts)):
        assert sorted(rows_of(queue, i)) == [k for k in rows if i in queue.pairs.bodies[k]]
    assert queue.tally[7] > 50  # new rooms


def test_a_body_outside_all_cells_known_so_far_is_found():
    cube = box([1.0, 1.0, 1.0])
    far = np.array([1e9, -1e9, 1e9])
    play = Play([Part(cube, far), Part(cube, (*(far[:1] + 3.0), *far[1:]), (-1.0, 0, 0)), Part(cube)], tolerance=1e-4)
    assert play.step(10.0) == DONE
    assert play.queue.log.total[1] == 1
    np.testing.assert_allclose(play.scene.v[0], [-1.0, 0.0, 0.0], atol=1e-12)
