"""A scene of spheres: nothing of meshes is compiled or read, and after the warm-up nothing is compiled at all."""

import json
import subprocess
import sys

RUN = """
import json, sys
from dataclasses import replace
import numpy as np
from numba.core.dispatcher import Dispatcher
from comotion_server.scene import load_scene
from comotion_server.simulation import Simulation
from comotion_server.warm_up import warm_up

def compiled():
    found = set()
    for name, module in sys.modules.items():
        if name.startswith("comotion_server.kernels."):
            for item in vars(module).values():
                if isinstance(item, Dispatcher) and item.py_func.__module__ == name:
                    callee = getattr(item, "callee", item)
                    if item.overloads or callee.overloads:
                        found.add(name.rpartition(".")[2] + "." + item.py_func.__name__)
    return found

def overloads():
    return sum(len(d.overloads) for n, m in sys.modules.items() if n.startswith("comotion_server.kernels.")
               for d in vars(m).values() if isinstance(d, Dispatcher))

scene = load_scene({scene!r})
warm_up(scene)
warm = overloads()
simulation = Simulation(scene)
impacts = sum(len(simulation.step(scene.dt).impacts) for _ in range({steps}))
print(json.dumps([sorted(compiled()), overloads() - warm, impacts, sorted(set(sys.modules) & {{"trimesh", "scipy"}})]))
"""
OF_MESHES = {
    "mesh_pair", "hierarchy", "boxes", "box_fit", "lanes", "lane_tree", "triangle_lanes", "triangle_distance",
    "topology", "contact_patch", "contact_pairs", "contact_hull", "contact_normals", "level_faces", "pair_window",
    "plane_impact", "pair_impact", "pair_impact_bounds", "penetration", "features", "closeness", "contact_plane",
}  # fmt: skip


def run_of(scene, steps, request):
    folder = request.config.rootpath / "mock_cfd" / "comotion_mock_cfd" / "scenes"
    source = RUN.format(scene=str(folder / scene), steps=steps)
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_a_scene_of_spheres_compiles_no_kernel_of_meshes_and_nothing_after_the_warm_up(request):
    compiled, later, impacts, libraries = run_of("pipe.toml", 10, request)
    assert not {name for name in compiled if name.split(".")[0] in OF_MESHES}
    assert impacts > 100
    assert later == 0
    assert "trimesh" not in libraries


def test_nor_where_they_come_to_rest(request):
    compiled, later, impacts, _ = run_of("bounce.toml", 900, request)
    assert not {name for name in compiled if name.split(".")[0] in OF_MESHES}
    assert impacts >= 44 * 49
    assert later == 0
