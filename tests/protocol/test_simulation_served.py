"""The real simulation behind the protocol gives, bit for bit, what it gives when it is called directly."""

import numpy as np
import pytest
from protocol_peers import Peers
from scenes_by_hand import fixed_box, free_box, scene_of

from comotion_protocol import LocalProtocolError, Wants
from comotion_server.simulation import Simulation

DT = 0.05
STEPS = 12


def simulation():
    """A box that falls on a floor and turns there, within the steps of these tests."""
    box = free_box(
        size=(1.0, 1.0, 0.5), position=(0.1, 0.0, 0.9), velocity=(0.0, 0.0, -3.0), angular_velocity=(1.0, 2, 0)
    )
    return Simulation(scene_of(box, fixed_box("floor", (4.0, 4.0, 1.0), (0.0, 0.0, -0.5)), gravity=(0.0, 0.0, -9.81)))


def forces_at(n):
    return {"box": np.random.default_rng(n).normal(size=(8, 3))}


@pytest.mark.parametrize("kind", ["memory", "zenoh"])
@pytest.mark.parametrize("sample", ["end", "midpoint"])
def test_the_same_bits_as_without_a_network(kind, sample):
    direct, impacts = simulation(), 0
    offset = DT / 2 if sample == "midpoint" else 0.0
    wants = Wants(sample=sample, velocities=True, poses=True, twists=True, impacts=True, contacts=True)
    with Peers(kind, simulation()) as peers, peers.open(wants=wants, dt=DT) as motion:
        seen = direct.sample(offset)
        assert motion.vertices["box"].tobytes() == seen.vertices["box"].tobytes()
        for n in range(STEPS):
            direct.mark_sent(seen)
            out = direct.step(DT, forces_at(n))
            seen = direct.sample(offset, velocities=True)
            if n % 3 == 1:  # a try that is thrown away changes nothing of what follows
                motion.step(2 * DT, forces_at(n + 100))
                reply = motion.redo(DT, forces_at(n))
            else:
                reply = motion.step(DT, forces_at(n))
            for region in ("box", "floor"):
                assert reply.vertices[region].tobytes() == seen.vertices[region].tobytes()
                assert reply.velocities[region].tobytes() == seen.velocities[region].tobytes()
            assert (reply.poses.tobytes(), reply.twists.tobytes()) == (seen.poses.tobytes(), seen.twists.tobytes())
            assert [(i.time, i.body_a, i.impulse) for i in reply.impacts] == [
                (i.time, i.body_a, i.impulse) for i in out.impacts
            ]
            assert reply.sums.moment == tuple(out.sums.moment)
            assert reply.books.impacts == len(out.impacts)
            impacts += len(out.impacts)
    assert impacts > 0


def test_what_the_simulation_cannot_take_leaves_it_as_it_was(peers):
    with Peers(peers.kind, simulation()) as served, served.open() as motion:
        motion.step(DT, forces_at(0))
        before = served.engine.bodies.position.tobytes()
        with pytest.raises(LocalProtocolError, match=r"range of numbers|too large") as refusal:
            motion.step(1e160, {"box": np.full((8, 3), 1e200)})
        assert (refusal.value.code, refusal.value.rule) == ("bad_step", "F8")
        assert served.engine.bodies.position.tobytes() == before
        assert motion.step(DT, forces_at(1)).step == 2
