"""Spheres in a pipe against arithmetic of 60 digits: one of them for 10 000 hits, 23 of them in order and time."""

from decimal import Decimal

import mpmath as mp
import numpy as np
import pytest
from event_scenes import Ball, Part, Play, Tube

from comotion.report.spheres_in_decimals import Spheres
from comotion_server.kernels.event_queue import DONE, SPENT
from comotion_server.kernels.event_scene import LEFT

RADIUS, INNER, OUTER, HALF = 2e-3, 21e-3, 23e-3, 45e-3
ROUNDED = [(50, 1e-12), (100, 1e-10), (200, 1e-7)]  # [s] what chaos makes of a rounding after so many events


def ring(count, axial):
    """Spheres in a ring, all at one height, with velocities of their own, across the axis alone unless `axial`."""
    rng = np.random.default_rng(23)
    angle = 2.0 * np.pi * np.arange(count) / count
    x = 0.017 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    v = 0.05 * rng.normal(size=(count, 3))
    v[:, 2] *= axial
    return x, v


@pytest.mark.parametrize("caps", [False, True])
def test_23_spheres_meet_in_the_order_and_at_the_times_of_exact_arithmetic(caps):
    x, v = ring(23, caps)
    parts = [Part(Ball(RADIUS), tuple(a), tuple(b)) for a, b in zip(x, v, strict=True)]
    play = Play([*parts, Part(Tube(INNER, OUTER, HALF, caps), density=0.0)])
    play.begin()
    play.queue.tally[LEFT] = 200
    assert play.play(1e3) == SPENT
    log, truth = play.queue.log, Spheres(x, v, RADIUS, INNER, HALF if caps else None)
    events = [truth.event() for _ in range(200)]
    expected = [(i, j if j >= 0 else 23) for _, i, j in events]
    assert [tuple(pair) for pair in log.bodies[:200].tolist()] == expected
    late = np.array([float(Decimal(float(t)) - s) for t, (s, _, _) in zip(log.time[:200], events, strict=True)])
    for count, most in ROUNDED:
        assert np.abs(late[:count]).max() <= most


def test_a_sphere_is_where_it_should_be_after_10_000_hits():
    """Chords of a circle all have the same length and turn by the same angle; along the axis it goes on evenly."""
    x, v = np.array([0.003, -0.011, 0.0]), np.array([0.31, 0.17, 0.0])
    play = Play([Part(Ball(RADIUS), tuple(x), tuple(v)), Part(Tube(INNER, OUTER, HALF), density=0.0)])
    play.begin()
    play.queue.tally[LEFT] = 10_000
    assert play.play(1e6) == SPENT
    log = play.queue.log
    with mp.workdps(40):
        d, u, room = (
            [mp.mpf(float(c)) for c in x[:2]],
            [mp.mpf(float(c)) for c in v[:2]],
            mp.mpf(INNER) - mp.mpf(RADIUS),
        )
        square, half = mp.fdot(u, u), mp.fdot(d, u)
        first = (-half + mp.sqrt(half**2 - square * (mp.fdot(d, d) - room**2))) / square
        at = mp.mpc(d[0] + first * u[0], d[1] + first * u[1])
        out = mp.mpc(*u)
        cosine = (out * mp.conj(at)).real / (abs(out) * room)
        turn = mp.sign((out * mp.conj(at)).imag) * (mp.pi - 2 * mp.acos(cosine))
        chord = 2 * room * cosine / mp.sqrt(square)
        last = at * mp.expj(9999 * turn)
        time = first + 9999 * chord
        place = last / room * mp.mpf(INNER)
        point, when = log.point[9999], log.time[9999]
        assert float(abs(mp.mpc(float(point[0]), float(point[1])) - place)) < 1e-9
        assert float(abs(mp.mpf(float(when)) - time)) < 1e-9


def test_the_flight_cut_in_steps_is_the_same():
    def ends(steps):
        x, v = ring(5, 1.0)
        parts = [Part(Ball(RADIUS), tuple(a), tuple(b)) for a, b in zip(x, v, strict=True)]
        play = Play([*parts, Part(Tube(INNER, OUTER, HALF, caps=True), density=0.0)])
        for _ in range(steps):
            assert play.step(2.0 / steps) == DONE
        return play.scene.x.copy()

    np.testing.assert_allclose(ends(64), ends(1), rtol=0.0, atol=1e-12)
