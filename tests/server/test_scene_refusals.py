"""Mistakes in scenes: every one, at once, on its line, by its name, with what is allowed."""

import pytest
from mesh_forms import cube, write_stl

from comotion_server.scene import SceneError, check_scene, load_scene

HEAD = '[scene]\nname = "s"\nduration = 1.0\ndt = 0.1\n'
BODY = '[[body]]\nname = "a"\nshape = { box = { size = [1, 1, 1] } }\n'
PRISM = "shape = { prism = { base = 0.3, height = 0.2, thickness = 0.02 } }\n"


@pytest.fixture
def refused(tmp_path, monkeypatch):
    """Lines of the refusal of a scene's text."""
    monkeypatch.chdir(tmp_path)

    def refused(text):
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        with pytest.raises(SceneError) as refusal:
            load_scene("scene.toml")
        assert [str(problem) for problem in refusal.value.problems] == str(refusal.value).split("\n")
        return str(refusal.value).split("\n")

    return refused


def test_an_unknown_key_with_a_guess(refused):
    assert refused(HEAD + BODY + "\nmas = 3.0\n") == [
        "scene.toml:9: body \"a\".mas: unknown key 'mas'; did you mean 'mass'?"
    ]


def test_all_mistakes_at_once_in_the_order_of_their_lines(refused):
    text = """[scene]
duration = 1.0
dt = -0.005
[collisions]
rule = "papr"
[[body]]
name = "hull"
mas = 3.0
shape = { box = { size = [1, 2] } }
motion = { velocity = [0.5, "a", 0.0] }
locked = ["z"]
[[body]]
name = "b"
shape = { stl = "b.stl", box = { size = [1, 1, 1] } }
mass = nan
density = 1e3
[[body]]
name = "b"
shape = { stl = "nowhere.stl" }
motion = { table = "nowhere.csv" }
[[material]]
between = ["ice", "steel"]
restitution = 1.5
[fluidd]
"""
    assert refused(text) == [
        "scene.toml:3: scene.dt: must be greater than 0 s; got -0.005",
        (
            "scene.toml:5: collisions.rule: must be 'exact', 'paper', 'paper-advance' or 'paper-analytic'; "
            "got \"papr\"; did you mean 'paper'?"
        ),
        "scene.toml:8: body \"hull\".mas: unknown key 'mas'; did you mean 'mass'?",
        'scene.toml:9: body "hull".shape.box.size: must have 3 entries; got [1, 2]',
        'scene.toml:10: body "hull".motion.velocity[1]: must be a number [m/s]; got "a"',
        'scene.toml:11: body "hull".locked: only a free body takes it; this one\'s motion is prescribed',
        (
            'scene.toml:14: body "b".shape: must have exactly one of stl, box, prism, plane, sphere, capsule, '
            "cylinder, pipe; got stl and box"
        ),
        'scene.toml:15: body "b".mass: must be a finite number; got nan',
        "scene.toml:16: body \"b\".density: give either 'mass' or 'density', not both",
        "scene.toml:18: body \"b\".name: 'b' is already the name of the body on line 12",
        'scene.toml:19: body "b".shape.stl: nowhere.stl: cannot be read: No such file or directory',
        'scene.toml:20: body "b".motion.table: nowhere.csv: cannot be read: No such file or directory',
        "scene.toml:22: material 1.between[0]: no body is of material 'ice'; there are: none",
        "scene.toml:22: material 1.between[1]: no body is of material 'steel'; there are: none",
        "scene.toml:23: material 1.restitution: must be at most 1; got 1.5",
        "scene.toml:24: fluidd: unknown key 'fluidd'; did you mean 'fluid'?",
    ]


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("", "scene.toml:5: body \"a\": a free body needs 'mass' [kg] or 'density' [kg/m3]"),
        ("mass = -1", ".mass: must be greater than 0 kg; got -1"),
        ("mass = 0", ".mass: must be greater than 0 kg; got 0"),
        ("mass = inf", ".mass: must be a finite number; got inf"),
        ("mass = 1e31", ".mass: must be at most 1e+30 kg; got 1e+31"),
        ("mass = 1\nvelocity = [1, 2, -1e31]", ".velocity[2]: must be at least -1e+30 m/s; got -1e+31"),
        ('mass = "3"', '.mass: must be a number [kg]; got "3"'),
        ("mass = true", ".mass: must be a number [kg]; got true"),
        ("mass = [1]", ".mass: must be a number [kg]; got [1]"),
        ("density = -1", ".density: must be greater than 0 kg/m3; got -1"),
        ("mass = 1\nvelocity = 3", ".velocity: must be a list of numbers [m/s]; got 3"),
        ("mass = 1\nvelocity = [1, 2, nan]", ".velocity[2]: must be a finite number; got nan"),
        ("mass = 1\nposition = [1, 2, 3, 4]", ".position: must have 3 entries; got [1, 2, 3, 4]"),
        (
            "mass = 1\nquaternion = [1, 1, 0, 0]",
            ".quaternion: must have length 1 (within 0.001); its length is 1.41421",
        ),
        ("mass = 1\nquaternion = [0, 0, 0, 0]", ".quaternion: must have length 1"),
        ("mass = 1\ninertia = [[1, 2, 0], [0, 1, 0], [0, 0, 1]]", ".inertia: must be symmetric"),
        ("mass = 1\ninertia = [[1, 0, 0], [0, -1, 0], [0, 0, 1]]", ".inertia: must be positive definite"),
        ("mass = 1\ninertia = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]", ".inertia: must be positive definite"),
        ("mass = 1\ninertia = [[1, 0, 0], [0, 1, 0], [0, 0, 9]]", ".inertia: no body has it"),
        ("mass = 1\ninertia = [[1, 0, 0], [0, 1, 0]]", ".inertia: must have 3 entries"),
        ("mass = 1\ninertia = [[1, 0], [0, 1, 0], [0, 0, 1]]", ".inertia[0]: must have 3 entries"),
        ('mass = 1\nlocked = ["rx"]', ".locked: locks rotation about one axis; allowed: none, two"),
        ('mass = 1\nlocked = ["x", "x"]', ".locked: names an axis twice"),
        ('mass = 1\nlocked = ["w"]', ".locked[0]: must be 'x', 'y', 'z', 'rx', 'ry' or 'rz'; got \"w\""),
        (
            'mass = 1\nlocked = ["z"]\nvelocity = [1, 0, 2]',
            ".velocity: must be 0 where motion is locked (z); got [1, 0, 2]",
        ),
        (
            'mass = 1\nlocked = ["rx", "ry"]\nangular_velocity = [0, 2, 1]',
            ".angular_velocity: must be 0 where motion is locked (ry)",
        ),
        ('mass = 1\nreacts = "no"', '.reacts: must be true or false; got "no"'),
        ('mass = 1\nmotion = "fred"', ".motion: must be 'free' or 'fixed'; got \"fred\"; did you mean 'free'?"),
        ("mass = 1\nmotion = 3", ".motion: must be 'free' or 'fixed'"),
        ('motion = "fixed"\nthrust = [1, 0, 0]', ".thrust: only a free body takes it; this one is fixed"),
        ('motion = "fixed"\nreacts = false', ".reacts: only a free body takes it"),
        ('motion = "fixed"\nlocked = []', ".locked: only a free body takes it"),
        ('motion = "fixed"\nvelocity = [1, 0, 0]', ".velocity: only a free body takes it; this one is fixed"),
        ('motion = "fixed"\nmass = 1\ndensity = 1', ".density: give either 'mass' or 'density'"),
        (
            'motion = "fixed"\ninertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]',
            ".inertia: without 'mass' or 'density' it means nothing",
        ),
        (
            "motion = { velocity = [1, 0, 0] }\nvelocity = [1, 0, 0]",
            ".velocity: a prescribed body moves as its 'motion' says",
        ),
        ("motion = {}", ".motion: needs 'velocity', 'angular_velocity' or 'table'"),
        ("motion = { speed = 1 }", ".motion.speed: unknown key 'speed'; allowed: velocity, angular_velocity, table"),
        ('motion = { table = "t.csv", velocity = [1, 0, 0] }', ".motion.velocity: not together with 'table'"),
        ('motion = { table = "t.csv" }\nposition = [0, 0, 0]', ".position: the table of poses says where the body is"),
        ('mass = 1\nregion = "a/b"', ".region: must be made of letters, digits and _ . + -"),
        ('mass = 1\nmaterial = ""', ".material: must be made of letters"),
        ("mass = 1\nframe = { scales = 1.02 }", ".frame.scales: unknown key 'scales'; did you mean 'scale'?"),
        ("mass = 1\nsoft = true", ".soft: unknown key 'soft'"),
    ],
)
def test_bodies(refused, keys, expected):
    lines = refused(HEAD + BODY + keys + "\n")
    assert len(lines) == 1, lines
    assert expected in lines[0]
    assert ': body "a"' in lines[0]


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("{}", ".shape: must have exactly one of stl, box, prism, plane, sphere, capsule, cylinder, pipe; got none"),
        ("{ torus = { radius = 1 } }", ".shape.torus: unknown key 'torus'; allowed: stl, box, prism, plane, sphere,"),
        ("{ box = { size = [1, 0, 1] } }", ".shape.box.size[1]: must be at least 1e-12 m; got 0"),
        ("{ box = { size = 1 } }", ".shape.box.size: must be a list of numbers [m]; got 1"),
        ("{ box = 1 }", ".shape.box: must be a table; got 1"),
        ("{ prism = { base = 1, height = -1 } }", ".shape.prism.height: must be at least 1e-12 m; got -1"),
        ("{ prism = { base = 1, height = 1 } }", ".shape.prism.thickness: needed, but missing: Thickness along z [m]"),
        ("{ stl = 3 }", ".shape.stl: must be text in quotes; got 3"),
        ('"box"', '.shape: must be a table; got "box"'),
    ],
)
def test_shapes(refused, shape, expected):
    lines = refused(HEAD + f'[[body]]\nname = "a"\nmass = 1\nshape = {shape}\n')
    assert expected in "\n".join(lines)
    assert all(line.startswith("scene.toml:8: ") for line in lines)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[scene]\nduration = 1\n" + BODY + "mass = 1", "scene.toml:1: scene.dt: needed, but missing: Time step"),
        (BODY + "mass = 1", "scene.toml: scene: needed, but missing"),
        ("scene = 3\n" + BODY + "mass = 1", "scene.toml:1: scene: must be a table; got 3"),
        (HEAD, "scene.toml: a scene needs at least one [[body]] or [[array]]"),
        (HEAD + '[body]\nname = "a"\n', "scene.toml:5: body: must be written as [[body]], once for each"),
        (HEAD + "body = 3\n", "scene.toml:5: scene.body: unknown key 'body'"),
        ("body = [3]\n" + HEAD, "scene.toml:1: body 1: must be a table; got 3"),
        (HEAD + "[[body]]\nmass = 1\n" + PRISM, "scene.toml:5: body 1.name: needed, but missing"),
        (HEAD.replace("0.1", "0") + BODY + "mass = 1", "scene.toml:4: scene.dt: must be greater than 0 s; got 0"),
        (HEAD.replace("0.1", "nan") + BODY + "mass = 1", "scene.toml:4: scene.dt: must be a finite number; got nan"),
        (HEAD.replace("1.0", '"1"') + BODY + "mass = 1", "scene.toml:3: scene.duration: must be a number [s]"),
        (HEAD + "gravity = [0, 0]\n" + BODY + "mass = 1", "scene.toml:5: scene.gravity: must have 3 entries"),
        (
            HEAD + "[collisions]\nrule = 'exakt'\n" + BODY + "mass = 1",
            "must be 'exact', 'paper', 'paper-advance' or 'paper-analytic'; got \"exakt\"; did you mean 'exact'?",
        ),
        (HEAD + "[collisions]\nsubsteps = 0\n" + BODY + "mass = 1", "collisions.substeps: must be at least 1; got 0"),
        (
            HEAD + "[collisions]\nsubsteps = 1.5\n" + BODY + "mass = 1",
            "collisions.substeps: must be a whole number; got 1.5",
        ),
        (HEAD + "[collisions]\nwarm = true\n" + BODY + "mass = 1", "collisions.warm: unknown key 'warm'"),
        (HEAD + "fluid = 3\n" + BODY + "mass = 1", "scene.fluid: unknown key 'fluid'"),
        ("fluid = 3\n" + HEAD + BODY + "mass = 1", "scene.toml:1: fluid: must be a table; got 3"),
        (
            HEAD + "[[material]]\nbetween = ['a']\nrestitution = 1\n" + BODY + "mass = 1\nmaterial = 'a'",
            "must have 2 entries",
        ),
        (
            HEAD + 2 * "[[material]]\nbetween = ['i', 'i']\nrestitution = 1\n" + BODY + "mass = 1\nmaterial = 'i'",
            'scene.toml:9: material 2.between: there is an earlier [[material]] between ["i", "i"]',
        ),
        (
            HEAD + "[[material]]\nbetween = ['ica', 'ice']\nrestitution = 1\n" + BODY + "mass = 1\nmaterial = 'ice'",
            "no body is of material 'ica'; did you mean 'ice'?",
        ),
        ("[scene\n", "scene.toml:1: not TOML: expected ']' at the end of a table declaration"),
        ("[scene]\na = \n", "scene.toml:2: not TOML: invalid value"),
        ("[scene]\na = 1\na = 2\n", "scene.toml:3: not TOML: cannot overwrite a value"),
        ("[scene]\na = [1,\n", "scene.toml:3: not TOML"),
        ("a = " + 5000 * "[", "scene.toml: not a scene: nested too deeply"),
    ],
)
def test_scenes(refused, text, expected):
    assert expected in "\n".join(refused(text))


def test_files_that_are_no_scene(tmp_path):
    with pytest.raises(SceneError, match=r"nowhere\.toml: cannot be read: No such file or directory$"):
        load_scene(tmp_path / "nowhere.toml")
    with pytest.raises(SceneError, match="cannot be read: Is a directory"):
        check_scene(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b"[scene]\n# \xe9t\xe9\n")
    with pytest.raises(SceneError, match=r"latin\.toml:2: not text in UTF-8"):
        load_scene(tmp_path / "latin.toml")


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("substeps = 2", 'collisions.substeps: only the paper\'s rules take it; this is rule "exact"'),
        ("rule = 'exact'\nparallel_face = 1", "collisions.parallel_face: only the paper's rules take it"),
        ("parallel = 'paper'", 'collisions.parallel: must be "patch" or "off" under rule "exact"; got "paper"'),
        ("rule = 'paper'\nfriction = 0.1", 'collisions.friction: only rule "exact" takes it; this is rule "paper"'),
        ("rule = 'paper'\nsimultaneous = 'together'", 'collisions.simultaneous: only rule "exact" takes it'),
        ("rule = 'paper'\npatch_angle = 0.1", 'collisions.patch_angle: only rule "exact" takes it'),
        (
            "rule = 'paper-advance'\nparallel = 'patch'",
            'collisions.parallel: must be "paper" or "off" under rule "paper-advance"; got "patch"',
        ),
        ("parallel = 'none'", "collisions.parallel: must be 'patch', 'paper' or 'off'; got \"none\""),
        ("simultaneous = 'both'", "collisions.simultaneous: must be 'together' or 'sequential'; got \"both\""),
        ("patch_angle = 1", "collisions.patch_angle: must be at most 0.1 rad; got 1"),
        ("friction = -0.1", "collisions.friction: must be at least 0; got -0.1"),
        ("impact_duration = 0.1", "collisions.impact_duration: unknown key 'impact_duration'"),
    ],
)
def test_collisions_of_a_rule(refused, keys, expected):
    lines = refused(HEAD + "[collisions]\n" + keys + "\n" + BODY + "mass = 1")
    assert len(lines) == 1, lines
    assert expected in lines[0]


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("motion = 'free'", 'body "p".motion: a plane is fixed or moves as prescribed; it has no mass'),
        ("motion = 'fixed'\ndensity = 1", 'body "p".density: a plane has no mass'),
        ("motion = 'fixed'\nregion = 'r'", 'body "p".region: a plane has no vertices to exchange'),
    ],
)
def test_planes(refused, keys, expected):
    plane = '[[body]]\nname = "p"\nshape = { plane = { normal = [0, 0, 1] } }\n'
    (line,) = refused(HEAD + BODY + "mass = 1\n" + plane + keys)
    assert line.endswith(expected)


def test_planes_that_cannot_be(refused):
    plane = '[[body]]\nname = "p"\nmotion = "fixed"\nshape = { plane = { normal = [0, 0, 0] } }\n'
    (line,) = refused(HEAD + BODY + "mass = 1\n" + plane)
    assert line.endswith('body "p".shape.plane.normal: must point somewhere; got [0, 0, 0]')
    plane = plane.replace("0, 0, 0", "0, 0, 1")
    assert refused(HEAD + plane) == ["scene.toml: a scene needs at least one body that is no plane"]
    assert refused(HEAD + "[collisions]\nrule = 'paper'\n" + BODY + "mass = 1\n" + plane) == [
        'scene.toml:14: body "p".shape.plane: only rule "exact" takes it; this is rule "paper", which measures meshes'
    ]
    array = plane.replace("[[body]]", "[[array]]") + "place.grid = { origin = [0, 0, 0], counts = [2, 1, 1], "
    (line,) = refused(HEAD + BODY + "mass = 1\n" + array + "spacing = [1, 0, 0] }\n")
    assert line.endswith('array "p".shape.plane: not for an array: a plane has no end')


def test_a_pair_of_materials_says_something_that_its_rule_takes(refused):
    text = BODY + "mass = 1\nmaterial = 'ice'\n[[material]]\nbetween = ['ice', 'ice']\n"
    assert refused(HEAD + text) == ["scene.toml:10: material 1: needs 'restitution' or 'friction'"]
    (line,) = refused(HEAD + "[collisions]\nrule = 'paper'\n" + text + "friction = 0.1\n")
    assert line.endswith('material 1.friction: only rule "exact" takes it; this is rule "paper"')


def test_an_open_mesh_is_refused_for_a_free_body_only(refused, tmp_path):
    vertices, triangles = cube()
    write_stl(tmp_path / "open.stl", vertices, triangles[1:])
    shape = 'shape = { stl = "open.stl" }\n'
    (line,) = refused(HEAD + f'[[body]]\nname = "a"\nmass = 1\n{shape}')
    assert line.startswith('scene.toml:8: body "a".shape.stl: open.stl: 3 open edges (the first from (')
    assert line.endswith("): a free body needs a closed surface")
    (line,) = refused(HEAD + f'[[body]]\nname = "a"\nmotion = "fixed"\ndensity = 1\n{shape}')
    assert line.endswith(": a body with a density needs a closed surface")
    (tmp_path / "scene.toml").write_text(HEAD + f'[[body]]\nname = "a"\nmotion = "fixed"\n{shape}')
    (body,) = check_scene("scene.toml").bodies
    assert body.notes[0].startswith("not a closed surface: 3 open edges")
    assert (body.mass, body.volume, body.principal_moments) == (None, None, None)


def test_a_broken_mesh_is_named_for_every_body_that_has_it(refused, tmp_path):
    (tmp_path / "cut.stl").write_bytes(write_stl(tmp_path / "whole.stl", *cube()).read_bytes()[:-50])
    bodies = "".join(f'[[body]]\nname = "{name}"\nmass = 1\nshape = {{ stl = "cut.stl" }}\n' for name in "ab")
    lines = refused(HEAD + bodies)
    assert [line.split(": ")[1] for line in lines] == ['body "a".shape.stl', 'body "b".shape.stl']
    assert all("cut short or not an STL file" in line for line in lines)


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ("place = {}", 'array "f".place: must have exactly one of grid, poses, random; got none'),
        ("", 'array "f".place: needed, but missing'),
        (
            "place.grid = { origin = [0, 0, 0], counts = [1, 0, 1], spacing = [1, 1, 1] }",
            "counts[1]: must be at least 1; got 0",
        ),
        (
            "place.grid = { origin = [0, 0, 0], counts = [1, 1.5, 1], spacing = [1, 1, 1] }",
            "counts[1]: must be a whole number",
        ),
        (
            "place.grid = { origin = [0, 0, 0], counts = [1000, 1000, 1000], spacing = [1, 1, 1] }",
            'array "f": brings the scene to 1000000000 bodies; at most 1000000 are allowed',
        ),
        (
            "place.random = { low = [0, 0, 0], high = [1, 1, 0], count = 100, seed = 1 }",
            'scene.toml:9: array "f".place.random: only ',
        ),
        (
            "place.random = { low = [0, 0, 0], high = [1, 0.1, 0], count = 1, seed = 1 }",
            "no member fits: 'low' and 'high' must be 0.328295 m",
        ),
        ('place.poses = "nowhere.csv"', 'array "f".place.poses: nowhere.csv: cannot be read'),
        (
            'place.poses = "p.csv"\nmotion = { table = "t.csv" }',
            "motion.table: not for an array: all members would be in one",
        ),
        ('place.poses = "p.csv"\nposition = [0, 0, 0]', "unknown key 'position'"),
    ],
)
def test_arrays(refused, place, expected):
    lines = refused(HEAD + '[[array]]\nname = "f"\nmass = 1\n' + PRISM + place + "\n")
    assert expected in "\n".join(lines)


def test_a_member_with_the_name_of_a_body(refused):
    array = '[[array]]\nname = "a"\nmass = 1\n' + PRISM
    array += "place.grid = { origin = [0, 0, 0], counts = [3, 1, 1], spacing = [1, 1, 1] }\n"
    body = BODY.replace('"a"', '"a-002"') + "mass = 1\n"
    assert refused(HEAD + body + array) == [
        "scene.toml:10: array \"a\".name: 'a-002' is already the name of the body on line 5"
    ]
