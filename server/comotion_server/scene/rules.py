"""Rules between the keys of one table.

They are asked of the table as read, whether or not its values are sound, so that all mistakes of a body show at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from comotion_server.scene.tables import AXES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

Found = tuple[tuple[str, ...], str]
FREE_ONLY = ("locked", "reacts", "thrust", "scalable")
VELOCITIES = ("velocity", "angular_velocity")
SHAPES = ("stl", "box", "prism", "plane", "sphere", "capsule", "cylinder", "pipe")
NO_MESH = ("plane", "sphere", "capsule", "cylinder", "pipe")
NO_TIMES = ("capsule", "cylinder")
EXACT_ONLY = ("friction", "simultaneous", "patch_angle", "merge")
PAPER_ONLY = ("substeps", "parallel_face", "parallel_edge")
PAPER_RULES = ("paper", "paper-advance", "paper-analytic")
FRAMES = ("stl", "scale", "offset")
PLACES = ("grid", "poses", "random")


def body_rules(body: Mapping[str, Any], known: Sequence[str]) -> Iterator[Found]:
    """Broken rules of a `[[body]]` or `[[array]]`: the keys below the table, and what is wrong.

    Args:
        body: the table as read.
        known: all keys that it may have; a table with unknown ones is not also told what it lacks.
    """
    complete = all(key in known for key in body)
    motion = body.get("motion", "free")
    yield from _exactly_one(body.get("shape"), "shape", SHAPES)
    yield from _exactly_one(body.get("frame"), "frame", FRAMES)
    for name in NO_MESH:
        if isinstance(body.get("shape"), dict) and name in body["shape"]:
            yield from _not_with(body, ("frame",), f"a {name} has no frame")
    yield from _exactly_one(body.get("place"), "place", PLACES)
    if isinstance(body.get("shape"), dict) and "plane" in body["shape"]:
        yield from _plane_rules(body)
    else:
        if isinstance(body.get("shape"), dict) and "pipe" in body["shape"]:
            yield from _pipe_rules(body["shape"]["pipe"], motion)
        yield from _mass_rules(body, free=motion == "free", complete=complete)
    if motion == "free":
        yield from _locked_velocity(body)
    elif motion == "fixed":
        yield from _not_with(body, (*FREE_ONLY, *VELOCITIES), "only a free body takes it; this one is fixed")
    elif isinstance(motion, dict):
        yield from _not_with(body, FREE_ONLY, "only a free body takes it; this one's motion is prescribed")
        yield from _not_with(body, VELOCITIES, "a prescribed body moves as its 'motion' says; give it there")
        yield from _motion_rules(body, motion)


def collisions_rules(collisions: Mapping[str, Any]) -> Iterator[Found]:
    """Broken rules of `[collisions]`, as read: keys that its rule does not take."""
    rule = collisions.get("rule", "exact")
    if rule == "exact":
        yield from _not_with(collisions, PAPER_ONLY, 'only the paper\'s rules take it; this is rule "exact"')
        if collisions.get("parallel") == "paper":
            yield ("parallel",), 'must be "patch" or "off" under rule "exact"; got "paper"'
    elif rule in PAPER_RULES:
        yield from _not_with(collisions, EXACT_ONLY, f'only rule "exact" takes it; this is rule "{rule}"')
        if rule == "paper-analytic":
            yield from _not_with(collisions, (*PAPER_ONLY, "parallel", "tolerance"), f'not of rule "{rule}"')
        elif collisions.get("parallel") == "patch":
            yield ("parallel",), f'must be "paper" or "off" under rule "{rule}"; got "patch"'


def exact_only_rules(kind: str, table: Mapping[str, Any], rule: str) -> Iterator[Found]:
    """What a `[[body]]`, `[[array]]` or `[[material]]` asks for that one of the paper's rules does not have."""
    shape = table.get("shape")
    for name in shape if isinstance(shape, dict) else ():
        if rule == "paper-analytic" and name in SHAPES and (name not in NO_MESH or name in NO_TIMES):
            yield ("shape", name), f'rule "{rule}" takes spheres, planes and pipes alone'
        elif rule != "paper-analytic" and name in NO_MESH:
            yield ("shape", name), f'only rule "exact" takes it; this is rule "{rule}", which measures meshes'
    if kind == "material":
        yield from _not_with(table, ("friction",), f'only rule "exact" takes it; this is rule "{rule}"')


def _pipe_rules(pipe: Any, motion: Any) -> Iterator[Found]:
    if motion == "free":
        yield ("motion",), "a pipe is fixed or moves as prescribed: a free one is not in this version"
    elif isinstance(motion, dict) and ("table" in motion or any(motion.get("angular_velocity", ()))):
        yield ("motion",), "a pipe does not turn: a turning one is not in this version"
    if not isinstance(pipe, dict):
        return
    inner, outer = pipe.get("inner_radius"), pipe.get("outer_radius")
    if isinstance(inner, int | float) and isinstance(outer, int | float) and not inner < outer:
        yield ("shape", "pipe", "outer_radius"), f"must be larger than the inner radius, {inner:g} m; got {outer:g}"


def _plane_rules(body: Mapping[str, Any]) -> Iterator[Found]:
    if "place" in body:
        yield ("shape", "plane"), "not for an array: a plane has no end"
    if body.get("motion", "free") == "free":
        yield ("motion",), "a plane is fixed or moves as prescribed; it has no mass"
    yield from _not_with(body, ("mass", "density", "inertia"), "a plane has no mass")
    yield from _not_with(body, ("region",), "a plane has no vertices to exchange")


def _exactly_one(table: Any, name: str, choices: Sequence[str]) -> Iterator[Found]:
    if not isinstance(table, dict) or any(key not in choices for key in table):
        return
    if len(table) != 1:
        given = " and ".join(table) or "none"
        yield (name,), f"must have exactly one of {', '.join(choices)}; got {given}"


def _mass_rules(body: Mapping[str, Any], *, free: bool, complete: bool) -> Iterator[Found]:
    given = [key for key in ("mass", "density") if key in body]
    if len(given) == 2:
        yield ("density",), "give either 'mass' or 'density', not both"
    elif not given and free and complete:
        yield (), "a free body needs 'mass' [kg] or 'density' [kg/m3]"
    elif not given and "inertia" in body and complete:
        yield ("inertia",), "without 'mass' or 'density' it means nothing"


def _locked_velocity(body: Mapping[str, Any]) -> Iterator[Found]:
    locked = body.get("locked", [])
    for key, axes in zip(VELOCITIES, (AXES[:3], AXES[3:]), strict=True):
        values = body.get(key)
        if not isinstance(values, list) or not isinstance(locked, list) or len(values) != 3:
            continue
        against = [axis for axis, value in zip(axes, values, strict=True) if axis in locked and value != 0]
        if against:
            yield (key,), f"must be 0 where motion is locked ({', '.join(against)}); got {values}"


def _motion_rules(body: Mapping[str, Any], motion: Mapping[str, Any]) -> Iterator[Found]:
    if not motion:
        yield ("motion",), "needs 'velocity', 'angular_velocity' or 'table'; a body that stays is \"fixed\""
    if "table" in motion:
        for key in VELOCITIES:
            if key in motion:
                yield ("motion", key), "not together with 'table', which says how the body moves"
        yield from _not_with(body, ("position", "quaternion"), "the table of poses says where the body is")
        if "place" in body:
            yield ("motion", "table"), "not for an array: all members would be in one place"


def _not_with(body: Mapping[str, Any], keys: Sequence[str], why: str) -> Iterator[Found]:
    for key in keys:
        if key in body:
            yield (key,), why
