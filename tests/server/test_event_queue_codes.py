"""How `play` hands over to its caller, and goes on afterwards; what it notes of impacts."""

import numpy as np
import pytest
from event_scenes import Part, Play
from tumbling_scenes import prisms_in_a_box

from comotion_server.kernels.event_queue import (
    BLOCKED,
    DONE,
    ISLAND,
    LOG_FULL,
    MERGES,
    REST,
    SPENT,
    set_timer,
)
from comotion_server.kernels.event_scene import ANSWERED, BODIES, CONTACTS, HITS, LEFT, TIMER
from comotion_server.kernels.impact_log import clear
from comotion_server.meshes import box

CUBE = box([1.0, 1.0, 1.0])
BEFORE_CONTACT = 1e-8  # relative: a hit comes when the gap is half the tolerance


def two_cubes(**given):
    """They meet after 1 s."""
    return Play([Part(CUBE), Part(CUBE, (2.0, 0, 0), (-1.0, 0, 0))], **given)


def begun(play):
    play.begin()
    return play


def test_a_timer_is_due_at_its_time_and_only_once():
    play = begun(two_cubes())
    set_timer(play.queue, 1, 0.25)
    set_timer(play.queue, 0, 0.5)
    set_timer(play.queue, 0, np.inf)
    assert play.play(0.75) == ISLAND
    assert play.queue.now[0] == 0.25
    assert play.queue.tally[TIMER] == 1
    set_timer(play.queue, 1, np.inf)
    assert play.play(0.75) == DONE
    assert play.queue.now[0] == 0.75


def test_the_budget_stops_before_the_hit_and_it_is_not_lost():
    play = begun(two_cubes())
    play.queue.tally[LEFT] = 0
    assert play.play(2.0) == SPENT
    assert play.queue.now[0] == pytest.approx(1.0, rel=BEFORE_CONTACT)
    play.queue.tally[LEFT] = 1
    assert play.play(2.0) == DONE
    np.testing.assert_allclose(play.scene.v[:, 0], [-1.0, 0.0], atol=1e-15)


def test_a_full_log_stops_before_the_hit():
    parts, _ = prisms_in_a_box()
    whole, small = begun(Play(parts)), begun(Play(parts))
    small.queue = small.queue._replace(
        log=type(small.queue.log)(*(a[:6].copy() if len(a) > 3 else a for a in small.queue.log))
    )
    assert whole.play(1.0) == DONE
    times = []
    while small.play(1.0) == LOG_FULL:
        times += small.queue.log.time[: small.queue.log.total[0]].tolist()
        clear(small.queue.log)
    times += small.queue.log.time[: small.queue.log.total[0]].tolist()
    # a query taken up again takes other steps to the target gap: a millionth of it is 1e-15 s, which chaos makes larger
    np.testing.assert_allclose(times, whole.queue.log.time[: whole.queue.log.total[0]], rtol=0.0, atol=1e-12)


def test_a_held_body_hands_over_what_hits_it():
    play = begun(two_cubes())
    play.queue.held[0] = True
    assert play.play(2.0) == REST
    assert play.queue.tally[ANSWERED] == 0
    assert sorted(play.queue.cluster.bodies[: play.queue.cluster.size[BODIES]]) == [0, 1]
    assert play.queue.cluster.size[CONTACTS] == 4
    assert play.scene.v[1, 0] == -1.0


def test_an_impact_without_restitution_may_merge():
    play = begun(two_cubes(restitution=0.0))
    play.rules = play.rules._replace(merging=True)
    assert play.play(2.0) == MERGES
    assert play.scene.v[1, 0] == -1.0


def test_two_plastic_bodies_go_on_together_for_ever():
    """What rounding leaves of their speeds against each other is no approach."""
    play = begun(two_cubes(restitution=0.0))
    assert play.play(1e3) == DONE
    assert play.queue.tally[HITS] <= 3
    np.testing.assert_allclose(play.scene.v[:, 0], -0.5, atol=1e-15)
    assert play.gap(1e3) > 0.0


def test_a_flat_fall_takes_all_four_corners_and_rests_at_the_end_of_its_bounces():
    """After the time (1 + e) / (1 - e) times that of the fall."""
    parts = [Part((0, 0, 1.0)), Part(CUBE, (0, 0, 1.5), (0.1, 0, 0), (0, 0, 0.3))]
    play = begun(Play(parts, gravity=(0, 0, -1.0), restitution=0.5, resting=True))
    assert play.play(10.0) == REST
    assert play.queue.cluster.size[CONTACTS] == 4
    fall = np.sqrt(2.0)
    assert play.queue.now[0] == pytest.approx(3.0 * fall, abs=1e-3)
    count = play.queue.log.total[0]
    bounces = play.queue.log.approach[:count:4]
    np.testing.assert_allclose(bounces, fall * 0.5 ** np.arange(len(bounces)), rtol=1e-8)
    assert play.scene.w[1] == pytest.approx([0, 0, 0.3], abs=1e-14)


def test_a_pinch_is_blocked_and_nothing_is_changed():
    """A prescribed cube pushes a free one against a wall that stays."""
    parts = [
        Part(CUBE, density=0.0),
        Part(CUBE, (1.0 + 2e-9, 0, 0)),
        Part(CUBE, (2.0 + 1e-8, 0, 0), (-1.0, 0, 0), density=0.0),
    ]
    play = begun(Play(parts))
    assert play.play(1.0) == BLOCKED
    np.testing.assert_array_equal(play.scene.v[1], 0.0)
    assert play.queue.cluster.report.certificate[: play.queue.cluster.size[CONTACTS]].any()


def test_impulses_add_up_to_the_change_of_momentum():
    parts, _ = prisms_in_a_box()
    play = begun(Play(parts))
    before = play.scene.v.copy()
    assert play.play(1.0) == DONE
    log = play.queue.log
    logged = np.zeros_like(before)
    count = log.total[0]
    np.add.at(logged, log.bodies[:count, 1], log.impulse[:count])
    np.add.at(logged, log.bodies[:count, 0], -log.impulse[:count])
    gained = (play.scene.v - before)[1:] / play.scene.bodies.inverse_mass[1:]
    np.testing.assert_allclose(logged[1:], gained, atol=1e-14)
    assert (np.diff(log.time[:count]) >= 0.0).all()
    assert (log.contact_time[:count] >= log.time[:count]).all()
