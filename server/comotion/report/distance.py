"""Distance of two meshed balls: ours beside coal and python-fcl, by the number of facets; all must agree.

The whole comparison over 13 pairs of shapes and four kinds of gap is `benchmarks/geometry.py`.
"""

import numpy as np

from comotion.report.findings import Chart, Curve, Findings, Point, Table
from comotion.report.scenes import ball
from comotion.report.study import Progress
from comotion.report.timing import timed

QUERIES = 64
PEERS_AGREE = 1e-9  # [m]; the peers' kernels lose digits on edges that are nearly parallel


def study(*, quick: bool, say: Progress) -> Findings:
    """Microseconds per query against facets."""
    from comotion_server.kernels.mesh_pair import closest_points_of_pairs
    from comotion_server.meshes.mesh_store import MeshStore

    rng = np.random.default_rng(20)
    curves = {"comotion, cold": Curve("comotion, cold", "facets"), "comotion, warm": Curve("comotion, warm", "facets")}
    peers, notes = _peers()
    notes += ["Warm: each query starts from the closest triangles of the one before, as in a simulation."]
    curves |= {name: Curve(name, "facets") for name in peers}
    rows = []
    for halvings in (2,) if quick else (1, 2, 3, 4, 5, 6):
        mesh = ball(0.5, halvings)
        facets = len(mesh.triangles)
        say(f"{facets} facets")
        store = MeshStore.build([mesh, mesh])
        x, R = _frames(rng)
        pairs = np.arange(2 * QUERIES).reshape(QUERIES, 1, 2)
        shapes = np.tile(store.shape_of_mesh, QUERIES)
        distance, p, q, n = np.empty((QUERIES, 1)), *(np.empty((QUERIES, 1, 3)) for _ in range(3))
        reach, witness = np.full(1, np.inf), np.full((1, 2), -1)

        def ours(carry, pairs=pairs, shapes=shapes, x=x, R=R, store=store, witness=witness):
            for k in range(QUERIES):
                if not carry:
                    witness[:] = -1
                out = distance[k], p[k], q[k], n[k]  # noqa: B023
                closest_points_of_pairs(store.arrays, shapes, x, R, pairs[k], reach, witness, *out)  # noqa: B023

        for name, carry in (("comotion, cold", False), ("comotion, warm", True)):
            ours(carry)
            spent, _ = timed(lambda: ours(carry))  # noqa: B023
            curves[name].points.append(Point(facets, 1e6 * spent / QUERIES, str(facets)))
        own = distance.ravel().copy()
        for name, peer in peers.items():
            ask = peer(mesh, [(R[2 * k : 2 * k + 2], x[2 * k : 2 * k + 2]) for k in range(QUERIES)])
            spent, theirs = timed(ask)
            curves[name].points.append(Point(facets, 1e6 * spent / QUERIES, str(facets)))
            difference = float(np.abs(np.array(theirs) - own).max())
            rows.append([name, facets, difference, difference <= PEERS_AGREE])
    chart = Chart(
        "distance", "Distance of two meshed balls", "facets", "microseconds per query", [*curves.values()], None
    )
    table = Table("Agreement with the peers", ["peer", "facets", "largest difference [m]", "agree"], rows)
    return Findings([chart], [table] if rows else [], notes)


def _frames(rng):
    """Coherent poses of two balls that pass each other within 0.1 m."""
    x, R = np.zeros((2 * QUERIES, 3)), np.empty((2 * QUERIES, 3, 3))
    for k, angle in enumerate(0.01 * np.arange(QUERIES)):
        s, c = np.sin(angle), np.cos(angle)
        R[2 * k], R[2 * k + 1] = np.eye(3), [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        x[2 * k + 1] = (1.1 * c, 1.1 * s, 0.05 * rng.random())
    return x, R


def _peers():
    found, notes = {}, []
    for name, peer in (("coal", _coal), ("python-fcl", _fcl)):
        try:
            peer(None, [])
        except ModuleNotFoundError:
            notes.append(f"{name} is not installed: left out.")
        else:
            found[name] = peer
    return found, notes


def _coal(mesh, queries):
    import coal

    if mesh is None:
        return None
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.triangles), len(mesh.vertices))
    model.addVertices(mesh.vertices)
    model.addTriangles(mesh.triangles.astype(np.int64))
    model.endModel()
    poses = [[coal.Transform3s(*pose) for pose in zip(*query, strict=True)] for query in queries]
    request, result = coal.DistanceRequest(True, 0.0, 0.0), coal.DistanceResult()

    def ask():
        out = []
        for a, b in poses:
            result.clear()
            out.append(coal.distance(model, a, model, b, request, result))
        return out

    return ask


def _fcl(mesh, queries):
    import fcl

    if mesh is None:
        return None
    model = fcl.BVHModel()
    model.beginModel(len(mesh.vertices), len(mesh.triangles))
    model.addSubModel(mesh.vertices, mesh.triangles.astype(np.int64))
    model.endModel()
    objects = [
        [fcl.CollisionObject(model, fcl.Transform(R, x)) for R, x in zip(*query, strict=True)] for query in queries
    ]
    request = fcl.DistanceRequest(enable_nearest_points=True)
    return lambda: [fcl.distance(a, b, request, fcl.DistanceResult()) for a, b in objects]
