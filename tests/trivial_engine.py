"""A deterministic stand-in for the simulation, simple enough to be worked out by hand in a test.

One body per region, of mass 1, without gravity: v += F dt, then x += v dt; nothing ever turns or collides. A region
whose name begins with "wall" never moves. `hold` lets a test keep a step from ending, `fail` makes the next one fail.
"""

import threading
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACETS = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype="<u4")


@dataclass(frozen=True)
class TrivialRegion:
    name: str
    moves: bool
    vertex_count: int = 4
    triangles: np.ndarray = field(default_factory=lambda: FACETS)

    @property
    def bodies(self):
        return (SimpleNamespace(name=f"{self.name}-body", first_vertex=0, vertex_count=self.vertex_count),)


class TrivialEngine:
    def __init__(self, regions=("hull", "ice", "wall")):
        self.regions = tuple(TrivialRegion(name, moves=not name.startswith("wall")) for name in regions)
        self.bodies = SimpleNamespace(names=tuple(f"{name}-body" for name in regions))
        self.plan = SimpleNamespace(explain=lambda: [SimpleNamespace(stage="move", kept=True, reason="a test")])
        self.time = 0.0
        self.position = np.arange(3.0 * len(regions)).reshape(-1, 3)
        self.velocity = np.zeros((len(regions), 3))
        self.scales = np.ones(len(regions))
        self.hold = threading.Event()
        self.hold.set()
        self.entered = threading.Event()
        self.fail: Exception | None = None
        self.steps_taken = 0
        self._sent = None

    def step(self, dt, forces=None, wrenches=None):
        self.entered.set()
        self.hold.wait()
        self.steps_taken += 1
        loads = np.zeros_like(self.velocity)
        moment = np.zeros(3)
        sent = self._sent or self.sample(0.0)
        for row, region in enumerate(self.regions):
            if wrenches is not None:
                loads[row] = wrenches[row, :3]
                moment += wrenches[row, 3:] + np.cross(sent.poses[row, :3], loads[row])
            elif forces and region.name in forces:
                loads[row] = forces[region.name].sum(axis=0)
                moment += np.cross(sent.sent_vertices[region.name], forces[region.name]).sum(axis=0)
        moving = np.array([[region.moves] for region in self.regions])
        self.velocity = self.velocity + loads * dt * moving
        self.position = self.position + self.velocity * dt
        self.time += dt
        self._sent = None
        if self.fail is not None:
            failure, self.fail = self.fail, None
            raise failure
        names = self.bodies.names
        return SimpleNamespace(
            time=self.time,
            dt=dt,
            status="ok",
            sums=SimpleNamespace(force=loads.sum(axis=0), moment=moment),
            budget=SimpleNamespace(limit=10, used=1, exhausted=False, capped=0, fallback=0.0),
            books=SimpleNamespace(
                momentum=1e-16,
                angular_momentum=2e-16,
                energy=3e-16,
                overlaps=0,
                overlap_max=0.0,
                impacts=1,
                rest_energy=0.0,
                shift_work=0.0,
            ),
            blocked=(),
            wear=(),
            impacts=(
                SimpleNamespace(
                    time=self.time,
                    body_a=names[0],
                    body_b=names[-1],
                    point=np.zeros(3),
                    normal=np.array([1.0, 0.0, 0.0]),
                    impulse=2.0,
                    approach_speed=1.0,
                    restitution=0.5,
                    law="ordinary",
                    friction=None,
                ),
            ),
            contacts=(
                SimpleNamespace(
                    body_a=names[0], body_b=names[-1], impulse=np.array([2.0, 0.0, 0.0]), count=1, held=np.zeros(3)
                ),
            ),
        )

    def sample(self, offset, *, vertices=True, velocities=False):
        position = self.position + self.velocity * offset
        places = {region.name: TETRAHEDRON + position[row] for row, region in enumerate(self.regions)}
        speeds = {region.name: np.tile(self.velocity[row], (4, 1)) for row, region in enumerate(self.regions)}
        attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(position), 1))
        return SimpleNamespace(
            time=self.time + offset,
            vertices=places if vertices else {},
            velocities=speeds if velocities else {},
            poses=np.hstack([position, attitude]),
            twists=np.hstack([self.velocity, np.zeros_like(self.velocity)]),
            scales=self.scales,
            sent_vertices=places,
        )

    def mark_sent(self, sample):
        self._sent = sample

    def checkpoint(self):
        return self.time, self.position.copy(), self.velocity.copy(), self._sent

    def restore(self, checkpoint):
        self.time, position, velocity, self._sent = checkpoint
        self.position, self.velocity = position.copy(), velocity.copy()
