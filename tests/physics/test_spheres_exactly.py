"""Spheres whose motion is known: a bouncing ball, Galperin's billiard, a breathing ring; and what symmetry demands."""

from math import cos, floor, pi, sin, sqrt

import numpy as np
import pytest
from event_scenes import Ball, Part, Play, Tube

from comotion_server.kernels.event_queue import DONE, REST, SPENT
from comotion_server.kernels.event_scene import LEFT

FLOOR, CEILING = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def test_44_impacts_of_a_bouncing_ball():
    """From 1 m it lands after sqrt(2 h / g); every hop lasts e times as long as the one before."""
    g, e, h, r = 9.81, 0.9, 1.0, 0.125
    play = Play([Part(Ball(r), (0.0, 0.0, r + h)), Part(FLOOR)], gravity=(0, 0, -g), restitution=e, resting=True)
    times = []
    for step in range(850):
        play.begin(0.01)
        assert play.play(0.01) == DONE
        times += [0.01 * step + t for t in play.queue.log.time[: play.queue.log.total[0]]]
    first = sqrt(2.0 * h / g)
    expected = [first * (1.0 + 2.0 * e * (1.0 - e**n) / (1.0 - e)) for n in range(44)]
    assert len(times) == 44
    np.testing.assert_allclose(times, expected, rtol=0.0, atol=1e-11)


def test_a_ball_comes_to_rest():
    play = Play([Part(Ball(0.1), (0.0, 0.0, 0.2)), Part(FLOOR)], gravity=(0, 0, -9.81), restitution=0.3, resting=True)
    play.begin()
    assert play.play(10.0) == REST


@pytest.mark.parametrize("power", [0, 2, 4, 6, 8, 10])
def test_the_count_of_galperins_billiard(power):
    """A heavy ball drives a light one against a wall: floor(pi 10^k) impacts at a ratio of 10^2k, and a known end.

    In the plane of (sqrt(M) V, sqrt(m) v) impacts are reflections in two lines at an angle of atan(sqrt(m / M)).
    """
    ratio = 10.0**power
    parts = [Part(Ball(0.5), (1.0, 0.0, 0.0)), Part(Ball(0.5), (3.0, 0.0, 0.0), (-1.0, 0.0, 0.0), density=ratio)]
    play = Play([*parts, Part((1.0, 0.0, 0.0))], log_room=400_000)
    play.begin()
    assert play.play(1e3) == DONE
    count = floor(pi * sqrt(ratio))
    assert play.queue.log.total[0] == count
    angle = 2.0 * np.arctan(1.0 / sqrt(ratio))
    turned = ((count + 1) // 2) * angle
    assert abs(play.scene.v[1, 0] + cos(turned)) <= 1e-12
    assert abs(abs(play.scene.v[0, 0]) - abs(sin(turned)) * sqrt(ratio)) <= 1e-12 * sqrt(ratio)


def test_a_breathing_ring():
    """Spheres that fly inward together meet all at once, fly outward, come back from the pipe, and so on."""
    count, r, inner = 6, 0.125, 0.390625
    angle = 2.0 * np.pi * np.arange(count) / count
    out = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    parts = [Part(Ball(r), tuple(0.2578125 * x), tuple(-x)) for x in out]
    play = Play([*parts, Part(Tube(inner, 0.6, 1.0), density=0.0)])
    least, most = r / sin(pi / count), inner - r
    period = 2.0 * (most - least)
    for _ in range(10):
        assert play.step(period) == DONE
        radii = np.linalg.norm(play.scene.x[:count], axis=1)
        np.testing.assert_allclose(radii, 0.2578125, rtol=0.0, atol=1e-12)


# what symmetry demands


def tumbling(scale=1.0, speed=1.0, mirror=(1.0, 1.0, 1.0), order=None):
    """Spheres of three sizes that fly about in a box with a pipe."""
    rng = np.random.default_rng(5)
    places = np.stack(np.meshgrid(*3 * [np.arange(3.0)]), -1).reshape(-1, 3) - 1.0
    parts = []
    for i, place in enumerate(places):
        r = (0.2, 0.25, 0.3)[i % 3]
        parts.append((r, place + 0.1 * rng.uniform(-1, 1, 3), rng.normal(size=3), r**3))
    order = range(len(parts)) if order is None else order
    made = [
        Part(Ball(scale * parts[i][0]), scale * parts[i][1] * mirror, speed * parts[i][2] * mirror, density=parts[i][3])
        for i in order
    ]
    made += [Part(tuple(-n * mirror), tuple(1.5 * scale * n * mirror)) for a in np.eye(3)[2:] for n in (a, -a)]
    return [*made, Part(Tube(2.2 * scale, 2.4 * scale, 2.0 * scale), density=0.0)]


def played(parts, gravity=(0.0, 0.0, 0.0), hits=300):
    play = Play(parts, gravity=gravity)
    play.begin()
    play.queue.tally[LEFT] = hits
    assert play.play(1e6) == SPENT
    return play


@pytest.mark.parametrize("gravity", [0.0, 3.0])
@pytest.mark.parametrize(("length", "time"), [(2.0**20, 1.0), (2.0**-30, 2.0**5)])
def test_powers_of_two_change_no_bit(gravity, length, time):
    pull = np.array([0.0, 0.0, -gravity])
    one = played(tumbling(), pull)
    other = played(tumbling(length, length / time), pull * length / time**2)
    np.testing.assert_array_equal(one.queue.log.time[:300] * time, other.queue.log.time[:300])
    np.testing.assert_array_equal(one.scene.x * length, other.scene.x)


def test_nor_does_a_mirror():
    mirror = np.array([1.0, -1.0, -1.0])
    one, other = played(tumbling()), played(tumbling(mirror=mirror))
    np.testing.assert_array_equal(one.queue.log.time[:300], other.queue.log.time[:300])
    np.testing.assert_array_equal(one.scene.x * mirror, other.scene.x)


def test_nor_does_renumbering():
    order = np.random.default_rng(3).permutation(27)
    one, other = played(tumbling()), played(tumbling(order=order))
    np.testing.assert_array_equal(one.queue.log.time[:300], other.queue.log.time[:300])
    np.testing.assert_array_equal(one.scene.x[order], other.scene.x[:27])


def test_reversed_after_100_events_all_come_back():
    """In a gas that is thin enough for chaos to leave 1e-12 of 1 after 200 events."""
    rng = np.random.default_rng(8)
    places = np.stack(np.meshgrid(*3 * [np.arange(4.0)]), -1).reshape(-1, 3)
    walls = [Part(tuple(-n), tuple(1.5 + 2.5 * n)) for a in np.eye(3) for n in (a, -a)]
    play = Play([*(Part(Ball(0.35), tuple(x), tuple(rng.normal(size=3))) for x in places), *walls])
    start = play.scene.x.copy()
    play.begin()
    play.queue.tally[LEFT] = 100
    assert play.play(1e6) == SPENT
    elapsed = play.queue.now[0]
    play.scene.v[:] *= -1.0
    play.begin(elapsed)
    play.queue.tally[LEFT] = 1 << 40
    assert play.play(elapsed) == DONE
    assert play.queue.log.total[0] in (100, 101)
    np.testing.assert_allclose(play.scene.x, start, rtol=0.0, atol=1e-12)
