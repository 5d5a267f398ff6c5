"""Round shapes in scene files: what is made of them, and every refusal by its name."""

import numpy as np
import pytest

from comotion_server.scene import Capsule, Cylinder, Pipe, SceneError, Sphere, check_scene, load_scene
from comotion_server.simulation import Simulation

HEAD = '[scene]\nname = "s"\nduration = 1.0\ndt = 0.1\n'


def body(shape, rest="mass = 1", name="a"):
    return f'[[body]]\nname = "{name}"\nshape = {{ {shape} }}\n{rest}\n'


@pytest.fixture
def written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def written(text):
        (tmp_path / "scene.toml").write_text(HEAD + text, encoding="utf-8")
        return "scene.toml"

    return written


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ("sphere = { radius = 0.5, resolution = 8 }", Sphere(0.5, 8)),
        ("capsule = { radius = 0.5, length = 2 }", Capsule(0.5, 2.0)),
        ("cylinder = { radius = 0.5, length = 2, axis = 'x' }", Cylinder(0.5, 2.0, 0)),
        ("pipe = { inner_radius = 0.4, outer_radius = 0.5, length = 2, axis = 'y', caps = true }", None),
    ],
)
def test_a_round_body_alone(written, text, shape):
    shape = shape or Pipe(0.4, 0.5, 2.0, axis=1, caps=True)
    rest = "density = 2" if not isinstance(shape, Pipe) else "motion = 'fixed'\ndensity = 2"
    path = written(body(text, rest))
    (made,) = load_scene(path).bodies
    assert made.shape == shape
    assert made.mass == 2.0 * shape.volume
    assert made.inertia == pytest.approx(2.0 * shape.inertia, rel=1e-15)
    assert "mesh" not in vars(made.shape)
    report = check_scene(path).bodies[0]
    assert report.shape == shape.label
    assert report.size == 2.0 * shape.radius_about_centre
    assert report.vertices == shape.vertex_count
    assert report.health is None


def test_bodies_alike_share_one_surface(written):
    text = "[[array]]\nname = 'a'\nshape = { sphere = { radius = 0.1 } }\nmass = 1\n"
    text += "place = { grid = { origin = [0, 0, 0], counts = [2, 1, 1], spacing = [1, 1, 1] } }\n"
    one, other = load_scene(written(text)).bodies
    assert one.surface is other.surface


def test_spheres_get_vertices_where_they_are(written):
    simulation = Simulation.load(written(body("sphere = { radius = 0.5 }", "mass = 1\nposition = [1, 2, 3]")))
    radii = np.linalg.norm(simulation.vertices("a") - (1.0, 2.0, 3.0), axis=1)
    assert radii == pytest.approx(0.5, abs=1e-15)


PIPE = "pipe = { inner_radius = 0.4, outer_radius = 0.5, length = 2 }"
FIXED = "motion = 'fixed'"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (body("sphere = { radius = 0 }"), 'body "a".shape.sphere.radius: must be at least 1e-12 m; got 0'),
        (body("sphere = { radius = -1 }"), 'body "a".shape.sphere.radius: must be at least 1e-12 m; got -1'),
        (body("sphere = { radius = nan }"), 'body "a".shape.sphere.radius: must be a finite number; got nan'),
        (body("sphere = { radius = inf }"), 'body "a".shape.sphere.radius: must be a finite number; got inf'),
        (body("capsule = { radius = 1 }"), 'body "a".shape.capsule.length: needed, but missing: Of the cylinder'),
        (body("cylinder = { radius = 1, length = 0 }"), "shape.cylinder.length: must be at least 1e-12 m; got 0"),
        (body("cylinder = { radius = 1, length = 1, axis = 'w' }"), "shape.cylinder.axis: must be 'x', 'y' or 'z'"),
        (body("sphere = { radius = 1, resolution = 2 }"), "shape.sphere.resolution: must be at least 3; got 2"),
        (
            body("pipe = { inner_radius = 1, outer_radius = 1, length = 2 }", FIXED),
            'body "a".shape.pipe.outer_radius: must be larger than the inner radius, 1 m; got 1',
        ),
        (
            body(PIPE, FIXED, "p") + body("sphere = { radius = 0.45 }"),
            'radius: must be at most its inner radius, 0.4 m: body "a" begins in the bore of the pipe "p"; got 0.45',
        ),
        (
            body(PIPE, FIXED) + body("cylinder = { radius = 0.1, length = 1 }", "mass = 1", "b"),
            'body "a".shape: not in one scene with a cylinder, as body "b" has',
        ),
        (
            body(PIPE, FIXED) + body("box = { size = [1, 1, 1] }", "mass = 1", "b"),
            'body "a".shape: not in one scene with a mesh, as body "b" has',
        ),
        (
            body(PIPE, FIXED) + body("capsule = { radius = 0.1, length = 1 }", "mass = 1", "b"),
            'body "a".shape: not in one scene with a capsule, as body "b" has',
        ),
        (
            "[collisions]\nmerge = true\n" + body("capsule = { radius = 1, length = 1 }"),
            "body \"a\".shape.capsule: 'merge' and 'heal' are for meshes alone",
        ),
        (
            "[collisions]\nmerge = true\n" + body("cylinder = { radius = 1, length = 1 }"),
            "body \"a\".shape.cylinder: 'merge' and 'heal' are for meshes alone",
        ),
        (
            "[collisions]\nrule = 'paper'\n" + body("cylinder = { radius = 1, length = 1 }"),
            'body "a".shape.cylinder: only rule "exact" takes it; this is rule "paper"',
        ),
        (
            "[collisions]\nrule = 'paper-analytic'\n" + body("capsule = { radius = 1, length = 1 }"),
            'body "a".shape.capsule: rule "paper-analytic" takes spheres, planes and pipes alone',
        ),
        (
            body("prism = { base = 1, height = 0, thickness = 1 }"),
            'body "a".shape.prism.height: must be at least 1e-12 m; got 0',
        ),
    ],
)
def test_refusals(written, text, expected):
    with pytest.raises(SceneError) as refusal:
        load_scene(written(text))
    assert expected in str(refusal.value)


def test_a_large_sphere_beside_a_pipe_is_none_of_its_business(written):
    rest = "mass = 1\nposition = [3, 0, 0]"
    assert len(load_scene(written(body(PIPE, FIXED, "p") + body("sphere = { radius = 0.45 }", rest))).bodies) == 2


LONG = ["capsule = { radius = 0.5, length = 1 }", "cylinder = { radius = 0.5, length = 1 }"]


@pytest.mark.parametrize("shape", ["sphere = { radius = 0.5 }", *LONG])
@pytest.mark.parametrize("other", ["box = { size = [1, 1, 1] }", *LONG])
def test_what_meets(written, shape, other):
    assert len(load_scene(written(body(shape) + body(other, "mass = 1\nposition = [9, 0, 0]", "b"))).bodies) == 2


def test_overlap_at_the_start(written):
    text = body("sphere = { radius = 0.5 }") + body(
        "sphere = { radius = 0.5 }", "mass = 1\nposition = [0.9, 0, 0]", "b"
    )
    with pytest.raises(SceneError, match='bodies "a" and "b": overlap at the start'):
        Simulation.load(written(text))
