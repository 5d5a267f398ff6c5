"""Where the work of a step is used up, an island goes on by time-stepping: of first order, but true to its books."""

import numpy as np
import pytest
from played import energy, row_of, smallest_gap
from scenes_by_hand import free_box, moved_box, plane, scene_of, solid

import comotion_server.island_flight
import comotion_server.islands
from comotion_mock_cfd.body_forms import floe_mesh
from comotion_server.kernels.impact_cluster import CAPPED
from comotion_server.meshes import TriangleMesh
from comotion_server.quaternions import quaternion_of
from comotion_server.scene import Free
from comotion_server.simulation import Simulation

FLAT = Free(locked=(False, False, True, True, True, False))


@pytest.fixture
def no_flights(monkeypatch):
    """All that rests goes on by time-stepping: how many such steps were taken, in a list of one number."""
    monkeypatch.setattr(comotion_server.islands, "MOST_PASSES", -1)
    taken, stride = [0], comotion_server.islands.stride

    def counting(*args):
        taken[0] += 1
        return stride(*args)

    monkeypatch.setattr(comotion_server.islands, "stride", counting)
    return taken


@pytest.fixture
def cut_short(monkeypatch):
    """A list of all times [s] at which a step of time-stepping was cut short."""
    times, complete = [], comotion_server.islands.Islands._complete

    def noting(self, island, time):
        if island.change is not None and not island.asleep and time < island.end * (1.0 - 1e-12):
            times.append(time)
        complete(self, island, time)

    monkeypatch.setattr(comotion_server.islands.Islands, "_complete", noting)
    return times


def crowd(speed, walls=0.0, **collisions):
    """Twelve hexagons at random velocities among four planes, two of which close in."""
    mesh = TriangleMesh(*floe_mesh(0.25, 0.1))
    random = np.random.default_rng(5)
    floes = [
        solid(
            f"floe-{i}{j}",
            mesh,
            mass=1.0,
            motion=FLAT,
            position=(0.55 * i, 0.55 * j, 0.0),
            velocity=(*random.uniform(-speed, speed, 2), 0.0),
            quaternion=quaternion_of(np.array([0.0, 0.0, random.uniform(0.0, 1.0)])),
        )
        for i in range(4)
        for j in range(3)
    ]
    sides = [
        plane("north", (0.0, -1.0, 0.0), (0.0, 1.4, 0.0)),
        plane("south", (0.0, 1.0, 0.0), (0.0, -0.3, 0.0)),
        plane("east", (-1.0, 0.0, 0.0), (1.95, 0.0, 0.0), (-walls, 0.0, 0.0)),
        plane("west", (1.0, 0.0, 0.0), (-0.3, 0.0, 0.0), (walls, 0.0, 0.0)),
    ]
    return scene_of(*floes, *sides, restitution=0.0, **collisions)


def pushed(dt):
    """Positions (4,3) [m] of two boxes that a wall pushes against a weight, which they turn, after half a second."""
    boxes = [
        moved_box("hull", (0.2, 2.0, 1.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0)),
        free_box("first", (0.5, 0.5, 0.5), 1.0, position=(0.4, 0.1, 0.0), motion=FLAT),
        free_box("second", (0.5, 0.5, 0.5), 3.0, position=(0.95, -0.2, 0.0), motion=FLAT),
        free_box("third", (0.5, 1.5, 0.5), 2.0, position=(1.5, 0.3, 0.0), motion=FLAT),
    ]
    sim = Simulation(scene_of(*boxes, restitution=0.0))
    for _ in range(round(0.5 / dt)):
        sim.step(dt)
    return sim.bodies.position


def test_it_is_of_first_order(monkeypatch):
    """Measured: 1.9e-4 m at 50 ms, 1.1e-5 m at 1.6 ms."""
    exact = pushed(0.05)
    monkeypatch.setattr(comotion_server.islands, "MOST_PASSES", -1)
    long, short = (np.abs(pushed(0.05 / parts) - exact).max() for parts in (1, 16))
    assert 0.0 < long < 1e-3
    assert short < 0.2 * long


def test_packed_floes_are_pressed_without_a_hit_at_every_turn(no_flights):
    """A step is cut in five; what the looks ahead miss cuts it again. Measured: 25 at most, of up to three islands."""
    sim = Simulation(crowd(0.1, walls=0.25))
    counts = []
    for _ in range(20):
        before = no_flights[0]
        reply = sim.step(0.05)
        counts.append(no_flights[0] - before)
        assert smallest_gap(sim) > 0.0
        if reply.status == "blocked":
            break
    assert 0 < max(counts) <= 40


def test_every_floe_takes_what_its_contacts_give(no_flights, cut_short):
    """Also where something is hit on the way: what was meant for the rest of the way is taken back."""
    sim, random = Simulation(crowd(3.0, walls=0.25)), np.random.default_rng(3)
    free = np.isfinite(sim.bodies.mass)
    force = np.zeros((len(free), 6))
    for _ in range(12):
        force[free, :2] = random.uniform(-10.0, 10.0, (free.sum(), 2))
        before = sim.bodies.mass[:, None] * sim.bodies.velocity
        reply = sim.step(0.05, wrenches=force)
        taken = 0.05 * force[:, :3]
        for contact in reply.contacts:
            taken[row_of(sim, contact.body_a)] -= contact.impulse
            taken[row_of(sim, contact.body_b)] += contact.impulse
        change = sim.bodies.mass[:, None] * sim.bodies.velocity - before
        np.testing.assert_allclose(change[free, :2], taken[free, :2], rtol=0.0, atol=1e-12)
    assert no_flights[0] > 0
    assert len(cut_short) >= 5


def test_walls_give_all_the_energy_that_floes_gain(no_flights, cut_short):
    """Contacts of time-stepping give none of their own, whole steps or parts of them."""
    sim = Simulation(crowd(3.0, walls=0.25))
    for _ in range(20):
        before = energy(sim)
        reply = sim.step(0.05)
        work = 0.0
        for contact in reply.contacts:
            for name, sign in ((contact.body_a, 1.0), (contact.body_b, -1.0)):
                speed = {"west": 0.25, "east": -0.25}.get(name, 0.0)
                work += sign * speed * contact.impulse[0]
        assert energy(sim) - before <= work + 1e-7 * before
        if reply.status == "blocked":
            break
    assert no_flights[0] > 0
    assert len(cut_short) >= 5


def test_where_forces_are_not_found_it_goes_on(monkeypatch):
    """A solver that gives up leaves no flight behind on which nothing is held."""
    monkeypatch.setattr(comotion_server.island_flight, "try_flight", lambda *_: CAPPED)
    wall = moved_box("wall", (0.2, 2.0, 2.0), (0.0, 0.0, 0.0), (0.5, 0.0, 0.0))
    box = free_box("box", (1.0, 1.0, 1.0), 2.0, position=(0.61, 0.0, 0.0), motion=FLAT)
    sim = Simulation(scene_of(wall, box, restitution=0.0))
    against = np.zeros((2, 6))
    against[row_of(sim, "box"), 0] = -1.0
    replies = [sim.step(0.01, wrenches=against) for _ in range(20)]
    assert replies[-1].budget.fallback == pytest.approx(1.0)
    apart = sim.bodies.position[row_of(sim, "box")] - sim.bodies.position[row_of(sim, "wall")]
    np.testing.assert_allclose(apart, [0.6, 0.0, 0.0], atol=2e-8)
    np.testing.assert_allclose(sim.bodies.velocity, [[0.5, 0.0, 0.0]] * 2, atol=1e-12)


def test_a_flight_that_is_not_found_again_goes_on_as_it_was(monkeypatch):
    """Two boxes, one pushing the other, are hit; the solver gives up where the flight so far is taken again."""
    again, attempt, given_up = comotion_server.islands.fly_again, comotion_server.island_flight.try_flight, []

    def give_up(solids, flights, *rest):
        attempt(solids, flights, *rest)
        flights.acceleration[:], flights.torque[:] = 0.0, 0.0
        given_up.append(CAPPED)
        return CAPPED

    def fly_again(*args):
        monkeypatch.setattr(comotion_server.island_flight, "try_flight", give_up)
        again(*args)
        monkeypatch.setattr(comotion_server.island_flight, "try_flight", attempt)

    monkeypatch.setattr(comotion_server.islands, "fly_again", fly_again)
    behind, before = (
        free_box(name, (1.0, 1.0, 1.0), mass, position=(x, 0.0, 0.0), motion=FLAT)
        for name, mass, x in (("behind", 2.0, 0.0), ("before", 3.0, 1.01))
    )
    ball = free_box("comer", (0.2, 0.2, 0.2), 0.5, position=(1.85, 0.0, 0.0), velocity=(-0.5, 0.0, 0.0), motion=FLAT)
    sim = Simulation(scene_of(behind, before, ball, restitution=0.0))
    push, start = np.zeros((3, 6)), sim.bodies.mass @ sim.bodies.velocity
    push[row_of(sim, "behind"), 0] = 5.0
    for done in range(1, 21):
        sim.step(0.05, wrenches=push)
        gained = sim.bodies.mass @ sim.bodies.velocity - start
        np.testing.assert_allclose(gained, [5.0 * 0.05 * done, 0.0, 0.0], rtol=0, atol=1e-12)
    assert given_up


def test_it_takes_energy(no_flights):
    """What the turning of a normal will ask for is given in advance, then taken: up to 4e-8 of the energy."""
    sim = Simulation(crowd(0.5))
    energies = [energy(sim)]
    for _ in range(40):
        sim.step(0.05)
        energies.append(energy(sim))
    assert no_flights[0] > 0
    assert np.diff(energies).max() <= 1e-7 * energies[0]
    assert energies[-1] < 0.2 * energies[0]


@pytest.mark.usefixtures("no_flights")
def test_a_used_up_budget_holds_what_is_left():
    """Pressed floes that ask for too much work stay where they are; the step ends, without overlap, and says so."""
    sim = Simulation(crowd(0.1, walls=0.25, budget=200))
    replies = []
    for _ in range(20):
        replies.append(sim.step(0.05))
        assert smallest_gap(sim) > 0.0
    assert replies[-1].budget.exhausted
    assert replies[-1].budget.used < 1000
    assert np.abs(sim.bodies.velocity[np.isfinite(sim.bodies.mass)]).max() < 1.0
