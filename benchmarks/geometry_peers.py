"""The peers' distance of two meshes: coal (its best tree, OBBRSS) and python-fcl."""

from contextlib import suppress

import coal
import numpy as np

with suppress(ImportError):
    import fcl


def coal_model(mesh):
    """Coal's mesh."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(mesh.triangles), len(mesh.vertices))
    model.addVertices(mesh.vertices)
    model.addTriangles(mesh.triangles.astype(np.int64))
    model.endModel()
    return model


class Coal:
    """Answers a list of queries one after another; `bounds` [m], if given, are upper bounds to start from."""

    def __init__(self, meshes, queries):
        self.models = [coal_model(mesh) for mesh in meshes]
        self.poses = [[coal.Transform3s(R, x) for R, x in query] for query in queries]
        self.request = coal.DistanceRequest(True, 0.0, 0.0)
        self.result = coal.DistanceResult()

    def run(self, out, bounds=None):
        a, b, request, result = *self.models, self.request, self.result
        for k, (pose_a, pose_b) in enumerate(self.poses):
            result.clear()
            if bounds is not None:
                result.min_distance = bounds[k]
            out[k] = coal.distance(a, pose_a, b, pose_b, request, result)


class Fcl:
    """The same for python-fcl."""

    def __init__(self, meshes, queries):
        models = [fcl.BVHModel() for _ in meshes]
        for model, mesh in zip(models, meshes, strict=True):
            model.beginModel(len(mesh.vertices), len(mesh.triangles))
            model.addSubModel(mesh.vertices, mesh.triangles.astype(np.int64))
            model.endModel()
        self.objects = [
            [fcl.CollisionObject(model, fcl.Transform(R, x)) for model, (R, x) in zip(models, query, strict=True)]
            for query in queries
        ]
        self.request = fcl.DistanceRequest(enable_nearest_points=True)

    def run(self, out):
        for k, (a, b) in enumerate(self.objects):
            out[k] = fcl.distance(a, b, self.request, fcl.DistanceResult())
