"""From a sound scene file to bodies: defaults, masses, places, order, sharing."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from mesh_forms import cube, write_stl

from comotion_server.scene import Fixed, Free, Plane, Prescribed, check_scene, load_scene

HEAD = '[scene]\nname = "s"\nduration = 1.0\ndt = 0.1\n'
BOX = "shape = { box = { size = [1, 2, 3] } }\n"
FLOE = "shape = { prism = { base = 0.3, height = 0.2, thickness = 0.018 } }\n"
ROUNDING = 1e-12


@pytest.fixture
def scene(tmp_path):
    def scene(text, head=HEAD):
        (tmp_path / "a scene.toml").write_text(head + text)
        return load_scene(tmp_path / "a scene.toml")

    return scene


def body(keys, name="a", shape=BOX):
    return f'[[body]]\nname = "{name}"\n{shape}{keys}\n'


def test_defaults(scene):
    loaded = scene(body("mass = 2"), head="[scene]\nduration = 6\ndt = 0.1\n")
    assert (loaded.name, loaded.duration, loaded.dt) == ("a-scene", 6.0, 0.1)
    np.testing.assert_array_equal(loaded.gravity, [0, 0, -9.81])
    settings = loaded.collisions
    assert (settings.rule, settings.restitution, settings.friction) == ("exact", 0.3, 0.0)
    assert (settings.simultaneous, settings.parallel, settings.patch_angle) == ("together", "patch", 1e-6)
    assert (settings.tolerance, settings.budget) == (1e-9, 10_000)
    (only,) = loaded.bodies
    assert isinstance(only.motion, Free)
    assert (only.motion.locked, only.motion.reacts, only.region, only.material) == (6 * (False,), True, "a", None)
    np.testing.assert_array_equal(only.motion.thrust, np.zeros(3))
    np.testing.assert_array_equal(only.quaternion, [1, 0, 0, 0])
    np.testing.assert_array_equal([only.position, only.velocity, only.angular_velocity], np.zeros((3, 3)))


@pytest.mark.parametrize("rule", ["paper", "paper-advance"])
def test_defaults_of_the_papers_rules(scene, rule):
    settings = scene(f"[collisions]\nrule = '{rule}'\n" + body("mass = 2")).collisions
    assert (settings.rule, settings.substeps, settings.parallel, settings.tolerance) == (rule, 2, "paper", 1e-6)
    assert (settings.parallel_face, settings.parallel_edge) == (0.999, 0.01)


def test_a_given_value_goes_before_the_rules_own(scene):
    keys = "[collisions]\nparallel = 'off'\ntolerance = 1e-12\n"
    settings = scene(keys + body("mass = 2")).collisions
    assert (settings.parallel, settings.tolerance) == ("off", 1e-12)


def test_all_keys_of_a_free_body(scene):
    keys = """mass = 2
position = [1, 2, 3]
quaternion = [0.707, 0, 0, 0.707]
velocity = [1, 0, 0]
angular_velocity = [0, 0, 2]
material = "ice"
locked = ["z", "rx", "ry"]
reacts = false
thrust = [0, 5, 0]
region = "r"
"""
    (only,) = scene(body(keys)).bodies
    assert only.motion.locked == (False, False, True, True, True, False)
    assert not only.motion.reacts
    np.testing.assert_array_equal(only.motion.thrust, [0, 5, 0])
    np.testing.assert_allclose(only.quaternion, np.array([1, 0, 0, 1]) / math.sqrt(2), rtol=1e-15)  # made unit
    np.testing.assert_array_equal(only.position, [1, 2, 3])
    assert (only.region, only.material) == ("r", "ice")


def test_mass_density_and_inertia(scene):
    by_mass, by_density, given, fixed = scene(
        body("mass = 12", "a")
        + body("density = 2", "b")
        + body("mass = 1\ninertia = [[1, 0, 0], [0, 2, 0], [0, 0, 3]]", "c")
        + body('motion = "fixed"', "d")
    ).bodies
    inertia = np.diag([13.0, 10.0, 5.0])  # m/12 (y2 + z2) ...
    assert (by_mass.mass, by_density.mass) == (12.0, 12.0)
    np.testing.assert_allclose(by_mass.inertia, inertia, rtol=ROUNDING)
    np.testing.assert_allclose(by_density.inertia, inertia, rtol=ROUNDING)
    np.testing.assert_array_equal(given.inertia, np.diag([1, 2, 3]))  # the limit of a flat body is allowed
    assert isinstance(fixed.motion, Fixed)
    assert np.isnan(fixed.mass)
    assert np.isnan(fixed.inertia).all()


def test_a_mesh_stays_where_its_file_puts_it_unless_placed(scene, tmp_path):
    (tmp_path / "meshes").mkdir()
    write_stl(tmp_path / "meshes" / "cube.stl", *cube(edge=2.0, offset=(10, 20, 30)))
    shape = 'shape = { stl = "meshes/cube.stl" }\n'
    there, here = scene(body("mass = 6", "a", shape) + body("mass = 6\nposition = [0, 0, 1]", "b", shape)).bodies
    np.testing.assert_array_equal(there.position, [11, 21, 31])
    np.testing.assert_array_equal(here.position, [0, 0, 1])
    np.testing.assert_array_equal(
        np.sort(there.mesh.vertices, axis=0), np.repeat([[-1.0], [1.0]], 4, axis=0) * np.ones(3)
    )
    np.testing.assert_allclose(there.inertia, 6 * 4 / 6 * np.eye(3), rtol=0, atol=ROUNDING)
    assert here.mesh is there.mesh


def test_bodies_alike_share_their_mesh_whatever_their_motion(scene):
    bodies = scene(body("mass = 1", "a") + body('motion = "fixed"', "b") + body("mass = 1", "c", FLOE)).bodies
    assert bodies[0].mesh is bodies[1].mesh
    assert bodies[0].mesh is not bodies[2].mesh


def test_order_of_names_not_of_the_file(scene):
    text = (
        body("mass = 1\nregion = 'z'", "c") + body("mass = 1\nregion = 'y'", "a") + body("mass = 1\nregion = 'z'", "b")
    )
    loaded = scene(text)
    assert [only.name for only in loaded.bodies] == ["a", "b", "c"]
    assert {name: [only.name for only in members] for name, members in loaded.regions.items()} == {
        "y": ["a"],
        "z": ["b", "c"],
    }
    assert list(loaded.regions) == ["y", "z"]


def test_restitution_and_friction_by_pairs_of_materials(scene):
    loaded = scene(
        "[collisions]\nrestitution = 0.5\nfriction = 0.4\n"
        "[[material]]\nbetween = ['ice', 'steel']\nrestitution = 0.1\nfriction = 0.03\n"
        "[[material]]\nbetween = ['ice', 'ice']\nrestitution = 0.2\n"
        + "".join(body(f"mass = 1\nmaterial = '{m}'", n) for n, m in (("a", "ice"), ("b", "steel"), ("c", "ice")))
        + body("mass = 1", "d")
    )
    a, b, c, d = loaded.bodies
    between = loaded.collisions.restitution_between
    assert (between(a, b), between(b, a), between(a, c), between(a, d)) == (0.1, 0.1, 0.2, 0.5)
    between = loaded.collisions.friction_between
    assert (between(a, b), between(b, a), between(a, c), between(a, d)) == (0.03, 0.03, 0.4, 0.4)


PLANE = "shape = {{ plane = {{ normal = {} }} }}\n"


def test_planes(scene):
    floor = body("motion = 'fixed'", "floor", "shape = { plane = { normal = [0, 0, 1], point = [0, 0, 2] } }\n")
    wall = body("motion = { velocity = [1, 0, 0] }\nposition = [-1, 0, 0]", "wall", PLANE.format([3, 0, 4]))
    ball, floor, wall = scene(body("mass = 1") + floor + wall).bodies
    np.testing.assert_array_equal(floor.position, [0, 0, 2])
    np.testing.assert_array_equal(wall.position, [-1, 0, 0])
    assert isinstance(floor.shape, Plane)
    np.testing.assert_allclose(wall.shape.normal, [0.6, 0, 0.8], rtol=ROUNDING)
    assert np.isnan([floor.mass, wall.mass]).all()
    with pytest.raises(TypeError, match='body "floor" is a plane: it has no mesh'):
        _ = floor.mesh
    assert ball.mesh is ball.shape


def test_planes_are_in_no_region_and_in_the_report(scene, tmp_path):
    floor = body("motion = 'fixed'", "floor", PLANE.format([0, 0, 1]))
    assert list(scene(body("mass = 1") + floor).regions) == ["a"]
    data = json.loads(json.dumps(check_scene(tmp_path / "a scene.toml").as_dict(), allow_nan=False))
    assert [region["name"] for region in data["regions"]] == ["a"]
    plane = data["bodies"][1]
    assert (plane["shape"], plane["size"], plane["vertices"], plane["health"]) == ("plane", None, 0, None)


def test_prescribed_velocities_are_the_bodys(scene):
    (only,) = scene(body("motion = { velocity = [1, 2, 3] }\nmass = 4")).bodies
    assert isinstance(only.motion, Prescribed)
    assert only.motion.table is None
    np.testing.assert_array_equal(only.velocity, [1, 2, 3])
    np.testing.assert_array_equal(only.angular_velocity, np.zeros(3))
    assert only.mass == 4.0


def test_the_fluid_is_not_looked_at(scene):
    assert scene(body("mass = 1") + "[fluid]\ndensity = 'any'\nwhen = 1979-05-27\n[fluid.drag]\nx = [1, {}]\n").bodies


def array(keys, name="floe"):
    return f'[[array]]\nname = "{name}"\nmass = 0.5\nregion = "ice"\n{FLOE}{keys}\n'


def test_a_grid_is_named_in_the_order_of_its_places(scene):
    loaded = scene(array("place.grid = { origin = [1, 2, 3], counts = [4, 3, 2], spacing = [1, 10, 100] }"))
    assert [member.name for member in loaded.bodies] == [f"floe-{k:03d}" for k in range(1, 25)]
    places = [(1 + i, 2 + 10 * j, 3 + 100 * k) for k in range(2) for j in range(3) for i in range(4)]
    np.testing.assert_array_equal([member.position for member in loaded.bodies], places)
    assert list(loaded.regions) == ["ice"]
    assert len({id(member.mesh) for member in loaded.bodies}) == 1


def test_a_thousand_members_sort_by_number(scene):
    loaded = scene(array("place.grid = { origin = [0, 0, 0], counts = [1200, 1, 1], spacing = [1, 0, 0] }"))
    assert loaded.bodies[0].name == "floe-0001"
    np.testing.assert_array_equal([member.position[0] for member in loaded.bodies], np.arange(1200))


def test_members_from_a_file_of_poses(scene, tmp_path):
    (tmp_path / "p.csv").write_text("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,0\n4,5,6,0,0,0,1\n")
    first, second = scene(array('place.poses = "p.csv"\nquaternion = [0, 1, 0, 0]')).bodies
    np.testing.assert_array_equal(first.position, [1, 2, 3])
    np.testing.assert_array_equal(first.quaternion, [0, 1, 0, 0])
    np.testing.assert_array_equal(second.quaternion, [0, 0, 1, 0])  # turned about x, then about z: k i = j
    (tmp_path / "p.csv").write_text("x, y, z\n1,2,3\n")
    (only,) = scene(array('place.poses = "p.csv"')).bodies
    np.testing.assert_array_equal(only.quaternion, [1, 0, 0, 0])


FIELD = "low = [0, 0, {low}], high = [4, 3, {high}], count = {count}, seed = {seed}, gap = 0.05, turn = 'z'"
RANDOM = "place.random = {{ " + FIELD + " }}"


@pytest.mark.parametrize(("low", "high"), [(0.5, 0.5), (0, 2)])
def test_random_fields_keep_their_distance_and_their_box(scene, low, high):
    text = array(RANDOM.format(low=low, high=high, count=40, seed=7))
    members = scene(text).bodies
    positions = np.array([member.position for member in members])
    planar = low == high
    apex = math.hypot(0.15, 0.2 / 3)
    radius = apex if planar else math.hypot(apex, 0.009)
    distance = np.linalg.norm(positions[:, None] - positions[None], axis=2) + 1e9 * np.eye(40)
    assert distance.min() >= 2 * radius + 0.05 - ROUNDING
    assert (positions[:, :2] >= radius - ROUNDING).all()
    assert (positions[:, :2] <= np.array([4, 3]) - radius + ROUNDING).all()
    if planar:
        assert (positions[:, 2] == 0.5).all()
    turns = np.array([member.quaternion for member in members])
    assert (turns[:, 1:3] == 0).all()
    assert len(np.unique(turns[:, 3])) == 40
    again = scene(text).bodies
    np.testing.assert_array_equal([member.position for member in again], positions)
    other = scene(array(RANDOM.format(low=low, high=high, count=40, seed=8))).bodies
    assert (other[0].position != positions[0]).any()


def test_members_that_stand_up_take_less_room(scene):
    """A floe turned on its edge about x is 0.018 deep in y: its circle is smaller than that of one lying flat."""
    keys = "place.random = { low = [0, 0, 0], high = [0.31, 0.31, 0], count = 1, seed = 1 }\n"
    assert len(scene(array(keys + "quaternion = [0.7071, 0.7071, 0, 0]")).bodies) == 1
    with pytest.raises(ValueError, match="no member fits"):
        scene(array(keys))


def test_the_report_is_plain_data(scene, tmp_path):
    scene(
        body("mass = 12", "hull")
        + array("place.grid = { origin = [9, 0, 0], counts = [3, 1, 1], spacing = [1, 0, 0] }")
    )
    report = check_scene(tmp_path / "a scene.toml")
    data = json.loads(json.dumps(report.as_dict(), allow_nan=False))
    assert data["regions"] == [
        {"name": "hull", "bodies": 1, "vertices": 8, "triangles": 12},
        {"name": "ice", "bodies": 3, "vertices": 18, "triangles": 24},
    ]
    assert [entry["name"] for entry in data["bodies"]] == ["floe-001", "floe-002", "floe-003", "hull"]
    hull = data["bodies"][3]
    assert (hull["motion"], hull["shape"], hull["mass"], hull["volume"]) == ("free", "box 1 x 2 x 3 m", 12.0, 6.0)
    assert hull["principal_moments"] == pytest.approx([5, 10, 13], rel=ROUNDING)
    assert hull["health"]["closed"]
    assert hull["notes"] == []


def test_reading_a_scene_of_boxes_loads_neither_trimesh_nor_numba(scene, tmp_path):
    scene(body("mass = 1"))
    code = (
        "import sys; from comotion_server.scene import Body, Scene; assert 'pydantic' not in sys.modules\n"
        "from comotion_server.scene import load_scene; load_scene(sys.argv[1])\n"
        "assert not {'trimesh', 'numba', 'scipy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "a scene.toml")], check=True)
