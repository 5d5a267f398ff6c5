"""Meshes that tumble and hit each other for a long time: no overlap, no stall, books closed, and the same bits."""

import numpy as np
import pytest
from event_scenes import Play
from tumbling_scenes import SCENES, ells_in_a_box, prisms_in_a_box

from comotion_server.kernels.event_queue import DONE, REST, SPENT
from comotion_server.kernels.event_scene import HITS, LEFT, LONGEST_RUN

TOLERANCE = 1e-9
LEAST_GAP = 0.45  # of the tolerance; steps aim at half
BOOKS = 1e-13
ENERGY = 1e-13  # of a run; measured: 2e-16 to 6e-14


def smallest(parts):
    """The least diameter [m]: all tolerances are relative to it or to larger ones."""
    return min(part.shape.size for part in parts if hasattr(part.shape, "size"))


@pytest.mark.parametrize("name", SCENES)
def test_runs_for_2000_impacts(name):
    """Energy kept at e = 1, the gap never below the target, no stall, books of every impact closed."""
    parts, given = SCENES[name]()
    play = Play(parts, tolerance=TOLERANCE, **given)
    play.begin()
    energy, least = play.energy(), np.inf
    while play.queue.tally[HITS] < 2000:
        play.queue.tally[LEFT] = 50
        assert play.play(1e4) == SPENT
        least = min(least, play.gap(play.queue.now[0]))
    assert least >= LEAST_GAP * TOLERANCE * smallest(parts)
    assert play.queue.log.books.max() <= BOOKS
    assert play.queue.tally[LONGEST_RUN] <= 2
    assert play.energy() == pytest.approx(energy, rel=ENERGY)


@pytest.mark.parametrize("restitution", [0.5, 0.1, 1e-3])
@pytest.mark.parametrize("name", SCENES)
def test_loses_energy_until_something_comes_to_rest(name, restitution):
    """Without stalls, and the gap never below the target: hops that could not clear it are rest."""
    parts, given = SCENES[name]()
    play = Play(parts, tolerance=TOLERANCE, restitution=restitution, resting=True, **given)
    play.begin()
    least, code = np.inf, SPENT
    while code == SPENT and play.queue.tally[HITS] < 60:
        play.queue.tally[LEFT] = 10
        code = play.play(40.0)
        least = min(least, play.gap(play.queue.now[0]))
    assert code in {REST, DONE, SPENT}
    assert least >= LEAST_GAP * TOLERANCE * smallest(parts)
    assert play.queue.log.books.max() <= BOOKS
    assert play.queue.tally[LONGEST_RUN] <= 2
    impacts = play.queue.log.total[0]
    assert impacts > 1


def test_bodies_of_three_inertias_under_held_torque():
    """Gaps and books as without; energy is what the torque gives."""
    parts, _ = ells_in_a_box()
    play = Play(parts, tolerance=TOLERANCE)
    assert len(set(play.scene.bodies.moments[1].round(6))) == 3
    play.torque = np.array([[0.0, 0, 0], [0.3, -0.2, 0.1], [-0.1, 0.2, 0.3]])
    least = np.inf
    for _ in range(200):
        assert play.step(0.1) == DONE
        least = min(least, play.gap(0.1))
        assert play.queue.log.books.max() <= BOOKS
    assert play.queue.tally[HITS] > 50
    assert play.queue.tally[LONGEST_RUN] <= 2
    assert least >= LEAST_GAP * TOLERANCE * smallest(parts)


@pytest.mark.parametrize("cuts", [2, 5, 10])
def test_a_step_in_pieces_gives_the_same_impacts(cuts):
    """Up to the horizon of chaos: impact times to 1e-12."""
    parts, _ = ells_in_a_box()
    whole, cut = Play(parts), Play(parts)
    duration = 10.0
    assert whole.step(duration) == DONE
    times = []
    for k in range(cuts):
        assert cut.step(duration / cuts) == DONE
        count = cut.queue.log.total[0]
        times += list(k * duration / cuts + cut.queue.log.contact_time[:count])
    expected = whole.queue.log.contact_time[: whole.queue.log.total[0]]
    assert len(times) == len(expected) > 5
    np.testing.assert_allclose(times[:8], expected[:8], rtol=0, atol=1e-12)


def test_a_repeat_gives_the_same_bits():
    def run():
        parts, _ = prisms_in_a_box()
        play = Play(parts)
        for _ in range(5):
            assert play.step(0.4) == DONE
        return b"".join(array.tobytes() for array in play.state)

    assert run() == run()
