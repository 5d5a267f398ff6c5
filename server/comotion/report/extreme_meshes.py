"""Bad surfaces, and bodies that overlap at the start."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from comotion.report.cells import Cell, refused
from comotion.report.scenes import CUBE, brick, plane, simulation, solid, sphere
from comotion_server.meshes import TriangleMesh, box
from comotion_server.scene import Body, SceneError

HEALED = "repaired and counted: same volume and inertia"
LINKED = 1.5  # [m] that the centres of linked rings of radius 1 m, 0.5 m thick, can be apart
REFUSED = "said to be unusable, and where"


def cells() -> Iterator[Cell]:
    """All of them."""
    same = "relative error of volume and inertia <= 1e-12"
    for needle in (1e3, 1e6):
        yield Cell("needles", f"1:{needle:g}", HEALED, same, partial(_needle_mended, needle), 1e-12)
    for width in (1e-9, 1e-15):
        yield Cell("slivers", f"width {width:g}", HEALED, same, partial(_needle_mended, 1.0 / width), 1e-12)
    yield Cell("zero-area facet", "on an edge", HEALED, same, lambda: mended(*with_needle(0.0)), 1e-12)
    yield Cell("duplicated vertices", "every corner of every facet", HEALED, same, lambda: mended(*soup()), 1e-12)
    yield Cell("doubled facet", "one", HEALED, same, lambda: mended(*doubled()), 1e-12)
    yield Cell("inverted", "all facets", HEALED, same, lambda: mended(*inverted()), 1e-12)
    yield Cell("mixed orientation", "every other facet", HEALED, same, lambda: mended(*mixed()), 1e-12)
    told = "0: it has a problem with the place named"
    yield Cell("open mesh", "one facet missing", REFUSED, told, lambda: told_of(*without_one()), 0.0)
    yield Cell("non-manifold edge", "two boxes share one", REFUSED, told, lambda: told_of(*sharing_an_edge()), 0.0)
    named = "0: SceneError with both names"
    for value, offset in (("half", 0.5), ("by 1e-3 m", 1.0 - 1e-3), ("same place", 0.0)):
        overlap = partial(overlapping, offset)
        yield Cell("overlap at the start", value, "refused with the pair's names", named, overlap, 0.0)
    slight = "taken as contact and moved apart"
    yield Cell("overlap at the start", "by 1e-7 m", slight, "overlap [m] <= 0", slightly, 0.0)
    inside = "refused with the pair's names"
    yield Cell("nested at the start", "a cube in a cube", inside, named, nested, 0.0)
    for value, offset in (("half", 0.5), ("by 1e-4 m", 1.0 - 1e-4)):
        overlap = partial(overlapping_balls, offset)
        yield Cell("spheres overlap at the start", value, "refused with the pair's names", named, overlap, 0.0)
    yield Cell("nested at the start", "a sphere in a sphere", inside, named, balls_nested, 0.0)
    yield Cell("linked at the start", "links that cross", inside, named, links_crossing, 0.0)
    held = "way [m] that they come apart beyond the hole's room <= 0"
    yield Cell("linked at the start", "links that do not touch", "stay linked", held, links_pulled, 0.0, long=True)
    yield Cell("sunk in a plane", "by half", "refused with the pair's names", named, sunk, 0.0)


def mended(points: np.ndarray, facets: np.ndarray) -> float:
    """Repair a surface that was a unit cube: relative error of its volume and inertia."""
    from comotion_server.meshes import mass_properties
    from comotion_server.meshes.repair import repair

    mesh, health = repair(points, facets)
    if health.problems:
        return np.inf
    found = mass_properties(mesh.vertices, mesh.triangles)
    return max(abs(found.volume - 1.0), float(np.abs(6.0 * found.inertia - np.eye(3)).max()))


def _needle_mended(ratio: float) -> float:
    return mended(*with_needle(1.0 / ratio))


def told_of(points: np.ndarray, facets: np.ndarray) -> float:
    """0 where the repair tells of a problem that it cannot mend, with a place."""
    from comotion_server.meshes import MeshError
    from comotion_server.meshes.repair import repair

    try:
        problems = repair(points, facets).health.problems
    except MeshError as error:
        problems = (str(error),)
    return float(not any("(" in problem or "edge" in problem for problem in problems))


def cube() -> tuple[np.ndarray, np.ndarray]:
    """Corners and facets of the unit cube."""
    mesh = box(CUBE)
    return mesh.vertices.copy(), mesh.triangles.astype(np.int64)


def with_needle(width: float) -> tuple[np.ndarray, np.ndarray]:
    """The first facet is split at a point `width` of its height from its first edge; 0: on it."""
    points, facets = cube()
    a, b, c = facets[0]
    new = len(points)
    inside = 0.5 * (points[a] + points[b]) + width * (points[c] - 0.5 * (points[a] + points[b]))
    points = np.vstack([points, inside])
    rest = [facet for k, facet in enumerate(facets) if k]
    return points, np.array([(a, b, new), (b, c, new), (c, a, new), *rest])


def soup() -> tuple[np.ndarray, np.ndarray]:
    """As STL has it: corners are given anew for every facet."""
    points, facets = cube()
    return points[facets].reshape(-1, 3), np.arange(3 * len(facets)).reshape(-1, 3)


def doubled() -> tuple[np.ndarray, np.ndarray]:
    """A facet is given twice."""
    points, facets = cube()
    return points, np.vstack([facets, facets[:1]])


def inverted() -> tuple[np.ndarray, np.ndarray]:
    """Inside out."""
    points, facets = cube()
    return points, facets[:, ::-1]


def mixed() -> tuple[np.ndarray, np.ndarray]:
    """Every other facet is turned round."""
    points, facets = cube()
    facets[::2] = facets[::2, ::-1]
    return points, facets


def without_one() -> tuple[np.ndarray, np.ndarray]:
    """A facet is missing."""
    points, facets = cube()
    return points, facets[1:]


def sharing_an_edge() -> tuple[np.ndarray, np.ndarray]:
    """Two cubes that touch along an edge: four facets at one edge."""
    points, facets = cube()
    return np.vstack([points, points + np.array([1.0, 1.0, 0.0])]), np.vstack([facets, facets + len(points)])


def overlapping(offset: float) -> float:
    """Two cubes whose centres are `offset` apart."""
    return refused(lambda: _start(brick("a", CUBE), brick("b", CUBE, position=(offset, 0, 0))), SceneError, "a", "b")


def slightly() -> float:
    """Two cubes that overlap by 1e-7 m: what is left of it [m] after a step."""
    sim = simulation(brick("a", CUBE), brick("b", CUBE, position=(1.0 - 1e-7, 0, 0)))
    sim.step(0.01)
    return float(1.0 - (sim.bodies.position[1, 0] - sim.bodies.position[0, 0]))


def nested() -> float:
    """A small cube within a large one: their surfaces do not meet."""
    return refused(lambda: _start(brick("inner", (0.2,) * 3), brick("outer", CUBE)), SceneError, "inner", "outer")


def overlapping_balls(offset: float) -> float:
    """Two spheres whose centres are `offset` apart, 1 m wide."""
    a, b = sphere("a", 0.5), sphere("b", 0.5, position=(offset, 0, 0))
    return refused(lambda: _start(a, b), SceneError, "a", "b")


def balls_nested() -> float:
    """A small sphere within a large one."""
    return refused(lambda: _start(sphere("inner", 0.25), sphere("outer", 1.0)), SceneError, "inner", "outer")


def links(apart: float) -> tuple[Body, Body]:
    """Two links of a chain, rings of radius 1 m and thickness 0.5 m, whose centres are `apart`."""
    upright = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
    mesh = ring(1.0, 0.25)
    other = solid("right", mesh, position=(apart, 0, 0), quaternion=upright, velocity=(1, 0, 0))
    return solid("left", mesh), other


def links_crossing() -> float:
    """The one runs through the other's body."""
    return refused(lambda: _start(*links(1.75)), SceneError, "left", "right")


def links_pulled() -> float:
    """Pulled apart, e = 1: how much farther than linked rings can be, whose holes are 1.5 m wide."""
    sim = simulation(*links(1.0), restitution=1.0)
    farthest = 0.0
    for _ in range(30):
        sim.step(0.1)
        farthest = max(farthest, float(np.linalg.norm(sim.bodies.position[1] - sim.bodies.position[0])))
    return farthest - LINKED


def ring(radius: float, thick: float) -> TriangleMesh:
    """A torus about z, of facets."""
    n, m = 16, 8
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    r = radius + thick * np.cos(v)
    points = np.stack([r * np.cos(u), r * np.sin(u), thick * np.sin(v)], axis=-1).reshape(-1, 3)
    a = np.arange(n * m).reshape(n, m)
    b, d = np.roll(a, -1, 0), np.roll(a, -1, 1)
    quads = np.stack([a, b, np.roll(b, -1, 1), d], axis=-1).reshape(-1, 4)
    return TriangleMesh(points, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def sunk() -> float:
    """A cube half under the floor."""
    return refused(lambda: _start(brick("cube", CUBE), plane()), SceneError, "cube", "floor")


def _start(*bodies):
    simulation(*bodies).step(0.01)
