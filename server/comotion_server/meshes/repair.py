"""From corners and facets as a file has them to a sound mesh, with an account of what was done.

1. Corners that are equal become one vertex; facets that collapse and facets given twice are taken out.
2. Where edges are still open, vertices *on open edges* that lie within `CRACK` of each other are joined: a file of
   single precision can round one point to two neighbouring numbers. A closed surface is never altered by this.
3. Facets without area are taken out so that the surface stays closed.
4. Facets are turned to run the same way as their neighbours, then outward.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from comotion_server.meshes.edges import Edges, edges_of
from comotion_server.meshes.facets import dissolve_flat, drop_collapsed, drop_doubled, measure
from comotion_server.meshes.mass import mass_properties
from comotion_server.meshes.mesh_errors import MeshError
from comotion_server.meshes.mesh_health import MeshHealth, Point
from comotion_server.meshes.orientation import make_consistent, make_outward, shells_of
from comotion_server.meshes.triangle_mesh import TriangleMesh
from comotion_server.meshes.welding import drop_unused, join_near, weld

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

CRACK = 2.0**-22
"""Widest crack that is joined, over the diagonal of the bounds: two units in the last place of single precision.
Larger values close real slits."""

FLAT = 32 * np.finfo(np.float64).eps
"""Height below which a facet has no area, over the largest coordinate: what rounding of its corners can make.
Larger values take out needles that are part of the shape."""

LARGEST = 1e12
"""Largest coordinate [m] that is taken for meant: far beyond it, products of products leave double precision."""

SMALLEST = 1e-12
"""Smallest diagonal [m] of a mesh, for the same reason."""

FLAT_PASSES = 4
"""Rounds in which flat facets behind flat facets are taken out one after the other; what is left then leaves holes."""


class LoadedMesh(NamedTuple):
    """A mesh in the coordinates of its file, and its health."""

    mesh: TriangleMesh
    health: MeshHealth


def repair(points: Floats, facets: Integers) -> LoadedMesh:
    """Weld, clean and orient a surface.

    Args:
        points: corners [m], shape (n, 3).
        facets: corner numbers, shape (m, 3).

    Raises:
        MeshError: there is no usable facet, or a coordinate is not a sensible number.
    """
    if len(facets) == 0:
        raise MeshError("there is no facet in the file")
    _check_coordinates(points)
    done: Counter[str] = Counter(corners_read=len(points), facets_read=len(facets))
    points, numbers = weld(points + 0.0)
    triangles = _clean(numbers[facets], done)
    triangles, edges = _close_cracks(points, triangles, edges_of(triangles), done)
    triangles, edges = _take_out_flat(points, triangles, edges, done)
    triangles, unorientable = _orient(points, triangles, edges, done)
    return _loaded(points, triangles, edges, unorientable, done)


def _check_coordinates(points: Floats) -> None:
    bad = ~(np.abs(points) <= LARGEST).all(axis=1)
    if bad.any():
        first = int(np.flatnonzero(bad)[0])
        raise MeshError(
            f"{bad.sum()} of {len(points)} vertices are not finite or beyond {LARGEST:g} m; the first, "
            f"number {first + 1}, is ({', '.join(map(str, points[first].tolist()))})"
        )
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    if 0.0 < diagonal < SMALLEST:
        raise MeshError(f"the whole mesh is {diagonal:g} m across; at least {SMALLEST:g} m is needed")


def _clean(triangles: Integers, done: Counter[str]) -> Integers:
    whole = drop_collapsed(triangles)
    single = drop_doubled(whole)
    done["zero_area"] += len(triangles) - len(whole)
    done["doubled"] += len(whole) - len(single)
    if len(single) == 0:
        raise MeshError(f"none of the {len(triangles)} facets has an area")
    return single


def _close_cracks(points: Floats, triangles: Integers, edges: Edges, done: Counter[str]) -> tuple[Integers, Edges]:
    if len(edges.open) == 0:
        return triangles, edges
    rim = np.unique(edges.ends[edges.open])
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    numbers = join_near(points, rim, CRACK * diagonal)
    joined = int(np.count_nonzero(numbers != np.arange(len(points))))
    if joined == 0:
        return triangles, edges
    done["cracks"] += joined
    triangles = _clean(numbers[triangles], done)
    return triangles, edges_of(triangles)


def _take_out_flat(points: Floats, triangles: Integers, edges: Edges, done: Counter[str]) -> tuple[Integers, Edges]:
    limit = FLAT * float(np.abs(points).max())
    before = len(triangles)
    for attempt in range(FLAT_PASSES + 1):
        flat = np.flatnonzero(measure(points, triangles).height <= limit)
        if len(flat) == 0:
            break
        done["zero_area"] += len(flat) if attempt == 0 else 0
        same = join_near(points, np.unique(triangles[flat]), limit)
        if attempt == FLAT_PASSES:
            triangles = np.delete(triangles, flat, axis=0)
        elif (same != np.arange(len(points))).any():
            triangles = drop_doubled(drop_collapsed(same[triangles]))
        else:
            triangles = dissolve_flat(points, triangles, flat)
        if len(triangles) == 0:
            raise MeshError(f"none of the {before} facets has an area")
        edges = edges_of(triangles)
    return triangles, edges


def _orient(points: Floats, triangles: Integers, edges: Edges, done: Counter[str]) -> tuple[Integers, int | None]:
    turned = make_consistent(triangles, edges)
    done["turned_facets"] += turned.turned
    closed = len(edges.proper) == len(edges.counts)
    if turned.impossible is not None or not closed:
        return turned.triangles, turned.impossible
    triangles, shells = make_outward(points, turned.triangles, shells_of(triangles, edges))
    done["turned_shells"] += shells
    return triangles, None


def _loaded(
    points: Floats, triangles: Integers, edges: Edges, unorientable: int | None, done: Counter[str]
) -> LoadedMesh:
    bad = [*edges.open[:1].tolist(), *edges.non_manifold[:1].tolist()]
    bad += [] if unorientable is None else [unorientable]
    first_bad_edge = None
    if bad:
        a, b = edges.ends[bad[0]]
        first_bad_edge = (_point(points[a]), _point(points[b]))
    shells = len(np.unique(shells_of(triangles, edges)))
    vertices, triangles = drop_unused(points, triangles)
    mesh = TriangleMesh(vertices, triangles.astype(np.uint32))
    figures = measure(vertices, triangles)
    health = MeshHealth(
        vertices=len(vertices),
        triangles=len(triangles),
        shells=shells,
        volume=mass_properties(vertices, triangles).volume if not bad else np.nan,
        area=float(np.sum(figures.area)),
        extent=_point(np.ptp(vertices, axis=0)),
        smallest_edge=float(figures.shortest.min()),
        worst_aspect=float((figures.longest / figures.height).max()),
        open_edges=len(edges.open),
        non_manifold_edges=len(edges.non_manifold),
        unorientable=unorientable is not None,
        first_bad_edge=first_bad_edge,
        **done,
    )
    return LoadedMesh(mesh, health)


def _point(values: Floats) -> Point:
    x, y, z = values.tolist()
    return x, y, z
