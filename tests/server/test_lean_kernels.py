"""Kernels of shapes that a scene lacks are neither compiled nor imported; after the warm-up none is compiled."""

import json
import subprocess
import sys

RUN = """
import json, sys
from numba.core.dispatcher import Dispatcher
from comotion_server.scene import load_scene
from comotion_server.simulation import Simulation
from comotion_server.warm_up import warm_up

def imported():
    return {{name.rpartition(".")[2] for name in sys.modules if name.startswith("comotion_server.kernels.")}}

def overloads():
    return sum(len(d.overloads) for n, m in sys.modules.items() if n.startswith("comotion_server.kernels.")
               for d in vars(m).values() if isinstance(d, Dispatcher))

seen = []
for name, steps in {runs!r}:
    scene = load_scene(name)
    warm_up(scene)
    warm = overloads()
    simulation = Simulation(scene)
    impacts = sum(len(simulation.step(scene.dt).impacts) for _ in range(steps))
    seen.append([sorted(imported()), overloads() - warm, impacts, "trimesh" in sys.modules])
print(json.dumps(seen))
"""
OF_MESHES = {
    "mesh_pair", "hierarchy", "boxes", "box_fit", "lanes", "lane_tree", "triangle_lanes", "triangle_distance",
    "topology", "contact_patch", "contact_pairs", "contact_hull", "contact_normals", "level_faces", "pair_window",
    "plane_impact", "pair_impact", "pair_impact_bounds", "penetration", "features", "closeness", "contact_plane",
    "contact_overlap", "flat_contact", "flat_impact", "flat_motion", "time_of_impact", "ray", "triangle_crossing",
}  # fmt: skip
OF_ROUND = {
    "ball_contact", "core_contact", "curved_bore", "curved_cores", "curved_gap", "curved_impact", "curved_mesh_gap",
    "curved_points", "curved_search", "curved_triangles", "line_contact", "line_time", "mixed_contact", "mixed_impact",
    "mixed_motion", "round_contact",
}  # fmt: skip
OF_CYLINDERS = {"curved_cylinders", "cylinder_contact", "cylinder_on_mesh", "face_time", "body_parts", "part_motion"}


def seen_in(request, *runs):
    """What is seen in shipped scenes, each played for some steps in one process."""
    folder = request.config.rootpath / "mock_cfd" / "comotion_mock_cfd" / "scenes"
    source = RUN.format(runs=[(str(folder / scene), steps) for scene, steps in runs])
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_a_scene_of_spheres_imports_no_kernel_of_meshes_and_compiles_nothing_after_the_warm_up(request):
    """Neither where they fly nor where they come to rest."""
    in_flight, at_rest = seen_in(request, ("pipe.toml", 10), ("bounce.toml", 900))
    for imported, later, _, trimesh in (in_flight, at_rest):
        assert not (OF_MESHES | OF_ROUND | OF_CYLINDERS) & set(imported)
        assert {"sphere_impact", "pipe_impact", "smooth_contact"} <= set(imported)
        assert later == 0
        assert not trimesh
    assert in_flight[2] > 100
    assert at_rest[2] >= 44 * 49


def test_a_scene_of_meshes_imports_no_kernel_of_round_shapes(request):
    ((imported, later, _, _),) = seen_in(request, ("cradle_cubes.toml", 2))
    assert {"flat_contact", "pair_window"} <= set(imported)
    assert not (OF_ROUND | OF_CYLINDERS) & set(imported)
    assert later == 0
