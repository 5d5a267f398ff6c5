"""The store: shapes side by side, each prepared once."""

import numpy as np
import pytest
from meshes_by_hand import l_shape, torus

from comotion_server.meshes import box
from comotion_server.meshes.mesh_store import MeshStore


def test_a_shared_mesh_is_stored_once():
    cube, ring = box([1.0, 1.0, 1.0]), torus(6, 4)
    store = MeshStore.build([cube, ring, cube])
    assert store.shape_of_mesh.tolist() == [0, 1, 0]
    assert store.size.tolist() == [cube.size, ring.size]
    assert len(store.arrays.triangles) == len(cube.triangles) + len(ring.triangles)


def test_arrays_are_contiguous_and_of_two_types():
    for array in MeshStore.build([l_shape()]).arrays:
        assert array.flags.c_contiguous
        assert array.dtype in (np.float64, np.int64, np.uint8)


def test_a_shape_is_the_same_alone_and_in_company():
    company = MeshStore.build([torus(6, 4), l_shape(), box([1.0, 2.0, 3.0])]).arrays
    alone = MeshStore.build([l_shape()]).arrays
    vertices = slice(company.vertex_start[1], company.vertex_start[2])
    triangles = slice(company.triangle_start[1], company.triangle_start[2])
    nodes = slice(company.root[1], company.root[2])
    inner = alone.child >= 0
    np.testing.assert_array_equal(company.vertices[vertices], alone.vertices)
    np.testing.assert_array_equal(company.triangles[triangles] - vertices.start, alone.triangles)
    np.testing.assert_array_equal(company.normals[triangles], alone.normals)
    np.testing.assert_array_equal(company.leaf_triangles[triangles] - triangles.start, alone.leaf_triangles)
    np.testing.assert_array_equal(company.first[nodes] - triangles.start, alone.first)
    np.testing.assert_array_equal(company.child[nodes][inner] - nodes.start, alone.child[inner])
    np.testing.assert_array_equal(company.child[nodes][~inner], -1)


def test_normals_point_outward_and_stars_hold_their_vertex():
    m = MeshStore.build([box([1.0, 2.0, 3.0])]).arrays
    centres = m.vertices[m.triangles].mean(axis=1)
    assert np.einsum("ij,ij->i", centres, m.normals).min() > 0
    np.testing.assert_allclose(np.linalg.norm(m.normals, axis=1), 1, atol=1e-15)
    for v in range(len(m.vertices)):
        around = m.star[m.star_start[v] : m.star_start[v + 1]]
        assert sorted(around) == sorted(np.flatnonzero((m.triangles == v).any(axis=1)))


@pytest.mark.parametrize(("mesh", "edges"), [(box([1.0, 2.0, 3.0]), 12), (l_shape(), 18), (torus(6, 4), 48)])
def test_lines_within_flat_faces_are_not_sharp(mesh, edges):  # the quads of a torus are flat
    m = MeshStore.build([mesh]).arrays
    sharp = {frozenset((m.triangles[t, k], m.triangles[t, (k + 1) % 3])) for t, k in np.argwhere(m.sharp)}
    assert len(sharp) == edges


def test_an_open_border_is_an_edge():
    cube = box([1.0, 1.0, 1.0])
    m = MeshStore.build([type(cube)(cube.vertices, cube.triangles[2:])]).arrays
    assert m.sharp.sum() == 2 * 12 - 4  # the four edges of the missing face have one side left
