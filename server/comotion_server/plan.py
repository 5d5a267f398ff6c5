"""What a step of a scene runs, decided once: the one ordered table of stages, and why each is in or out.

A stage that a scene does not need is not built: its code is not imported, its kernels are not compiled, its arrays do
not exist. The loop in `simulation` runs what is there and asks nothing.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from comotion_server.forces import Wrenches
from comotion_server.results import CollisionRecord
from comotion_server.scene import Body, Fixed, Free, Prescribed, Scene
from comotion_server.world import World

if TYPE_CHECKING:
    from comotion_server.collision_queue import CollisionQueue
    from comotion_server.exact_queue import ExactQueue
    from comotion_server.paper_analytic import AnalyticQueue


@dataclass(slots=True)
class Step:
    """What the stages of one step hand on to each other."""

    time: float  # at its beginning, since the start of the scene [s]
    duration: float  # [s]
    wrenches: Wrenches  # fluid, per body
    drifting: bool = False  # a prediction with the present velocities held, instead of a step
    collisions: CollisionRecord = field(default_factory=CollisionRecord)


Action = Callable[[Step], None]


@dataclass(frozen=True, slots=True)
class Decision:
    """Whether a scene needs a stage, and the reason either way."""

    kept: bool
    reason: str


@dataclass(frozen=True, slots=True)
class Stage:
    """A row of the table: a name, the decision, and how to build the stage's action, unless it works inside another."""

    name: str
    decide: Callable[[Scene], Decision]
    build: Callable[[World], Action] | None = None


@dataclass(frozen=True, slots=True)
class PlanLine:
    """One line of `comotion plan`."""

    stage: str
    kept: bool
    reason: str


def _plural(count: int, noun: str, nouns: str) -> str:
    return f"{count} {noun if count == 1 else nouns}"


def _free_bodies(scene: Scene) -> list[Body]:
    return [body for body in scene.bodies if isinstance(body.motion, Free)]


def _decide_take_off(scene: Scene) -> Decision:
    moving = [body for body in scene.bodies if not isinstance(body.motion, Fixed)]
    if not moving:
        return Decision(kept=False, reason="no body moves")
    return Decision(kept=True, reason=_plural(len(moving), "body moves", "bodies move"))


def _build_take_off(world: World) -> Action:
    def take_off(step: Step) -> None:
        if step.drifting:
            world.take_off_drifting()
        else:
            world.take_off(step.wrenches.force, step.wrenches.moment)

    return take_off


def _decide_tables(scene: Scene) -> Decision:
    count = sum(isinstance(body.motion, Prescribed) and body.motion.table is not None for body in scene.bodies)
    if not count:
        return Decision(kept=False, reason="no body follows a table of poses")
    return Decision(kept=True, reason=_plural(count, "body follows a table of poses", "bodies follow tables of poses"))


def _build_tables(world: World) -> Action:
    def follow_tables(step: Step) -> None:
        world.follow_tables(step.time, 0.0)

    return follow_tables


def _reacting_pairs(scene: Scene) -> int:
    """Pairs of bodies of which at least one gives way to impacts."""
    count = len(scene.bodies)
    stiff = count - sum(body.motion.reacts for body in _free_bodies(scene) if isinstance(body.motion, Free))
    return count * (count - 1) // 2 - stiff * (stiff - 1) // 2


def _decide_collisions(scene: Scene) -> Decision:
    if len(scene.bodies) < 2:
        return Decision(kept=False, reason="a lone body has nothing to collide with")
    pairs = _reacting_pairs(scene)
    if not pairs:
        return Decision(kept=False, reason="no body gives way to impacts")
    rule = scene.collisions.rule
    return Decision(kept=True, reason=f'{_plural(pairs, "pair", "pairs")} may collide; rule "{rule}"')


def _queue_of(world: World) -> "CollisionQueue | ExactQueue | AnalyticQueue":
    if world.scene.collisions.rule == "exact":
        from comotion_server.exact_queue import ExactQueue

        return ExactQueue(world)
    if world.scene.collisions.rule == "paper-analytic":
        from comotion_server.paper_analytic import AnalyticQueue

        return AnalyticQueue(world)
    from comotion_server.collision_queue import CollisionQueue

    return CollisionQueue(world)


def _build_collisions(world: World) -> Action:
    if world.scene.collisions.merge or world.scene.collisions.heal != "off":
        return _build_changing(world)
    queue = _queue_of(world)
    world.memories.append(queue)

    def collide(step: Step) -> None:
        queue.begin(step.time)
        for until in world.stops(step.time, step.duration):
            queue.play(until)
            world.follow_tables(step.time + until, until)
        step.collisions = queue.record()

    return collide


def _build_changing(world: World) -> Action:
    from comotion_server.changing_bodies import ChangingBodies

    changing = ChangingBodies(world)
    world.memories.append(changing)

    def collide(step: Step) -> None:
        wrenches = step.wrenches.force, step.wrenches.moment
        step.collisions = changing.step(step.time, step.duration, *wrenches, drifting=step.drifting)

    return collide


def _decide_merging(scene: Scene) -> Decision:
    if not scene.collisions.merge or not _decide_collisions(scene).kept:
        return Decision(kept=False, reason="merge = false" if not scene.collisions.merge else "nothing collides")
    return Decision(kept=True, reason="bodies that meet with restitution 0 become one (P11)")


def _decide_healing(scene: Scene) -> Decision:
    if scene.collisions.heal == "off" or not _decide_collisions(scene).kept:
        return Decision(kept=False, reason='heal = "off"' if scene.collisions.heal == "off" else "nothing collides")
    count = sum(body.scalable for body in _free_bodies(scene))
    return Decision(kept=True, reason=f"{_plural(count, 'body', 'bodies')} may be scaled down where pinched (P16)")


def _decide_parallel(scene: Scene) -> Decision:
    if not _decide_collisions(scene).kept:
        return Decision(kept=False, reason="nothing collides")
    kind = scene.collisions.parallel
    if kind == "off":
        return Decision(kept=False, reason='parallel = "off"')
    if kind == "patch":
        return Decision(kept=True, reason="level faces and edges touch as a whole")
    return Decision(kept=True, reason="near-parallel contacts push without turning (P12)")


def _decide_free_flight(scene: Scene) -> Decision:
    if _decide_collisions(scene).kept:
        return Decision(kept=False, reason="the collision queue moves the bodies")
    return Decision(kept=True, reason="nothing collides: bodies fly to the end of the step at once")


def _build_free_flight(world: World) -> Action:
    def fly(step: Step) -> None:
        for until in world.stops(step.time, step.duration):
            world.advance(until)
            world.follow_tables(step.time + until, until)

    return fly


def _decide_vertices(scene: Scene) -> Decision:
    still = [name for name, bodies in scene.regions.items() if all(isinstance(body.motion, Fixed) for body in bodies)]
    if not still:
        return Decision(kept=True, reason="every region moves")
    names = ", ".join(f'"{name}"' for name in still)
    if len(still) == len(scene.regions):
        return Decision(kept=False, reason=f"never move, placed once: {names}")
    return Decision(kept=True, reason=f"but for {names}: never moves, placed once")


def _decide_frames(scene: Scene) -> Decision:
    framed = [body for body in scene.bodies if body.frame is not None]
    if not framed:
        return Decision(kept=False, reason="every body collides with its own surface")
    if not _decide_collisions(scene).kept:
        return Decision(kept=False, reason="nothing collides")
    sizes = {region: len(bodies) for region, bodies in scene.regions.items()}
    counts = Counter(body.region for body in framed)
    whose = ", ".join(
        f'"{region}"' if count == sizes[region] else f'{count} of {sizes[region]} in "{region}"'
        for region, count in sorted(counts.items())
    )
    return Decision(kept=True, reason=f"{_plural(len(framed), 'body collides', 'bodies collide')} with frames: {whose}")


STAGES = (
    Stage("motion tables", _decide_tables, _build_tables),
    Stage("take off", _decide_take_off, _build_take_off),
    Stage("collisions", _decide_collisions, _build_collisions),
    Stage("frames", _decide_frames),
    Stage("merging", _decide_merging),
    Stage("healing", _decide_healing),
    Stage("parallel contacts", _decide_parallel),
    Stage("free flight", _decide_free_flight, _build_free_flight),
    Stage("place vertices", _decide_vertices),
)


class Plan:
    """The stages that a scene needs."""

    def __init__(self, scene: Scene) -> None:
        self._decisions = [(stage, stage.decide(scene)) for stage in STAGES]

    def explain(self) -> list[PlanLine]:
        """Every stage, whether it is kept, and why."""
        return [PlanLine(stage.name, decision.kept, decision.reason) for stage, decision in self._decisions]

    def keeps(self, name: str) -> bool:
        """Whether the stage of this name runs."""
        return any(decision.kept for stage, decision in self._decisions if stage.name == name)

    def build(self, world: World) -> list[Action]:
        """The actions of a step, in order."""
        return [stage.build(world) for stage, decision in self._decisions if decision.kept and stage.build is not None]
