"""The scenes that come with comotion give the answers that their page states, and never an intersection."""

from dataclasses import replace

import numpy as np
import pytest
from played import angular_momentum, energy, hits, momentum, play, row_of, smallest_gap
from protocol_peers import Peers

from comotion_mock_cfd.cfd_client import CfdClient, wants
from comotion_mock_cfd.fluid import load_fluid
from comotion_mock_cfd.scenes import path_of
from comotion_server.scene import Free, load_scene
from comotion_server.simulation import Simulation

EXACT = 1e-8  # meshes at the default tolerance; the STL files' corners are float32


def shipped(name):
    return Simulation.load(path_of(name))


def worst_books(out):
    return max(max(step.books.momentum, step.books.angular_momentum, step.books.energy) for step in out)


def test_cradle_cubes():
    sim = shipped("cradle_cubes")
    out = [sim.step(sim.scene.dt) for _ in range(200)]
    expected = np.zeros((5, 3))
    expected[row_of(sim, "cube-004")] = [1.0, 0.0, 0.0]
    np.testing.assert_allclose(sim.bodies.velocity, expected, atol=EXACT)
    np.testing.assert_allclose(sim.bodies.angular_velocity, 0.0, atol=EXACT)
    assert worst_books(out) <= 1e-12
    assert {round(impact.time, 8) for step in out for impact in step.impacts} == {0.375}


def test_staircase():
    sim = shipped("staircase")
    impacts = play(sim, 2.5, sim.scene.dt)
    speeds = 10.0 / (10.0 + np.arange(9))
    gaps = np.array([0.125, *[0.1875] * 7])
    found = [hits(impacts, "floe-001", "hull")[0]]
    found += [hits(impacts, f"floe-{k:03d}", f"floe-{k + 1:03d}")[0] for k in range(1, 8)]
    np.testing.assert_allclose(found, np.cumsum(gaps / speeds[:-1]), atol=EXACT)
    np.testing.assert_allclose(sim.bodies.velocity[:, 0], speeds[-1], atol=EXACT)


def test_bounce_mesh():
    sim = shipped("bounce_mesh")
    first = np.sqrt(2.0 / 9.81)
    found = hits(play(sim, 8.5, 0.01))
    exact = first * (1.0 + 2.0 * np.cumsum([0.0, *0.9 ** np.arange(1, 44)]))
    np.testing.assert_allclose(found, exact, atol=1e-7)
    play(sim, 0.5, 0.01)
    assert not sim.bodies.velocity.any()


def test_linked():
    """Momentum, angular momentum and energy; no intersection means that the rings stay linked."""
    sim = shipped("linked")
    before = energy(sim), momentum(sim), angular_momentum(sim)
    count = 0
    for _ in range(400):
        out = sim.step(sim.scene.dt)
        count += len(out.impacts)
        assert worst_books([out]) <= 1e-12
        assert smallest_gap(sim) > 0.0
    assert count > 3
    assert energy(sim) == pytest.approx(before[0], rel=1e-12)
    np.testing.assert_allclose(momentum(sim), before[1], atol=1e-13)
    np.testing.assert_allclose(angular_momentum(sim), before[2], atol=1e-12)


def test_tumble():
    sim = shipped("tumble")
    before, out = energy(sim), []
    for _ in range(10):
        out += [sim.step(sim.scene.dt) for _ in range(20)]
        assert smallest_gap(sim) > 0.0
        assert energy(sim) < before  # e = 0.9
    assert sum(step.books.impacts for step in out) > 100
    assert worst_books(out) <= 1e-12


FLOES, FLOE_MASS, SPEED = 5, 4.14, 0.5  # of `push`


class Balance:
    """Contact impulses on the hull of `push`, step by step, against what its floes gained and their drag."""

    def __init__(self):
        self.resistance, self.wrong, self.velocity = [], [], 0.0

    def add(self, step):
        on_hull = 0.0
        for contact in step.reply.contacts:
            if "hull" in (contact.body_a, contact.body_b):
                on_hull += contact.impulse[0] if contact.body_b == "hull" else -contact.impulse[0]
        velocity = step.reply.twists[:FLOES, 0].sum()  # in the order of names the floes come before the hull
        gained = FLOE_MASS * (velocity - self.velocity)
        drag = step.wrenches[:FLOES, 0].sum() * step.dt
        self.wrong.append(gained - drag + on_hull)
        self.resistance.append(-on_hull / step.dt)
        self.velocity = velocity


def test_push():
    """The steady contact resistance is the drag of the floes, and never falls to zero; momentum balances every step."""
    balance, scene = Balance(), load_fluid(path_of("push"))
    with Peers("memory", shipped("push")) as peers, peers.open(wants=wants(), dt=scene.dt) as motion:
        CfdClient(motion, scene).run(balance.add)
    np.testing.assert_allclose(balance.wrong, 0.0, atol=1e-11 * FLOE_MASS * SPEED)
    steady = np.array(balance.resistance[300:])
    np.testing.assert_allclose(steady, 8.9925, rtol=1e-6)


def test_momentum_of_hull_floes_and_banks_balances_in_every_step():
    """The ice channel with its ice on the way to the banks: m dv = contacts + fluid + weight + thrust."""
    whole, fluid = load_scene(path_of("channel_thrust")), replace(load_fluid(path_of("channel_thrust")), duration=0.7)
    bodies = [
        replace(body, velocity=np.array([0.0, 0.5 * np.sign(body.position[1]), 0.0]))
        if body.name.startswith("floe")
        else body
        for body in whole.bodies
    ]
    sim = Simulation(replace(whole, bodies=tuple(bodies)))
    names, mass = sim.bodies.names, sim.bodies.mass
    free = np.array([isinstance(body.motion, Free) for body in bodies])
    hull = row_of(sim, "hull")
    outside = mass[:, None] * whole.gravity
    outside[hull] += bodies[hull].motion.thrust
    velocity, wrong, total, met = sim.bodies.velocity, [], [], set()

    def add(step):
        nonlocal velocity
        contacts = np.zeros((len(names), 3))
        for contact in step.reply.contacts:
            contacts[names.index(contact.body_a)] -= contact.impulse
            contacts[names.index(contact.body_b)] += contact.impulse
            met.add(frozenset(name.partition("-")[0] for name in (contact.body_a, contact.body_b)))
        forces = (outside + step.wrenches[:, :3]) * step.dt
        gained = mass[:, None] * (step.reply.twists[:, :3] - velocity)
        left = gained - contacts - forces
        left[hull, 1] = 0.0  # locked
        wrong.append(left[free])
        everything = (gained - forces)[free].sum(axis=0) + contacts[~free].sum(axis=0)
        total.append(everything[[0, 2]])
        velocity = step.reply.twists[:, :3]

    with Peers("memory", sim) as peers, peers.open(wants=wants("end"), dt=fluid.dt) as motion:
        CfdClient(motion, fluid).run(add)
    assert met >= {frozenset({"bank", "floe"}), frozenset({"hull", "floe"}), frozenset({"floe"})}
    scale = mass[free] * 0.5  # momenta [N s]: at the hull's speed
    np.testing.assert_array_less(np.abs(wrong) / scale[:, None], 1e-11)
    np.testing.assert_array_less(np.abs(total) / scale.sum(), 1e-11)


def test_channel():
    sim = shipped("channel")
    out = []
    for _ in range(20):
        out += [sim.step(sim.scene.dt) for _ in range(10)]
        assert smallest_gap(sim, 0.002) > 0.0
    assert worst_books(out) <= 1e-12
    assert {step.status for step in out} == {"ok"}


@pytest.mark.parametrize("name", ["channel_thrust", "free_water"])
def test_ships_in_ice(name):
    """The first contacts: books, and bodies that stay apart by what their frames have to spare."""
    sim, scene, out = shipped(name), replace(load_fluid(path_of(name)), duration=0.6), []
    with Peers("memory", sim) as peers, peers.open(wants=wants(), dt=scene.dt) as motion:
        CfdClient(motion, scene).run(out.append)
    hull = row_of(sim, "hull")
    met = [contact for step in out for contact in step.reply.contacts if "hull" in (contact.body_a, contact.body_b)]
    assert met
    assert smallest_gap(sim, 0.002) >= 2 * 0.0005 - EXACT
    assert {step.reply.status for step in out} == {"ok"}
    assert sim.bodies.velocity[hull, 0] == pytest.approx(0.5, rel=0.01)
