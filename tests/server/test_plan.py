"""What a scene does not need is not built, not imported and not compiled."""

import subprocess
import sys

import pytest
from scenes_by_hand import fixed_box, free_box, moved_box, scene_of

from comotion_server.plan import STAGES, Plan
from comotion_server.scene import Free

LONE_BODY = """
import sys
sys.path.insert(0, {tests!r})
from scenes_by_hand import free_box, scene_of
from comotion_server.simulation import Simulation
sim = Simulation(scene_of(free_box()))
sim.step(0.01)
print(*sorted(name for name in sys.modules if name.startswith("comotion_server")))
"""


def kept(*bodies, **collisions):
    return {line.stage: line.kept for line in Plan(scene_of(*bodies, **collisions)).explain()}


def test_a_lone_body_has_no_collision_stage():
    plan = kept(free_box())
    assert not plan["collisions"]
    assert not plan["parallel contacts"]
    assert plan["free flight"]


def test_a_lone_body_imports_and_compiles_no_collision_code(request):
    """A module that is not imported has no kernels to compile and no arrays to allocate."""
    source = LONE_BODY.format(tests=str(request.config.rootpath / "tests"))
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    modules = done.stdout.split()
    assert "comotion_server.kernels.flight" in modules
    unneeded = ["collision_queue", "pair_table", "contact_response", "contact_features", "meshes.mesh_store"]
    unneeded += [
        f"kernels.{name}" for name in ("impact", "books", "closeness", "mesh_pair", "hierarchy", "penetration")
    ]
    assert not {f"comotion_server.{name}" for name in unneeded} & set(modules)


@pytest.mark.parametrize(
    ("bodies", "needed"),
    [
        ((free_box("a"), fixed_box("b", (1, 1, 1), (9, 0, 0))), True),
        ((moved_box("a", (1, 1, 1), (0, 0, 0), (1, 0, 0)), fixed_box("b", (1, 1, 1), (9, 0, 0))), False),
        ((free_box("a", motion=Free(reacts=False)), fixed_box("b", (1, 1, 1), (9, 0, 0))), False),
        ((free_box("a", motion=Free(reacts=False)), free_box("b", position=(9, 0, 0))), True),
    ],
)
def test_collisions_are_there_only_if_a_body_gives_way(bodies, needed):
    assert kept(*bodies)["collisions"] is needed


def test_parallel_criteria_are_left_out_on_request():
    bodies = free_box("a"), free_box("b", position=(9, 0, 0))
    assert kept(*bodies)["parallel contacts"]
    assert not kept(*bodies, parallel="off")["parallel contacts"]


def test_every_stage_says_why():
    plan = Plan(scene_of(free_box(), fixed_box("floor", (1, 1, 1), (9, 0, 0))))
    assert [line.stage for line in plan.explain()] == [stage.name for stage in STAGES]
    assert all(line.reason for line in plan.explain())
