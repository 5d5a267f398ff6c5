"""Resistance per stated window, against sums done by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from comotion.outputs.resistance import ContactImpulses, plot_resistance, resistance

ROUNDING = 1e-12  # relative: sums of a few dozen float64


def contact(a, b, impulse):
    return SimpleNamespace(body_a=a, body_b=b, impulse=np.array(impulse, dtype=float), count=1)


def test_impulses_count_with_their_sign_for_either_side_and_others_not_at_all():
    impulses = ContactImpulses("hull")
    impulses.add(
        0.1, [contact("floe", "hull", [-2, 0, 0]), contact("hull", "ice", [3, 0, 0]), contact("a", "b", [9, 9, 9])]
    )
    np.testing.assert_array_equal(impulses.impulses[0], [-5, 0, 0])


@pytest.mark.parametrize("restitution", [0.0, 1.0])
def test_mean_of_the_staircase_is_its_closed_form(restitution):
    """Prescribed speed U through floes m at gaps d: one hit of (1+e) m U per d/U, so R = (1+e) m U^2 / d."""
    speed, mass, gap, dt = 0.5, 0.5, 0.25, 0.01
    impulses = ContactImpulses("hull")
    steps_per_hit = round(gap / speed / dt)
    for step in range(1, 20 * steps_per_hit + 1):
        hits = [contact("hull", "floe", [(1 + restitution) * mass * speed, 0, 0])] if step % steps_per_hit == 0 else []
        impulses.add(step * dt, hits)
    expected = (1 + restitution) * mass * speed**2 / gap
    for window in (0.1, 0.37, 0.5, 100.0):
        curve = resistance(impulses, np.array([5.0, 0.0, 0.0]), 0.0, window)
        assert curve.mean == pytest.approx(expected, rel=ROUNDING)
    one_hit_each = resistance(impulses, np.array([5.0, 0.0, 0.0]), 0.0, gap / speed)
    np.testing.assert_allclose(one_hit_each.force, expected, rtol=ROUNDING)


def test_direction_is_the_way_travelled_and_the_last_window_is_what_is_left():
    impulses = ContactImpulses("hull")
    impulses.add(1.0, [contact("floe", "hull", [0, 4, 0])])
    impulses.add(2.5, [contact("floe", "hull", [7, 3, 0])])
    curve = resistance(impulses, np.array([0.0, -2.0, 0.0]), 0.0, 2.0)
    np.testing.assert_array_equal(curve.edges, [0.0, 2.0, 2.5])
    np.testing.assert_allclose(curve.force, [4 / 2.0, 3 / 0.5], rtol=ROUNDING)


def test_plot_states_the_window(tmp_path):
    pytest.importorskip("matplotlib")
    impulses = ContactImpulses("hull")
    impulses.add(0.1, [contact("hull", "floe", [1, 0, 0])])
    plot_resistance(tmp_path / "resistance.png", "hull", resistance(impulses, np.array([1.0, 0, 0]), 0.0, 0.1), 0.1)
    assert (tmp_path / "resistance.png").read_bytes().startswith(b"\x89PNG")
