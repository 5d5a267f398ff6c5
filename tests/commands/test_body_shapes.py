"""Shading, shapes in the bodies' own frames, and the animated glTF made of them."""

import json
from types import SimpleNamespace

import numpy as np
import trimesh

from comotion.outputs.body_shapes import body_shapes, rotation
from comotion.outputs.gltf import continuous, write_glb
from comotion.outputs.shading import Shading
from comotion.outputs.surface import Surface

FLOAT32 = 1e-6  # relative rounding of what is stored as float32, with a margin


def surface_of(**meshes):
    regions, vertices, triangles = [], {}, {}
    for name, mesh in meshes.items():
        body = SimpleNamespace(name=name, first_vertex=0, vertex_count=len(mesh.vertices))
        regions.append(SimpleNamespace(name=name, vertex_count=len(mesh.vertices), bodies=(body,)))
        vertices[name], triangles[name] = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.uint32)
    return Surface(regions, vertices, triangles)


def test_a_box_has_flat_faces_and_twelve_edges():
    box = trimesh.creation.box((1, 2, 3))
    shading = Shading(np.array(box.vertices), np.array(box.faces))
    assert len(shading.edges) == 12
    lengths = np.linalg.norm(np.diff(box.vertices[shading.edges], axis=1)[:, 0], axis=1)
    np.testing.assert_allclose(np.sort(lengths), np.repeat([1.0, 2.0, 3.0], 4))
    np.testing.assert_allclose(shading.normals(box.vertices), np.repeat(box.face_normals, 3, axis=0), atol=1e-12)


def test_a_ball_is_smooth_and_has_no_edges():
    ball = trimesh.creation.icosphere(subdivisions=3)
    shading = Shading(np.array(ball.vertices), np.array(ball.faces))
    assert len(shading.edges) == 0
    corners = ball.vertices[ball.faces.ravel()]
    off = np.linalg.norm(shading.normals(ball.vertices) - corners, axis=1)
    assert off.max() < 0.02  # of a mesh with edges of 0.14 radii; flat faces are off by 0.08


def test_normals_turn_with_the_body():
    ball = trimesh.creation.icosphere(subdivisions=1)
    shading = Shading(np.array(ball.vertices), np.array(ball.faces))
    turn = rotation(np.array([0.5, 0.5, -0.5, 0.5]))
    turned = shading.normals(ball.vertices @ turn.T + 3.0)
    np.testing.assert_allclose(turned, shading.normals(ball.vertices) @ turn.T, atol=1e-12)


def test_shapes_moved_by_their_poses_are_the_surface_again():
    box, ball = trimesh.creation.box((1, 2, 3)), trimesh.creation.icosphere(subdivisions=1)
    surface = surface_of(a=box, b=ball)
    poses = np.array([[1.0, 2, 3, 0.5, 0.5, 0.5, 0.5], [-4.0, 0, 0, 0.8, 0, 0.6, 0]])
    for shape, pose, mesh in zip(body_shapes(surface, poses), poses, (box, ball), strict=True):
        back = shape.corners @ rotation(pose[3:]).T + pose[:3]
        np.testing.assert_allclose(back, mesh.vertices[mesh.faces.ravel()], atol=10 * FLOAT32)


def test_the_glb_holds_bodies_by_name_and_their_poses(tmp_path):
    surface = surface_of(hull=trimesh.creation.box((1, 2, 3)), wall=trimesh.creation.box((4, 4, 1)))
    times = np.array([5.0, 5.5, 6.0])
    half = np.sqrt(0.5)
    poses = np.zeros((3, 2, 7))
    poses[:, :, 3] = 1.0
    poses[:, 0, 0] = [0.0, 1.0, 2.0]
    poses[1, 0, 3:] = [half, 0, 0, half]
    poses[2, 0, 3:] = [0, 0, 0, -1.0]  # the other sign of half a turn: a player must not go back
    scales = np.array([[1.0, 1.0], [1.0, 1.0], [0.5, 1.0]])
    write_glb(tmp_path / "a.glb", body_shapes(surface, poses[0]), {"wall": "fixed"}, times, poses, scales)
    scene = trimesh.load(tmp_path / "a.glb")  # a second reader: geometry and names
    assert set(scene.geometry) == {"hull", "wall"}
    np.testing.assert_allclose(scene.bounds[1], [2.0, 1.5, 2.0], rtol=FLOAT32)  # y up
    data = (tmp_path / "a.glb").read_bytes()
    size = int.from_bytes(data[12:16], "little")
    document, binary = json.loads(data[20 : 20 + size]), data[28 + size :]

    def array(number):
        entry = document["accessors"][number]
        view = document["bufferViews"][entry["bufferView"]]
        columns = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
        return np.frombuffer(binary, "<f4", entry["count"] * columns, view["byteOffset"]).reshape(-1, columns)

    (animation,) = document["animations"]
    assert {channel["target"]["node"] for channel in animation["channels"]} == {0}  # the wall stays
    moved = {c["target"]["path"]: animation["samplers"][c["sampler"]] for c in animation["channels"]}
    np.testing.assert_array_equal(array(moved["rotation"]["input"]).ravel(), [0.0, 0.5, 1.0])
    np.testing.assert_array_equal(array(moved["translation"]["output"])[:, 0], [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(array(moved["scale"]["output"]), [[1.0] * 3, [1.0] * 3, [0.5] * 3])
    expected = [[0, 0, 0, 1], [0, 0, half, half], [0, 0, 1, 0]]  # x y z w
    np.testing.assert_allclose(array(moved["rotation"]["output"]), expected, atol=FLOAT32)


def test_continuous_quaternions_are_the_same_rotations():
    random = np.random.default_rng(3)
    quaternions = random.normal(size=(50, 4))
    smooth = continuous(quaternions)
    np.testing.assert_array_equal(np.abs(smooth), np.abs(quaternions))
    assert np.all(np.einsum("ij,ij->i", smooth[1:], smooth[:-1]) >= 0.0)
