"""The paper's queue (P9, P10, P14) on boxes whose collisions can be worked out by hand."""

import numpy as np
import pytest
from scenes_by_hand import fixed_box, free_box, moved_box, scene_of, solid

from comotion_server.meshes import TriangleMesh, box
from comotion_server.scene import Free, SceneError
from comotion_server.simulation import Simulation

CUBE = (1.0, 1.0, 1.0)
SLIDING = Free(locked=(False, True, True, True, True, True))  # along x alone


def two_cubes(gap, speed, **collisions):
    """Cube a comes at `speed` over `gap` towards cube b at rest, both able to move along x alone."""
    a = free_box("a", CUBE, 1.0, velocity=(speed, 0.0, 0.0), motion=SLIDING)
    b = free_box("b", CUBE, 1.0, position=(1.0 + gap, 0.0, 0.0), motion=SLIDING)
    return Simulation(scene_of(a, b, **collisions))


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_rule_paper_responds_first_and_then_advances(substeps):
    """P10 (a), (b): the impulse comes at the beginning of the step in which the bodies would meet."""
    sim = two_cubes(0.505, 1.0, rule="paper", substeps=substeps, restitution=1.0)
    for _ in range(50):
        assert not sim.step(0.01).impacts
    out = sim.step(0.01)
    (impact,) = out.impacts
    assert impact.time == pytest.approx(0.5, abs=1e-15)
    np.testing.assert_allclose(sim.bodies.position[:, 0], [0.5, 1.505 + 0.01], atol=1e-14)
    assert out.budget.used == 1  # afterwards they part, and nothing else is in the queue


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_rule_paper_advance_closes_the_gap_and_then_responds(substeps):
    sim = two_cubes(0.505, 1.0, rule="paper-advance", substeps=substeps, restitution=1.0, tolerance=1e-9)
    impacts = [impact for _ in range(51) for impact in sim.step(0.01).impacts]
    (impact,) = impacts
    size = np.sqrt(3.0)
    assert impact.time == pytest.approx(0.505, abs=2e-9 * size)
    np.testing.assert_allclose(sim.bodies.position[:, 0], [0.505, 1.51], atol=4e-9 * size)


def test_the_gap_shrinks_by_one_part_in_n_per_round():
    """P10 (b): with N sub-steps the gap is multiplied by (N - 1) / N until it is within the tolerance."""
    sim = two_cubes(0.008, 1.0, rule="paper-advance", substeps=4, restitution=1.0, tolerance=1e-6)
    rounds = int(np.ceil(np.log(1e-6 * np.sqrt(3.0) / 0.008) / np.log(3.0 / 4.0)))
    assert sim.step(0.01).budget.used == rounds + 1  # and the round of the response


def test_closeness_comes_from_distances_at_two_sub_steps():
    """P9: after a first step the approach speed is the change of distance, not the present closing speed.

    Cube a is pushed: over the last step it came closer at 1.05 m/s, at its end it moves at 1.1 m/s. The pair is in the
    queue only if gap / speed fits into the step.
    """
    between = 0.01 * (1.05 + 1.1) / 2.0
    for gap_left, expected in ((between, 0), (0.01 * 1.04, 1)):
        sim = two_cubes(0.0105 + gap_left, 1.0, rule="paper", restitution=1.0)
        sim.step(0.01, wrenches=[[10.0, 0, 0, 0, 0, 0], [0.0] * 6])
        assert len(sim.step(0.01).impacts) == expected


def test_simultaneous_pairs_are_answered_together():
    """P10 (a): a cube between two that come from both sides at the same time."""
    left = free_box("a", CUBE, 1.0, position=(-1.105, 0.0, 0.0), velocity=(1.0, 0.0, 0.0), motion=SLIDING)
    middle = free_box("b", CUBE, 1.0, motion=SLIDING)
    right = free_box("c", CUBE, 1.0, position=(1.105, 0.0, 0.0), velocity=(-1.0, 0.0, 0.0), motion=SLIDING)
    sim = Simulation(scene_of(left, middle, right, rule="paper", restitution=1.0))
    first, second, *_ = [impact for _ in range(11) for impact in sim.step(0.01).impacts]
    assert [(i.body_a, i.body_b) for i in (first, second)] == [("a", "b"), ("b", "c")]
    assert first.time == second.time


def test_a_found_intersection_collides_where_it_was_last_apart():
    """P14: a box under gravity falls faster than its approach speed said, so N = 1 advances into the floor."""
    box, floor = (
        free_box("box", CUBE, 1.0, position=(0.0, 0.0, 0.505)),
        fixed_box("floor", (4.0, 4.0, 1.0), (0, 0, -0.5)),
    )
    scene = scene_of(box, floor, gravity=(0.0, 0.0, -10.0), rule="paper-advance", substeps=1, restitution=0.5)
    sim = Simulation(scene)
    v0, g, gap = 1.0, 10.0, 0.005
    sim._world.state.velocity[0, 2] = -v0
    out = sim.step(0.01)
    predicted = gap / v0
    depth = 0.5 * g * predicted**2
    assert out.books.overlaps == 1
    assert out.books.overlap_max == pytest.approx(depth, rel=1e-9)
    (impact,) = out.impacts
    assert impact.time == pytest.approx(predicted, rel=1e-12)
    assert impact.approach_speed == pytest.approx(v0 + g * predicted, rel=1e-12)
    up, rest = 0.5 * (v0 + g * predicted), 0.01 - predicted
    assert sim.bodies.position[0, 2] == pytest.approx(0.5 - depth + up * rest - 0.5 * g * rest**2, rel=1e-12)


def test_an_intersection_is_answered_once_and_then_left_out():
    """P14: a cube between a moving wall and a fixed one stays in both: each pair answers once a step, nothing hangs."""
    wall = moved_box("wall", CUBE, (-1.2, 0.0, 0.0), (10.0, 0.0, 0.0))
    cube = free_box("cube", CUBE, 1.0)
    stop = fixed_box("stop", CUBE, (1.2, 0.0, 0.0))
    sim = Simulation(scene_of(wall, cube, stop, rule="paper-advance", substeps=1, restitution=0.0))
    outs = [sim.step(0.01) for _ in range(20)]
    assert any(out.books.overlaps for out in outs)
    assert max(out.budget.used for out in outs) < 50
    assert not any(out.budget.exhausted for out in outs)


def test_a_used_up_budget_is_said_and_the_step_still_ends():
    sim = two_cubes(0.008, 1.0, rule="paper-advance", substeps=4, budget=3)
    out = sim.step(0.01)
    assert out.budget.exhausted
    assert out.time == 0.01
    assert not out.impacts


def test_contacts_are_the_sum_of_the_impulses_and_explain_the_momentum():
    sim = two_cubes(0.1, 1.0, restitution=0.5)
    before = sim.bodies.velocity
    outs = [sim.step(0.01) for _ in range(20)]
    contacts = [contact for out in outs for contact in out.contacts]
    impacts = [impact for out in outs for impact in out.impacts]
    total = sum(contact.impulse for contact in contacts)
    np.testing.assert_allclose(total, sum(impact.impulse * impact.normal for impact in impacts), rtol=1e-15)
    np.testing.assert_allclose(sim.bodies.velocity[1] - before[1], total, rtol=1e-14)
    np.testing.assert_allclose(sim.bodies.velocity[0] - before[0], -total, rtol=1e-14)


def test_bodies_that_touch_at_the_start_are_refused_by_name():
    with pytest.raises(SceneError, match=r'bodies "a" and "b": touch or overlap at the start'):
        two_cubes(0.0, 1.0, rule="paper")
    with pytest.raises(SceneError, match="touch or overlap"):
        two_cubes(-0.3, 1.0, rule="paper-advance")


def test_rule_exact_gives_bodies_that_touch_a_gap_and_refuses_those_that_overlap():
    sim = two_cubes(0.0, 0.0)
    gap = sim.bodies.position[1, 0] - sim.bodies.position[0, 0] - 1.0
    assert 0.0 < gap < 1e-7
    with pytest.raises(SceneError, match=r'bodies "a" and "b": overlap at the start'):
        two_cubes(-0.3, 1.0)


@pytest.mark.parametrize("rule", ["exact", "paper", "paper-advance"])
def test_a_body_inside_another_is_refused_by_name(rule):
    inner, outer = free_box("inner", (0.2, 0.2, 0.2), 1.0), free_box("outer", (1.0, 1.0, 1.0), 1.0)
    with pytest.raises(SceneError, match=r'bodies "inner" and "outer": the first is inside the second at the start'):
        Simulation(scene_of(inner, outer, rule=rule))


def test_a_body_that_stands_on_another_with_corners_on_its_face_is_not_inside():
    seat = free_box("seat", (1.0, 1.0, 1.0), 1.0, position=(0.3, 0.2, 0.5))
    for sunk in (0.0, 1e-7):
        floor = fixed_box("floor", (1.0, 1.0, 1.0), (0.0, 0.0, -0.5 + sunk))
        assert Simulation(scene_of(seat, floor, rule="exact")).step(0.1).status == "ok"


@pytest.mark.parametrize("rule", ["exact", "paper"])
def test_a_body_in_a_cavity_is_inside_nothing(rule):
    outer, inner = box([1.0, 1.0, 1.0]), box([0.8, 0.8, 0.8])
    vertices = np.vstack([outer.vertices, inner.vertices])
    triangles = np.vstack([outer.triangles, inner.triangles[:, ::-1] + np.uint32(len(outer.vertices))])
    room = solid("room", TriangleMesh(vertices, triangles), mass=1.0)
    sim = Simulation(scene_of(free_box("body", (0.2, 0.2, 0.2), 1.0), room, rule=rule))
    assert sim.step(0.1).status == "ok"


def tumbling_boxes(rng, names):
    places = [(x, y, z) for x in (0.0, 2.2) for y in (0.0, 2.2) for z in (0.0, 2.2)]
    return [
        free_box(
            name,
            (1.0, 1.1, 1.2),
            1.0,
            position=place,
            velocity=-0.8 * (np.array(place) - 1.1) + 0.1 * rng.normal(size=3),
            angular_velocity=rng.normal(size=3),
        )
        for name, place in zip(names, places, strict=True)
    ]


@pytest.mark.parametrize("rule", ["paper", "paper-advance"])
def test_books_of_a_tumbling_crowd_close_and_repeat_bit_for_bit(rng, rule):
    """Eight triaxial boxes crash into each other: momentum is kept, and neither listing nor repeating matters."""
    boxes = tumbling_boxes(rng, "abcdefgh")

    def play(bodies):
        sim = Simulation(scene_of(*bodies, rule=rule, substeps=2, restitution=0.8, parallel="off"))
        momentum = sim.bodies.velocity.sum(axis=0)
        outs = [sim.step(0.01) for _ in range(150)]
        np.testing.assert_allclose(sim.bodies.velocity.sum(axis=0), momentum, atol=1e-13)
        return sim, outs

    sim, outs = play(boxes)
    assert sum(out.books.impacts for out in outs) > 20
    for out in outs:
        assert max(out.books.momentum, out.books.angular_momentum, out.books.energy) < 1e-13
    again, _ = play(boxes[::-1])
    for name in ("position", "quaternion", "velocity", "angular_velocity"):
        np.testing.assert_array_equal(getattr(again.bodies, name), getattr(sim.bodies, name))


def test_a_step_taken_again_from_a_checkpoint_is_the_same_bit_for_bit(rng):
    sim = Simulation(scene_of(*tumbling_boxes(rng, "abcdefgh"), rule="paper-advance", parallel="off"))
    for _ in range(60):
        sim.step(0.01)
    kept = sim.checkpoint()
    sim.sample(0.02)  # a prediction leaves no trace
    first = [sim.step(0.01) for _ in range(40)]
    ends = sim.bodies.position, sim.bodies.angular_velocity
    sim.restore(kept)
    second = [sim.step(0.01) for _ in range(40)]
    assert any(out.impacts for out in first)
    for ours, theirs in zip(ends, (sim.bodies.position, sim.bodies.angular_velocity), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert [out.books for out in first] == [out.books for out in second]


def staircase(floes, restitution, hull_mass, **collisions):
    """A hull slides towards a row of equal floes with equal gaps, all along x alone (VALIDATION F)."""
    hull = free_box("hull", CUBE, hull_mass, velocity=(1.0, 0.0, 0.0), motion=SLIDING)
    row = [free_box(f"ice-{k}", CUBE, 1.0, position=(1.3 + 1.3 * k, 0.0, 0.0), motion=SLIDING) for k in range(floes)]
    return Simulation(scene_of(hull, *row, restitution=restitution, **collisions))


@pytest.mark.parametrize("rule", ["paper", "paper-advance"])
def test_a_free_hull_loses_the_same_share_of_its_speed_to_each_floe(rule):
    """e = 1, equal floes: each floe hands its speed on to the next, so V_k = U ((M - m) / (M + m))^k."""
    sim = staircase(4, 1.0, 10.0, rule=rule, substeps=2)
    hits = (any("hull" in (i.body_a, i.body_b) for i in sim.step(0.005).impacts) for _ in range(600))
    speeds = [1.0, *(sim.bodies.velocity[0, 0] for hit in hits if hit)]
    assert len(speeds) > 4
    np.testing.assert_allclose(speeds, (9.0 / 11.0) ** np.arange(len(speeds)), rtol=1e-13)


def test_impact_times_of_a_row_of_floes():
    """e = 0: hull and floes go on together, V_k = M U / (M + k m), so gap d is closed after d / V_k."""
    gap, mass = 0.3, 10.0
    sim = staircase(3, 0.0, mass, rule="paper-advance", tolerance=1e-9, parallel="off")
    impacts = [impact for _ in range(400) for impact in sim.step(0.005).impacts]
    first = {}
    for impact in impacts:
        first.setdefault((impact.body_a, impact.body_b), impact.time)
    exact = np.cumsum([gap * (mass + k) / mass for k in range(3)])
    times = [first["hull", "ice-0"], first["ice-0", "ice-1"], first["ice-1", "ice-2"]]
    # a contact is up to the tolerance early, 1e-9 of the size; the gaps that are left add up
    np.testing.assert_allclose(times, exact, atol=2e-8)
