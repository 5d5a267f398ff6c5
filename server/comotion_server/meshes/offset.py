"""A closed surface moved outward: every facet's plane by the same distance, with the same corners and facets (P17).

A corner d from where it was has moved out by n . d over a facet with normal n. Up to three planes through a corner, and
more where all touch one sphere, ask for n . d = offset of every one: the shortest such d is taken. Where no d
does (most corners of four planes and more), d is the shortest of those with n . d >= offset. So every facet moves
out by at least the offset, and exactly by it wherever its corners allow.

The shortest d under inequalities rests on at most three planes. The search keeps such a basis, takes in the plane that
is violated most, and finds the new basis among the four by trying: d grows each time, so it ends.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.self_crossing import first_crossing
from comotion_server.meshes.triangle_mesh import TriangleMesh

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

LEVEL = 1e-10  # squared spread of normals that count as one: 1e-5 rad, what single precision leaves of a flat face
EVEN = 1e-6  # of the offset: planes that miss it by less are met
APART = 1e-6  # [rad] between normals that the search tells apart; smaller: rounding exceeds `MET`
MET = 1e-8  # of the offset: what the search may miss a plane by
ROUNDS = 1000  # of the search; it takes about as many as a corner has planes
NEW_BASES = ((3,), (0, 3), (1, 3), (2, 3), (0, 1, 3), (0, 2, 3), (1, 2, 3))  # of a basis of three and a fourth


def moved_out(mesh: TriangleMesh, offset: float) -> TriangleMesh:
    """The mesh with all facets moved out by `offset` [m].

    Raises:
        MeshError: a corner has no way out, a facet turns over, or the surface crosses itself.
    """
    points, facets = mesh.vertices, mesh.triangles.astype(np.int64)
    normals = _normals(points, facets)
    moved = points + offset * _steps(points, facets, normals)
    turned = np.flatnonzero(np.einsum("ij,ij->i", _normals(moved, facets), normals) <= 0.0)
    if len(turned):
        at = _shown(points[facets[turned[0]]].mean(axis=0))
        raise MeshError(f"moved out by {offset:g} m, the facet at {at} turns over; take a smaller offset")
    crossing = first_crossing(moved, facets)
    if crossing is not None:
        one, other = (_shown(points[facets[f]].mean(axis=0)) for f in crossing)
        raise MeshError(f"moved out by {offset:g} m, the facets at {one} and at {other} meet; take a smaller offset")
    return TriangleMesh(moved, mesh.triangles)


def _normals(points: Floats, facets: Integers) -> Floats:
    """Unit normals (m, 3); zero of a facet without area."""
    a, b, c = (points[facets[:, k]] for k in range(3))
    doubled = np.cross(b - a, c - a)
    size = np.linalg.norm(doubled, axis=1, keepdims=True)
    return np.asarray(np.divide(doubled, size, out=np.zeros_like(doubled), where=size > 0.0))


def _steps(points: Floats, facets: Integers, normals: Floats) -> Floats:
    """How far each corner moves, (n, 3), for an offset of 1."""
    corner = facets.reshape(-1)
    facet = np.repeat(np.arange(len(facets)), 3)
    spread, total = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))
    np.add.at(spread, corner, normals[facet, :, None] * normals[facet, None, :])
    np.add.at(total, corner, normals[facet])
    steps: Floats = np.einsum("nij,nj->ni", np.linalg.pinv(spread, rcond=LEVEL, hermitian=True), total)
    missed = np.abs(np.einsum("ij,ij->i", normals[facet], steps[corner]) - 1.0) > EVEN
    unequal = np.unique(corner[missed])
    if len(unequal):
        order = np.argsort(corner, kind="stable")
        first = np.searchsorted(corner[order], unequal)
        count = np.searchsorted(corner[order], unequal, side="right") - first
        for valence in np.unique(count):
            these = np.flatnonzero(count == valence)
            around = facet[order[first[these, None] + np.arange(valence)]]
            found = _least_steps(normals[around])
            if np.isnan(found).any():
                at = _shown(points[unequal[these[np.flatnonzero(np.isnan(found).any(axis=1))[0]]]])
                raise MeshError(f"the corner at {at} has no way out: its facets look in opposite directions")
            steps[unequal[these]] = found
    return steps


def _least_steps(normals: Floats) -> Floats:
    """Shortest d (n, 3) with n . d >= 1 for all normals (n, k, 3) of each corner; nan where there is none."""
    d = normals[:, 0].copy()
    basis = np.zeros((len(d), 3), dtype=np.int64)
    for _ in range(ROUNDS):
        out = np.einsum("nki,ni->nk", normals, d)
        rows = np.flatnonzero(out.min(axis=1) < 1.0 - MET)  # never a nan: its comparison is false
        if not len(rows):
            break
        four = np.column_stack([basis[rows], out[rows].argmin(axis=1)])
        planes = normals[rows[:, None], four]
        shortest = np.full(len(rows), np.inf)
        d[rows] = np.nan
        for new in NEW_BASES:
            some = planes[:, new]
            way = np.linalg.pinv(some, rcond=APART).sum(axis=2)
            length = np.einsum("ni,ni->n", way, way)
            better = (np.einsum("nki,ni->nk", planes, way).min(axis=1) >= 1.0 - MET) & (length < shortest)
            shortest[better], d[rows[better]] = length[better], way[better]
            basis[rows[better]] = four[better][:, [*new, *new[:1], *new[:1]][:3]]
    else:
        d[rows] = np.nan
    return d


def _shown(point: Floats) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in point) + ")"
