"""After the warm-up no step of a run waits for a compiler."""

import subprocess
import sys

import pytest

RUN = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from numba.core.dispatcher import Dispatcher
from scenes_by_hand import fixed_box, free_box, scene_of
from comotion_server.simulation import Simulation
from comotion_server.warm_up import warm_up

def compiled():
    modules = [module for name, module in sys.modules.items() if name.startswith("comotion_server.kernels.")]
    kernels = {{item for module in modules for item in vars(module).values() if isinstance(item, Dispatcher)}}
    return sum(len(kernel.overloads) for kernel in kernels)

# a spinning box falls onto a floor, fast enough to be found inside it
spin = dict(velocity=(0.0, 0.0, -3.0), angular_velocity=(0.1, 0.2, 0.3))
box = free_box("box", (1.0, 1.0, 1.0), 1.0, position=(0.0, 0.0, 1.0), **spin)
floor = fixed_box("floor", (9.0, 9.0, 1.0), (0.0, 0.0, -0.5))
scene = scene_of(box, floor, gravity=(0.0, 0.0, -10.0), rule='paper-advance', substeps=1, parallel={parallel!r})
warm_up(scene)
simulation, warm = Simulation(scene), compiled()
impacts = overlaps = 0
for _ in range(40):
    simulation.mark_sent(simulation.sample(0.005, velocities=True))
    out = simulation.step(0.01, {{"box": np.full((8, 3), 0.1)}})
    impacts, overlaps = impacts + out.books.impacts, overlaps + out.books.overlaps
print(impacts > 0, overlaps > 0, compiled() - warm)
"""


@pytest.mark.parametrize("parallel", ["paper", "off"])
def test_a_run_compiles_and_loads_no_kernel_after_the_warm_up(parallel, request):
    source = RUN.format(tests=str(request.config.rootpath / "tests"), parallel=parallel)
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "True", "0"]


EXACT = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from numba.core.dispatcher import Dispatcher
from scenes_by_hand import free_box, plane, scene_of
from comotion_server.simulation import Simulation
from comotion_server.warm_up import warm_up

def compiled():
    modules = [module for name, module in sys.modules.items() if name.startswith("comotion_server.kernels.")]
    kernels = {{item for module in modules for item in vars(module).values() if isinstance(item, Dispatcher)}}
    return sum(len(kernel.overloads) for kernel in kernels)

# a spinning box falls onto one that rests on a floor
spin = dict(velocity=(0.0, 0.0, -3.0), angular_velocity=(0.1, 0.2, 0.3))
falling = free_box("falling", (1.0, 1.0, 1.0), 1.0, position=(0.2, 0.1, 2.0), **spin)
resting = free_box("resting", (1.0, 1.0, 1.0), 1.0, position=(0.0, 0.0, 0.5))
scene = scene_of(falling, resting, plane(), gravity=(0.0, 0.0, -10.0), friction={friction})
warm_up(scene)
simulation, warm = Simulation(scene), compiled()
impacts = held = 0
for _ in range(40):
    simulation.mark_sent(simulation.sample(0.005, velocities=True))
    out = simulation.step(0.01, {{"falling": np.full((8, 3), 0.1)}})
    impacts += out.books.impacts
    held += sum(float(np.abs(contact.held).sum()) for contact in out.contacts)
print(impacts > 0, held > 0, compiled() - warm)
"""


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_nor_does_a_run_of_rule_exact(friction, request):
    source = EXACT.format(tests=str(request.config.rootpath / "tests"), friction=friction)
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "True", "0"]
