"""Plays shipped scenes and prints a digest of all states and impacts. Tests run it with different memory.

python play_and_hash.py SCENE STEPS [SCENE STEPS ...]
"""

import hashlib
import sys

from comotion_mock_cfd.scenes import path_of
from comotion_server.simulation import Simulation

digest = hashlib.sha256()
for name, steps in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
    sim = Simulation.load(path_of(name))
    for _ in range(int(steps)):
        out = sim.step(sim.scene.dt)
        for array in sim._world.state.arrays:
            digest.update(array.tobytes())
        digest.update(repr([(impact.time, impact.impulse) for impact in out.impacts]).encode())
print(digest.hexdigest())  # noqa: T201
