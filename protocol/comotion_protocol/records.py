"""The small records inside headers: dataclass to map and back (SPEC M, the tables of records)."""

from dataclasses import fields as dataclass_fields
from functools import cache
from typing import Any

from comotion_protocol import messages as m
from comotion_protocol.fields import Fields


def record(value: Any) -> dict[str, Any]:
    """The map of a record: its fields in the order of its class, without those that are None."""
    pairs = ((name, getattr(value, name)) for name in _names(value.__class__))
    return {name: _plain(item) for name, item in pairs if item is not None}


@cache
def _names(kind: type[Any]) -> tuple[str, ...]:
    """Of the fields of a record."""
    return tuple(field.name for field in dataclass_fields(kind))


def _plain(item: Any) -> Any:
    if isinstance(item, tuple):
        return [record(part) if hasattr(part, "__dataclass_fields__") else part for part in item]
    return item


def read_client(f: Fields) -> m.ClientInfo:
    """Who asks."""
    return m.ClientInfo(name=f.text("name"), version=f.text("version"), id=f.optional(f.text, "id"))


def read_server(f: Fields) -> m.ServerInfo:
    """Who answers."""
    return m.ServerInfo(name=f.text("name"), version=f.text("version"), instance=f.text("instance"))


def read_wants(f: Fields) -> m.Wants:
    """What the client asks for; what is not said is as in `Wants()`."""
    flags = ("vertices", "poses", "twists", "velocities", "impacts", "contacts")
    given: dict[str, Any] = {key: f.flag(key) for key in flags if f.has(key)}
    if f.has("sample"):
        given["sample"] = f.choice("sample", ("end", "midpoint"))
    if f.has("indexing"):
        given["indexing"] = f.choice("indexing", ("welded", "facets"))
    return m.Wants(**given)


def read_region(f: Fields) -> m.Region:
    """A surface and its bodies."""
    return m.Region(
        name=f.text("name"),
        vertex_count=f.count("vertex_count"),
        triangle_count=f.count("triangle_count"),
        moves=f.flag("moves"),
        bodies=tuple(
            m.RegionBody(
                name=b.text("name"), first_vertex=b.count("first_vertex"), vertex_count=b.count("vertex_count")
            )
            for b in f.maps("bodies")
        ),
    )


def read_plan_line(f: Fields) -> m.PlanLine:
    """A stage and its reason."""
    return m.PlanLine(stage=f.text("stage"), kept=f.flag("kept"), reason=f.text("reason", 1024))


def read_limits(f: Fields) -> m.Limits:
    """What the server takes."""
    return m.Limits(
        header_bytes=f.count("header_bytes"),
        bulk_bytes=f.count("bulk_bytes"),
        blocks=f.count("blocks"),
        idle_time=f.finite("idle_time"),
    )


def read_sums(f: Fields) -> m.Sums:
    """Sums of force and moment."""
    return m.Sums(force=f.vector("force"), moment=f.vector("moment"))


def read_budget(f: Fields) -> m.Budget:
    """Work bound of a step."""
    return m.Budget(
        limit=f.count("limit"),
        used=f.count("used"),
        exhausted=f.flag("exhausted"),
        capped=f.optional(f.count, "capped"),
        fallback=f.optional(f.finite, "fallback"),
    )


def read_books(f: Fields) -> m.Books:
    """How the impacts' books closed."""
    return m.Books(
        momentum=f.finite("momentum"),
        angular_momentum=f.finite("angular_momentum"),
        energy=f.finite("energy"),
        overlaps=f.count("overlaps"),
        overlap_max=f.finite("overlap_max"),
        impacts=f.count("impacts"),
        rest_energy=f.optional(f.finite, "rest_energy"),
        shift_work=f.optional(f.finite, "shift_work"),
    )


def read_impact(f: Fields) -> m.Impact:
    """One impact."""
    return m.Impact(
        time=f.finite("time"),
        body_a=f.text("body_a"),
        body_b=f.text("body_b"),
        point=f.vector("point"),
        normal=f.vector("normal"),
        impulse=f.finite("impulse"),
        approach_speed=f.finite("approach_speed"),
        restitution=f.finite("restitution"),
        law=f.text("law"),
        friction=f.optional(f.vector, "friction"),
    )


def read_contact(f: Fields) -> m.Contact:
    """The sum of what a pair exchanged."""
    return m.Contact(
        body_a=f.text("body_a"),
        body_b=f.text("body_b"),
        impulse=f.vector("impulse"),
        count=f.count("count"),
        held=f.optional(f.vector, "held"),
    )


def read_blocked(f: Fields) -> m.Blocked:
    """Who was kept in place, and why."""
    return m.Blocked(
        time=f.finite("time"),
        bodies=f.names("bodies"),
        contacts=tuple(m.Pair(body_a=p.text("body_a"), body_b=p.text("body_b")) for p in f.maps("contacts")),
    )


def read_wear(f: Fields) -> m.Wear:
    """What a body lost by being scaled down."""
    return m.Wear(
        time=f.finite("time"),
        body=f.text("body"),
        scale=f.finite("scale"),
        depth=f.finite("depth"),
        mass=f.finite("mass"),
        momentum=f.vector("momentum"),
        angular_momentum=f.vector("angular_momentum"),
        energy=f.finite("energy"),
    )
