"""Hexagonal floes that meet at the same time: one problem, symmetric answers (VALIDATION B).

Faces of a hexagon look along the lines between the centres of a honeycomb: the answers are those of round bodies.
"""

import numpy as np
import pytest
from played import momentum, play
from scenes_by_hand import plane, scene_of, solid

from comotion_mock_cfd.body_forms import floe_mesh
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import quaternion_of
from comotion_server.simulation import Simulation

EXACT = 1e-9  # what meshes at the default tolerance have to reach
SIDE = 0.5
ACROSS = np.sqrt(3.0) * SIDE  # from face to face: the distance of touching centres
POINTING = quaternion_of(np.array([0.0, 0.0, np.pi / 6]))  # corners along y, faces at 0, 60, ... degrees


def hexagon(name, at, velocity=(0.0, 0.0), quaternion=POINTING):
    mesh = TriangleMesh(*floe_mesh(SIDE, 0.25))
    place, v = (*at, 0.0), (*velocity, 0.0)
    return solid(name, mesh, mass=1.0, position=place, velocity=v, quaternion=quaternion)


def towards(degrees, length=1.0):
    angle = np.radians(degrees)
    return length * np.array([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("law", ["together"])
@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
def test_three_body_break(e, law):
    """One comes at v0 between two that touch: v1 = (v0 / 2.5) (1 - 1.5 e), the others cos 30 deg (e v0 + v1)."""
    speed, start = 1.0, 0.25
    cue = hexagon("cue", (-start, 0.0), (speed, 0.0), quaternion=np.array([1.0, 0.0, 0.0, 0.0]))
    others = [
        hexagon(name, towards(angle, ACROSS), quaternion=np.array([1.0, 0.0, 0.0, 0.0]))
        for name, angle in (("port", 30.0), ("starboard", -30.0))
    ]
    sim = Simulation(scene_of(cue, *others, restitution=e, simultaneous=law))
    play(sim, 0.3, 0.01)
    slow = speed / 2.5 * (1.0 - 1.5 * e)
    out = np.cos(np.pi / 6) * (e * speed + slow)
    exact = [[slow, 0.0], towards(30.0, out), towards(-30.0, out)]
    np.testing.assert_allclose(sim.bodies.velocity[:, :2], exact, atol=EXACT)
    np.testing.assert_allclose(sim.bodies.angular_velocity, 0.0, atol=EXACT)
    np.testing.assert_allclose(momentum(sim), [speed, 0.0, 0.0], atol=1e-13)


def test_a_ring_breathes_for_ever():
    """Six hexagons fall inwards, all touch their neighbours at once, fly out, and all hit the wall at once."""
    inner, outer, speed = 1.25 * ACROSS, 1.5 * ACROSS, 0.5
    angles = 60.0 * np.arange(6)
    ring = [hexagon(f"h{k}", towards(a, inner), towards(a, -speed)) for k, a in enumerate(angles)]
    walls = [
        plane(f"wall-{k}", (*towards(a, -1.0), 0.0), (*towards(a, outer + 0.5 * ACROSS), 0.0))
        for k, a in enumerate(angles)
    ]
    sim = Simulation(scene_of(*ring, *walls, restitution=1.0))
    breath = 2.0 * (outer - ACROSS) / speed
    impacts = play(sim, 4.0 * breath, breath / 40.0)
    radii = np.linalg.norm(sim.bodies.position[:6, :2], axis=1)
    # four breaths, each shorter by the gap that counts as contact, twice
    np.testing.assert_allclose(radii, inner, atol=8 * 1e-9)
    np.testing.assert_allclose(radii, radii[0], rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(sim.bodies.velocity[:6], axis=1), speed, rtol=1e-12)
    np.testing.assert_allclose(sim.bodies.angular_velocity, 0.0, atol=1e-10)
    assert len({frozenset((i.body_a, i.body_b)) for i in impacts}) == 12


def test_listed_in_another_order_the_same_bits():
    def play_in(order):
        cue = hexagon("m", (-1.5, 0.1), (1.0, 0.0))
        others = [hexagon(name, towards(angle, ACROSS)) for name, angle in (("a", 0.0), ("z", 60.0), ("k", 120.0))]
        bodies = [cue, *others]
        sim = Simulation(scene_of(*(bodies[k] for k in order), restitution=0.5))
        play(sim, 3.0, 0.05)
        return sim.bodies.position.tobytes(), sim.bodies.quaternion.tobytes(), sim.bodies.velocity.tobytes()

    assert play_in([0, 1, 2, 3]) == play_in([2, 0, 3, 1])
