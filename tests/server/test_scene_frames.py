"""Frames in scene files: made once, around their bodies, refused by name where they are not."""

import numpy as np
import pytest
from mesh_forms import cube, torus, write_stl

from comotion_server.meshes import mesh_store
from comotion_server.meshes.mass import mass_properties
from comotion_server.plan import Plan
from comotion_server.scene import SceneError, check_scene, frames, load_scene

HEAD = '[scene]\nname = "s"\nduration = 1.0\ndt = 0.1\n'
BOX = "shape = { box = { size = [1, 2, 3] } }\n"
CUBE = 'shape = { stl = "cube.stl" }\n'
FLOES = """[[array]]
name = "floe"
region = "ice"
shape = { prism = { base = 0.3, height = 0.2, thickness = 0.018 } }
mass = 0.5
frame = { offset = 0.002 }
place.grid = { origin = [0, 0, 0], counts = [COUNT, 1, 1], spacing = [1, 0, 0] }
"""


def body(keys, shape=BOX, name="a"):
    return f'[[body]]\nname = "{name}"\n{shape}mass = 2.0\n{keys}\n'


@pytest.fixture
def scene(tmp_path):
    def scene(text, load=load_scene):
        (tmp_path / "scene.toml").write_text(HEAD + text)
        return load(tmp_path / "scene.toml")

    scene.folder = tmp_path
    return scene


@pytest.fixture
def refused(scene):
    def refused(text):
        with pytest.raises(SceneError) as refusal:
            scene(text)
        (problem,) = refusal.value.problems
        return f"{problem.line}: {problem.where}: {problem.message}"

    return refused


def test_a_scaled_frame_grows_about_the_centre_of_mass(scene):
    write_stl(scene.folder / "cube.stl", *cube(offset=(5.0, 0.0, 0.0)))
    framed = scene(body("frame = { scale = 1.02 }", CUBE)).bodies[0]
    np.testing.assert_array_equal(framed.frame.vertices, 1.02 * framed.mesh.vertices)
    assert framed.collision_shape is framed.frame
    assert framed.collision_mesh is framed.frame
    plain = scene(body("", CUBE)).bodies[0]
    np.testing.assert_array_equal(framed.mesh.vertices, plain.mesh.vertices)
    np.testing.assert_array_equal(framed.inertia, plain.inertia)
    assert plain.collision_shape is plain.shape


def test_a_frame_of_its_own_lies_in_the_coordinates_of_the_shape(scene):
    write_stl(scene.folder / "cube.stl", *cube(offset=(5.0, 0.0, 0.0)))
    write_stl(scene.folder / "frame.stl", *cube(edge=1.5, offset=(4.75, -0.125, -0.25)))
    (report,) = scene(body('frame = { stl = "frame.stl" }', CUBE), load=check_scene).bodies
    assert (report.frame, report.frame_triangles, report.clearance) == ("frame.stl", 12, 0.125)
    framed = scene(body('frame = { stl = "frame.stl" }', CUBE)).bodies[0]
    assert framed.frame.vertices.min(axis=0).tolist() == [-0.75, -0.625, -0.75]
    assert framed.position.tolist() == [5.5, 0.5, 0.5]


def test_the_least_clearance_of_an_offset_is_the_offset(scene):
    (report,) = scene(body("frame = { offset = 0.002 }"), load=check_scene).bodies
    assert report.frame == "offset 0.002 m"
    assert report.clearance == pytest.approx(0.002, rel=1e-12)  # rounding of coordinates of 1 m


@pytest.mark.parametrize(
    ("keys", "problem"),
    [
        ("frame = { scale = 1.0 }", '9: body "a".frame.scale: must be greater than 1; got 1.0'),
        ("frame = { scale = 0.5 }", '9: body "a".frame.scale: must be greater than 1; got 0.5'),
        ("frame = { offset = 0.0 }", '9: body "a".frame.offset: must be at least 1e-12 m; got 0.0'),
        ("frame = { offset = -0.1 }", '9: body "a".frame.offset: must be at least 1e-12 m; got -0.1'),
        ("frame = {}", '9: body "a".frame: must have exactly one of stl, scale, offset; got none'),
        (
            "frame = { scale = 1.1, offset = 0.1 }",
            '9: body "a".frame: must have exactly one of stl, scale, offset; got scale and offset',
        ),
        (
            'frame = { stl = "none.stl" }',
            '9: body "a".frame.stl: none.stl: cannot be read: No such file or directory',
        ),
    ],
)
def test_keys_that_say_no_frame_are_refused(refused, keys, problem):
    assert refused(body(keys)) == problem


def test_a_plane_has_no_frame(refused):
    floor = (
        '[[body]]\nname = "f"\nmotion = "fixed"\nshape = { plane = { normal = [0, 0, 1] } }\nframe = { scale = 2.0 }\n'
    )
    assert refused(body("") + floor) == '14: body "f".frame: a plane has no frame'


@pytest.mark.parametrize(
    ("edge", "offset", "message"),
    [
        (0.5, 0.25, "the corner of the body at (-0.5, -0.5, -0.5) lies outside of its frame"),
        (2.0, 5.0, "the corner of the body at (-0.5, -0.5, -0.5) lies outside of its frame"),
        (1.0, 0.0, "the surface of the body meets its frame's at"),
        (2.0, 0.5, "the surface of the body meets its frame's at"),
    ],
    ids=["frame inside the body", "frame beside it", "the same surface", "surfaces that cross"],
)
def test_a_frame_that_is_not_around_its_body_is_refused(scene, refused, edge, offset, message):
    write_stl(scene.folder / "cube.stl", *cube())
    write_stl(scene.folder / "frame.stl", *cube(edge=edge, offset=3 * (offset,)))
    problem = refused(body('frame = { stl = "frame.stl" }', CUBE))
    assert problem.startswith(f'9: body "a".frame.stl: frame.stl: {message}')
    assert problem.endswith("the body must lie strictly inside")


def test_a_hollow_in_the_body_is_no_place_for_the_frame(scene, refused):
    """A frame whose cavity lies within the body: what is solid of the body is not solid of the frame."""
    write_stl(scene.folder / "cube.stl", *cube())
    points, facets = cube(edge=2.0, offset=3 * (-0.5,))
    hollow, inner = cube(edge=0.25, offset=3 * (0.4,))
    write_stl(
        scene.folder / "frame.stl", np.concatenate([points, hollow]), np.concatenate([facets, inner[:, ::-1] + 8])
    )
    problem = refused(body('frame = { stl = "frame.stl" }', CUBE))
    assert "frame.stl: the corner of the frame at (0.15, 0.15, -0.1) lies inside of the body" in problem


def test_an_open_frame_is_refused(scene, refused):
    points, facets = cube(edge=2.0, offset=3 * (-0.5,))
    write_stl(scene.folder / "frame.stl", points, facets[1:])
    problem = refused(body('frame = { stl = "frame.stl" }'))
    assert problem.startswith('9: body "a".frame.stl: frame.stl: 3 open edges')
    assert problem.endswith("a frame needs a closed surface")


def test_an_open_body_may_have_a_frame_of_its_own_only(scene, refused):
    points, facets = cube()
    write_stl(scene.folder / "cube.stl", points, facets[1:])
    write_stl(scene.folder / "frame.stl", *cube(edge=2.0, offset=3 * (-0.5,)))
    fixed = body("FRAME", CUBE).replace("mass = 2.0", 'motion = "fixed"')
    (framed,) = scene(fixed.replace("FRAME", 'frame = { stl = "frame.stl" }')).bodies
    assert len(framed.frame.triangles) == 12
    for frame in ("scale = 1.1", "offset = 0.1"):
        assert refused(fixed.replace("FRAME", f"frame = {{ {frame} }}")).endswith("a frame needs a closed surface")


def test_an_offset_that_crosses_itself_is_refused_by_name(scene, refused):
    points, facets = cube()
    write_stl(
        scene.folder / "cube.stl",
        np.concatenate([points, np.add(points, [1.1, 0, 0])]),
        np.concatenate([facets, facets + 8]),
    )
    problem = refused(body("frame = { offset = 0.06 }", CUBE))
    assert problem.startswith('9: body "a".frame.offset: moved out by 0.06 m, the facets at')


def test_members_of_an_array_share_one_frame_that_is_checked_once(scene, monkeypatch):
    """So the checks of an array cost the same whatever its number."""
    checked = []

    def count(_, frame):
        checked.append(frame)
        return 0.002

    monkeypatch.setattr(frames, "clearance", count)
    other = body(
        "frame = { offset = 0.002 }", "shape = { prism = { base = 0.3, height = 0.2, thickness = 0.018 } }\n", "b"
    )
    loaded = scene(FLOES.replace("COUNT", "500") + other)
    assert len(loaded.bodies) == 501
    assert {id(one.frame) for one in loaded.bodies} == {id(checked[0])}
    assert len(checked) == 1
    store = mesh_store.MeshStore.build([one.collision_mesh for one in loaded.bodies])
    assert len(store.size) == 1


def test_a_random_field_keeps_the_frames_apart(scene):
    text = FLOES[: FLOES.index("place.")] + (
        "place.random = { low = [0, 0, 0], high = [6, 6, 0], count = 60, seed = 1, gap = 0.001 }\n"
    )
    loaded = scene(text)
    radius = np.linalg.norm(loaded.bodies[0].frame.vertices[:, :2], axis=1).max()
    centres = np.array([one.position for one in loaded.bodies])
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=2) + 10.0 * np.eye(60)
    assert apart.min() >= 2.0 * radius + 0.001 - 1e-12


def test_mass_is_that_of_the_body(scene):
    text = FLOES.replace("COUNT", "1").replace("mass = 0.5", "density = 900")
    (floe,) = scene(text).bodies
    properties = mass_properties(floe.mesh.vertices, floe.mesh.triangles)
    assert floe.mass == pytest.approx(900 * properties.volume, rel=1e-14)
    np.testing.assert_allclose(floe.inertia, 900 * properties.inertia, rtol=1e-12, atol=1e-18)


def test_the_plan_says_who_has_frames(scene):
    def line(text):
        (found,) = (line for line in Plan(scene(text)).explain() if line.stage == "frames")
        return found.kept, found.reason

    assert line(body("")) == (False, "every body collides with its own surface")
    assert line(body("frame = { scale = 1.1 }")) == (False, "nothing collides")
    floes = FLOES.replace("COUNT", "3")
    assert line(floes) == (True, '3 bodies collide with frames: "ice"')
    more = body('region = "ice"\nposition = [9, 9, 9]')
    assert line(floes + more) == (True, '3 bodies collide with frames: 3 of 4 in "ice"')


def test_a_ring_does_not_lie_inside_its_larger_self(scene, refused):
    """Its hole grows with it: the centre of mass does not see all of the surface."""
    ring = torus(12)
    write_stl(scene.folder / "cube.stl", *ring)
    problem = refused(body("frame = { scale = 1.02 }", CUBE))
    assert problem.startswith('9: body "a".frame.scale: the surface of the body meets its frame')
    assert len(scene(body("frame = { offset = 0.02 }", CUBE)).bodies) == 1


def test_smooth_shapes_have_no_frame(refused):
    problem = refused(body("frame = { scale = 1.1 }", "shape = { sphere = { radius = 1.0 } }\n"))
    assert problem == '9: body "a".frame: a sphere has no frame'
