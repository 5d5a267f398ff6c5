"""Mesh files: the same solid from every format, and plain words for every broken file."""

import numpy as np
import pytest
from mesh_forms import cube, torus, write_stl, write_text_stl

from comotion_server.meshes import MeshError, load_mesh, mass_properties

ROUNDING = 1e-12


def by_trimesh(path, vertices, triangles):
    import trimesh

    trimesh.Trimesh(vertices, triangles, process=False).export(path)
    return path


@pytest.mark.parametrize("name", ["a.stl", "a.STL", "text.stl", "a.obj", "a.ply", "a.off"])
def test_every_format_gives_the_same_cube(tmp_path, name):
    write = write_text_stl if name == "text.stl" else write_stl if name.lower().endswith("stl") else by_trimesh
    mesh, health = load_mesh(write(tmp_path / name, *cube()))
    assert (health.vertices, health.triangles, health.closed) == (8, 12, True)
    assert (mesh.vertices.dtype, mesh.triangles.dtype) == (np.float64, np.uint32)
    assert mesh.vertices.flags.c_contiguous
    assert health.volume == pytest.approx(1.0, rel=ROUNDING)


def test_trimesh_reads_the_same_corners(tmp_path):
    import trimesh

    path = write_stl(tmp_path / "torus.stl", *torus(12))
    mesh = load_mesh(path).mesh
    np.testing.assert_array_equal(mesh.vertices[mesh.triangles], trimesh.load_mesh(path, process=False).triangles)


def test_text_keeps_double_precision(tmp_path):
    vertices, triangles = torus(8)
    mesh = load_mesh(write_text_stl(tmp_path / "torus.stl", vertices, triangles)).mesh
    np.testing.assert_array_equal(mesh.vertices[mesh.triangles], vertices[triangles])


def test_several_solids_in_a_text_file_are_one_body(tmp_path):
    parts = [
        write_text_stl(tmp_path / "p.stl", *cube(offset=(3.0 * k, 0, 0)), name=f"part {k}").read_text()
        for k in range(2)
    ]
    (tmp_path / "two.stl").write_text("".join(parts))
    health = load_mesh(tmp_path / "two.stl").health
    assert (health.shells, health.closed) == (2, True)
    assert health.volume == pytest.approx(2.0, rel=ROUNDING)


def test_a_polygon_file_with_quads_is_cut_into_triangles(tmp_path):
    vertices, _ = cube()
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["f " + " ".join(str(c + 1) for c in quad) for quad in quads]
    (tmp_path / "quads.obj").write_text("\n".join(lines))
    mesh = load_mesh(tmp_path / "quads.obj").mesh
    assert mass_properties(mesh.vertices, mesh.triangles).volume == pytest.approx(1.0, rel=ROUNDING)


def broken(tmp_path):
    """Name of each broken file, its bytes, and what must be said of it."""
    binary = write_stl(tmp_path / "whole.stl", *cube()).read_bytes()
    text = write_text_stl(tmp_path / "whole.stl", *cube()).read_bytes()
    bad = np.frombuffer(binary, np.uint8).copy()
    bad[84 + 12 : 84 + 16] = np.frombuffer(np.float32(np.nan).tobytes(), np.uint8)
    return {
        "empty.stl": (b"", "the file is empty"),
        "short.stl": (binary[:50], "neither a text STL file.*: 50 bytes"),
        "cut.stl": (binary[:-70], "with 12 facets takes 684 bytes; this one has 614"),
        "long.stl": (binary + b"more", "this one has 688"),
        "none.stl": (binary[:80] + bytes(4), "no facet"),
        "noise.stl": (bytes(range(256)) * 2, "cut short or not an STL file"),
        "tiny.stl": (b"\1\2\3", "neither a text STL file"),
        "nan.stl": (bad.tobytes(), "1 of 36 vertices are not finite.*the first, number 1"),
        "text_cut.stl": (text[: len(text) // 2], "breaks off or is garbled"),
        "text_word.stl": (text.replace(b"1.0 1.0", b"1.0 one", 1), "not a number among the vertices: 'one'"),
        "text_nan.stl": (text.replace(b"1.0 1.0", b"1.0 nan", 1), "not finite"),
        "text_empty.stl": (b"solid x\nendsolid x\n", "no facet"),
        "bad.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a facet refers to|not a readable OBJ file"),
        "empty.obj": (b"", "no facet|not a readable OBJ file"),
        "noise.ply": (b"ply\nformat nonsense\n", "not a readable PLY file|no facet"),
        "empty.ply": (b"", "not a readable PLY file|no facet"),
        "noise.off": (b"OFF\n8 12 x\n", "not a readable OFF file|no facet"),
        "a.step": (b"ISO-10303-21;", "unknown kind of mesh file 'a.step'; allowed: .stl, .obj, .ply, .off"),
        "noending": (b"", "unknown kind of mesh file 'noending'"),
    }


BROKEN = [
    "empty.stl",
    "short.stl",
    "cut.stl",
    "long.stl",
    "none.stl",
    "noise.stl",
    "tiny.stl",
    "nan.stl",
    "text_cut.stl",
    "text_word.stl",
    "text_nan.stl",
    "text_empty.stl",
    "bad.obj",
    "empty.obj",
    "noise.ply",
    "empty.ply",
    "noise.off",
    "a.step",
    "noending",
]


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_refused_in_one_line(tmp_path, name):
    content, words = broken(tmp_path)[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=words) as refusal:
        load_mesh(tmp_path / name)
    assert "\n" not in str(refusal.value)


def test_missing_files_and_folders(tmp_path):
    with pytest.raises(MeshError, match="cannot be read: No such file or directory"):
        load_mesh(tmp_path / "nowhere.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(MeshError, match="cannot be read: it is a folder"):
        load_mesh(tmp_path / "folder.stl")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(MeshError, match="cannot be read: it is a folder"):
        load_mesh(tmp_path / "folder.ply")


def test_two_hundred_thousand_facets_take_little_memory(tmp_path):
    """At most 480 bytes a facet: 2 000 000 facets then stay below 1 GB."""
    import tracemalloc

    path = write_stl(tmp_path / "torus.stl", *torus(316))
    tracemalloc.start()
    try:
        mesh, health = load_mesh(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert health.closed
    assert peak < 480 * len(mesh.triangles)
