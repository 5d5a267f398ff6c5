"""The scenes that come with comotion hold what they promise, checked as the server reads them."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from comotion_mock_cfd.fluid import load_fluid
from comotion_mock_cfd.fluid_forces import fluid_forces
from comotion_mock_cfd.nodal import wrench_about
from comotion_mock_cfd.scenes import names, path_of
from comotion_server.scene import Fixed, Plane, Prescribed, check_scene, load_scene


def placed(body):
    """World vertices [m] of a body at time 0."""
    w, *v = body.quaternion
    x = body.mesh.vertices
    turned = x + 2 * w * np.cross(v, x) + 2 * np.cross(v, np.cross(v, x))
    return turned + body.position


def outline(body):
    """Corners of a prism seen from above, shape (3, 2), counter-clockwise."""
    points = placed(body)[:3, :2]
    a, b = points[1] - points[0], points[2] - points[0]
    return points if a[0] * b[1] > a[1] * b[0] else points[::-1]


def clear(p, q):
    """Largest gap [m] between two convex outlines along the normals of their edges; negative if they overlap."""
    gaps = []
    for one, other in ((p, q), (q, p)):
        edge = np.roll(one, -1, axis=0) - one
        normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1, keepdims=True)
        gaps.append(((other[None] - one[:, None]) * normal[:, None]).sum(axis=-1).min(axis=1).max())
    return max(gaps)


def test_names_and_paths():
    assert names() == (
        *("billiard", "blockage", "bounce", "bounce_mesh", "channel", "channel_thrust", "cradle", "cradle_cubes"),
        *("drop", "elastic", "float_box", "free_water", "gas", "jam", "jam_1000", "linked", "pipe", "pipe_capped"),
        *("push", "ring", "staircase", "tumble"),
    )
    with pytest.raises(KeyError, match="no shipped scene 'tank'; there are billiard, blockage, bounce, bounce_mesh"):
        path_of("tank")


@pytest.mark.parametrize("name", names())
def test_both_sides_read_the_same_scene(name):
    scene, fluid_scene = load_scene(path_of(name)), load_fluid(path_of(name))
    assert scene.name == fluid_scene.name == name
    assert (scene.dt, scene.duration) == (fluid_scene.dt, fluid_scene.duration)
    assert scene.gravity == pytest.approx([0, 0, -fluid_scene.gravity], abs=0)


def test_float_box_rests_at_the_draught_it_states():
    scene, fluid_scene = load_scene(path_of("float_box")), load_fluid(path_of("float_box"))
    (box,) = scene.bodies
    heave = fluid_scene.fluid.heave
    assert heave.body == box.name
    at_rest = placed(box) - [0, 0, placed(box)[:, 2].min() + heave.draught]
    lift = fluid_forces(fluid_scene, at_rest, np.zeros_like(at_rest), box.mesh.triangles).sum(axis=0)
    # The STL has float32 corners: 3e-8 relative each, on three edges.
    assert lift[2] == pytest.approx(box.mass * fluid_scene.gravity, rel=1e-7)
    assert placed(box)[:, 2].min() + heave.draught == pytest.approx(0.02, abs=1e-7)


def test_drop_starts_half_a_metre_above_a_fixed_floor():
    scene = load_scene(path_of("drop"))
    box, floor = scene.bodies
    assert isinstance(floor.motion, Fixed)
    assert placed(box)[:, 2].min() - placed(floor)[:, 2].max() == pytest.approx(0.5, abs=1e-7)
    assert scene.collisions.restitution == 0.5
    assert load_fluid(path_of("drop")).fluid is None


@pytest.fixture(scope="module")
def channel():
    return load_scene(path_of("channel")), load_fluid(path_of("channel"))


def test_the_channel_has_what_p22_describes(channel):
    scene, _ = channel
    assert {name: len(bodies) for name, bodies in scene.regions.items()} == {"banks": 2, "hull": 1, "ice": 28}
    hull = scene.regions["hull"][0]
    assert isinstance(hull.motion, Prescribed)
    assert hull.motion.velocity.tolist() == [0.5, 0.0, 0.0]
    assert hull.mass == 125.0
    assert all(isinstance(bank.motion, Fixed) for bank in scene.regions["banks"])
    assert {floe.mass for floe in scene.regions["ice"]} == {0.5}
    assert scene.duration == 6.0


def test_floes_and_hull_float_in_equilibrium(channel):
    scene, fluid_scene = channel
    for body in (*scene.regions["ice"], *scene.regions["hull"]):
        vertices = placed(body)
        forces = fluid_forces(fluid_scene, vertices, np.zeros_like(vertices), body.mesh.triangles)
        wrench = wrench_about(body.position, vertices, forces)
        weight = body.mass * fluid_scene.gravity
        # Floes: the scene gives 16 digits. The hull is held up by its prescription; its mesh displaces 124.997 kg.
        tolerance = 1e-12 if body.region == "ice" else 1e-4
        assert wrench[:3] == pytest.approx([0, 0, weight], abs=tolerance * weight)
        if body.region == "ice":
            assert wrench[3:] == pytest.approx(0.0, abs=1e-13 * weight)


def test_no_floe_overlaps_another_one_a_bank_or_the_hull(channel):
    scene, _ = channel
    outlines = [outline(floe) for floe in scene.regions["ice"]]
    assert min(clear(p, q) for i, p in enumerate(outlines) for q in outlines[:i]) > 0.005 - 1e-12
    bank_face = min(np.abs(placed(bank)[:, 1]).min() for bank in scene.regions["banks"])
    corners = np.concatenate(outlines)
    assert np.abs(corners[:, 1]).max() < bank_face
    # All floes lie ahead of the stem where it is above them.
    ice_top = placed(scene.regions["ice"][0])[:, 2].max()
    assert corners[:, 0].min() > 1.0 + ice_top / np.tan(np.radians(30.0))


def test_the_bow_reaches_the_ice_within_half_a_second(channel):
    scene, _ = channel
    # The waterline of the bow, 0.25 m further on, enters the outline of a floe.
    x = np.linspace(0.0, 1.0, 400)
    half_breadth = 0.307 * (1 - x**2)
    bow = np.concatenate([np.stack([x + 0.25, sign * half_breadth], axis=1) for sign in (1, -1)])
    entered = False
    for floe in scene.regions["ice"]:
        corners = outline(floe)
        edge = np.roll(corners, -1, axis=0) - corners
        arm = bow[:, None] - corners
        entered |= (edge[:, 0] * arm[..., 1] - edge[:, 1] * arm[..., 0] > 0).all(axis=1).any()
    assert entered


def test_the_bays_of_the_banks_begin_near_the_start_and_mirror_each_other(channel):
    scene, _ = channel
    starboard, port = sorted(map(placed, scene.regions["banks"]), key=lambda corners: corners[:, 1].mean())
    mirrored = starboard * [1.0, -1.0, -1.0]  # half a turn about x, and the same above and below
    order, other = (np.lexsort(np.round(corners, 6).T) for corners in (port, mirrored))
    np.testing.assert_allclose(port[order], mirrored[other], atol=1e-7)  # float32 of 5.8 m
    face = port[(port[:, 1] < 1.4) & (port[:, 2] > 0.0)]
    noses = face[face[:, 1] < 0.951]
    assert len(face) == 13
    assert (noses[:, 0].min(), noses[:, 0].max()) == pytest.approx((0.8, 5.8), abs=1e-6)
    assert face[(face[:, 0] > 1.0) & (face[:, 1] > 1.0)][:, 0].max() < 2.25


@pytest.mark.parametrize("name", ["channel", "channel_thrust", "free_water"])
def test_the_hull_collides_with_a_frame_of_its_own_and_floes_with_theirs(name):
    report = check_scene(path_of(name))
    hull = next(body for body in report.bodies if body.name == "hull")
    assert (hull.frame, hull.triangles, hull.frame_triangles) == ("hull_frame.stl", 1198, 142)
    assert hull.clearance == pytest.approx(2.6e-3, rel=0.01)  # what the scenes say
    floes = [body for body in report.bodies if body.region == "ice"]
    assert [body.clearance for body in floes] == pytest.approx([0.0005] * len(floes))


def test_the_hull_under_thrust_floats_at_rest_and_keeps_its_speed_in_open_water():
    scene, fluid_scene = load_scene(path_of("channel_thrust")), load_fluid(path_of("channel_thrust"))
    (hull,) = scene.regions["hull"]
    vertices, weight = placed(hull), hull.mass * fluid_scene.gravity

    def wrench(speed):
        moving = np.tile([speed, 0.0, 0.0], (len(vertices), 1))
        return wrench_about(hull.position, vertices, fluid_forces(fluid_scene, vertices, moving, hull.mesh.triangles))

    # The scene gives 9 digits of a draught of 0.25 m, and of the trim.
    assert wrench(0.0)[:3] == pytest.approx([0.0, 0.0, weight], abs=1e-6 * weight)
    assert wrench(0.0)[3:] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6 * weight)
    assert wrench(0.5)[0] == pytest.approx(-hull.motion.thrust[0], rel=0.01)


def test_the_floes_of_free_water_lie_apart_and_ahead_of_the_hull():
    scene = load_scene(path_of("free_water"))
    outlines = [outline(floe) for floe in scene.regions["ice"]]
    assert len(outlines) == 24
    assert min(clear(p, q) for i, p in enumerate(outlines) for q in outlines[:i]) > 0.005 - 1e-12
    assert min(corners[:, 0].min() for corners in outlines) > 1.05 - 1e-12


@pytest.mark.parametrize("name", names())
def test_the_page_lists_the_scene(name):
    page = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text(encoding="utf-8")
    listed = page.split("## Scenes that come with it")[1].split("## Limits")[0]
    assert f"`{name}`" in listed


def test_the_cubes_of_the_cradle_touch_and_the_striker_comes_later():
    striker = load_scene(path_of("cradle_cubes")).bodies[-1]
    cubes = load_scene(path_of("cradle_cubes")).bodies[:-1]
    faces = [(placed(cube)[:, 0].min(), placed(cube)[:, 0].max()) for cube in cubes]
    assert all(left[1] == right[0] for left, right in itertools.pairwise(faces))  # to the last bit: multiples of 1/64 m
    assert faces[0][0] - placed(striker)[:, 0].max() == 0.375 * striker.velocity[0]
    assert len({body.mass for body in (striker, *cubes)}) == 1


def test_the_gaps_of_the_staircase_are_equal():
    *floes, hull = load_scene(path_of("staircase")).bodies
    row = [hull, *floes]
    gaps = [placed(b)[:, 0].min() - placed(a)[:, 0].max() for a, b in itertools.pairwise(row)]
    assert gaps == [0.125, *([0.1875] * 7)]
    assert (hull.mass, {floe.mass for floe in floes}) == (10.0, {1.0})


def test_the_ball_of_bounce_mesh_starts_a_metre_above_its_floor():
    ball, floor = load_scene(path_of("bounce_mesh")).bodies
    assert isinstance(floor.shape, Plane)
    lowest = placed(ball)[np.argmin(placed(ball)[:, 2])]
    # The STL file's corners are float32, 4e-9 m here; the centre of mass moves by less.
    np.testing.assert_allclose(lowest, [0.0, 0.0, 1.0], atol=1e-9)
    assert ball.motion.locked[3:] == (True, True, True)


def test_the_floes_of_push_float_and_drag_as_the_scene_says():
    scene, fluid_scene = load_scene(path_of("push")), load_fluid(path_of("push"))
    floes = scene.regions["ice"]
    drag = 0.0
    for floe in floes:
        vertices = placed(floe)
        moving = np.tile(scene.bodies[-1].motion.velocity, (len(vertices), 1))
        force = fluid_forces(fluid_scene, vertices, moving, floe.mesh.triangles).sum(axis=0)
        assert force[2] == pytest.approx(floe.mass * fluid_scene.gravity, rel=1e-12)
        drag -= force[0]
    assert drag == pytest.approx(8.9925, rel=1e-12)  # what the scene and its page say


@pytest.mark.parametrize(("name", "count"), [("jam", 200), ("jam_1000", 1000)])
def test_the_floes_of_a_jam_lie_apart_between_their_walls(name, count):
    scene = load_scene(path_of(name))
    floes = scene.regions["ice"]
    assert len(floes) == count
    centres = np.array([floe.position for floe in floes])
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.eye(count)
    assert apart.min() >= 0.25 + 0.002 - 1e-12  # twice the circumradius and the gap
    low, high = centres.min(axis=0) - 0.125, centres.max(axis=0) + 0.125
    for wall in (*scene.regions["walls"], *scene.regions["banks"]):
        corners = placed(wall)
        outside = [corners[:, k].max() < low[k] or corners[:, k].min() > high[k] for k in (0, 1)]
        assert any(outside)


def test_the_links_are_linked():
    """The tube of each passes the middle of the other, four tube radii from its own centre."""
    one, other = load_scene(path_of("linked")).bodies
    assert np.linalg.norm(other.position - one.position) == 0.125
    across = placed(other)[:, 2]
    assert np.ptp(across) == pytest.approx(2 * (0.125 + 0.03125), abs=1e-7)
    inside = np.linalg.norm(placed(other)[:, :2], axis=1) < 0.125 - 0.03125
    assert inside.any()
