"""Replies and news made from what the simulation returns (SPEC M1, M8, W3, W4)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_protocol import limits
from comotion_protocol import messages as m
from comotion_server.engine import EngineSample
from comotion_server.surfaces import Surface


def motion_arrays(
    sample: EngineSample, wants: m.Wants, surfaces: Mapping[str, Surface], rows: NDArray[np.intp]
) -> dict[str, Any]:
    """What open and step replies share: velocities, poses and twists of a sample, as far as they are wanted.

    Poses and twists are those of the bodies in `rows`, which have a surface (SPEC M12).
    """
    return {
        "velocities": {
            name: surface.send(sample.velocities[name]) for name, surface in surfaces.items() if wants.velocities
        },
        "poses": sample.poses[rows] if wants.poses else None,
        "twists": sample.twists[rows] if wants.twists else None,
    }


def plan_lines(plan: Any) -> tuple[m.PlanLine, ...]:
    """The plan as the open reply carries it."""
    return tuple(m.PlanLine(stage=line.stage, kept=line.kept, reason=line.reason) for line in plan.explain())


def sums_found(out: Any) -> m.Sums:
    """Sums of the forces of a step."""
    return m.Sums(force=_vector(out.sums.force), moment=_vector(out.sums.moment))


def step_reply(
    request: m.StepRequest,
    out: Any,
    sample: EngineSample,
    wants: m.Wants,
    surfaces: Mapping[str, Surface],
    rows: NDArray[np.intp],
) -> m.StepReply:
    """The reply to a step; regions that never move are not sent again (SPEC M8)."""
    return m.StepReply(
        step=request.step,
        attempt=request.attempt,
        time=float(out.time),
        dt=float(out.dt),
        sample_time=float(sample.time),
        status=out.status,
        sums=sums_found(out),
        budget=_budget(out.budget),
        books=_books(out.books),
        blocked=tuple(map(_blocked, out.blocked)) or None,
        impacts=tuple(map(_impact, out.impacts)) if wants.impacts else None,
        contacts=tuple(map(_contact, out.contacts)) if wants.contacts else None,
        wear=tuple(map(_wear, out.wear)) or None,
        vertices={name: surfaces[name].send(rows) for name, rows in sample.vertices.items() if surfaces[name].moves},
        **motion_arrays(sample, wants, {name: surface for name, surface in surfaces.items() if surface.moves}, rows),
    )


def state_news(request: m.StepRequest, out: Any, sample: EngineSample, rows: NDArray[np.intp]) -> m.StateNews:
    """Where the bodies with a surface are at the end of a step."""
    return m.StateNews(
        step=request.step,
        attempt=request.attempt,
        time=float(out.time),
        poses=np.ascontiguousarray(sample.poses[rows]),
        twists=np.ascontiguousarray(sample.twists[rows]),
        scales=scales_told(sample, rows),
    )


def scales_told(sample: EngineSample, rows: NDArray[np.intp]) -> NDArray[np.float64] | None:
    """Scales (bodies, 1) of the bodies with a surface; None while all are 1 (SPEC W7)."""
    scales = sample.scales[rows, None]
    return None if np.all(scales == 1.0) else np.ascontiguousarray(scales)


def events_news(request: m.StepRequest, out: Any) -> m.EventsNews:
    """What happened in a step."""
    return m.EventsNews(
        step=request.step,
        attempt=request.attempt,
        time=float(out.time),
        dt=float(out.dt),
        status=out.status,
        budget=_budget(out.budget),
        books=_books(out.books),
        blocked=tuple(map(_blocked, out.blocked)) or None,
        impacts=tuple(map(_impact, out.impacts[: limits.IMPACTS])),
        contacts=tuple(map(_contact, out.contacts)),
    )


def _budget(budget: Any) -> m.Budget:
    return m.Budget(
        limit=budget.limit,
        used=budget.used,
        exhausted=budget.exhausted,
        capped=int(budget.capped) or None,
        fallback=float(budget.fallback) or None,
    )


def _books(books: Any) -> m.Books:
    return m.Books(
        momentum=float(books.momentum),
        angular_momentum=float(books.angular_momentum),
        energy=float(books.energy),
        overlaps=int(books.overlaps),
        overlap_max=float(books.overlap_max),
        impacts=int(books.impacts),
        rest_energy=float(books.rest_energy) or None,
        shift_work=float(books.shift_work) or None,
    )


def _blocked(blocked: Any) -> m.Blocked:
    return m.Blocked(
        time=float(blocked.time),
        bodies=tuple(blocked.bodies),
        contacts=tuple(m.Pair(body_a=a, body_b=b) for a, b in blocked.contacts),
    )


def _impact(impact: Any) -> m.Impact:
    return m.Impact(
        time=float(impact.time),
        body_a=impact.body_a,
        body_b=impact.body_b,
        point=_vector(impact.point),
        normal=_vector(impact.normal),
        impulse=float(impact.impulse),
        approach_speed=float(impact.approach_speed),
        restitution=float(impact.restitution),
        law=impact.law,
        friction=None if impact.friction is None else _vector(impact.friction),
    )


def _contact(contact: Any) -> m.Contact:
    return m.Contact(
        body_a=contact.body_a,
        body_b=contact.body_b,
        impulse=_vector(contact.impulse),
        count=int(contact.count),
        held=_vector(contact.held) if any(contact.held) else None,
    )


def _vector(values: Any) -> m.Vector:
    x, y, z = (float(value) for value in values)
    return (x, y, z)


def _wear(wear: Any) -> m.Wear:
    return m.Wear(
        time=float(wear.time),
        body=wear.body,
        scale=float(wear.scale),
        depth=float(wear.depth),
        mass=float(wear.mass),
        momentum=_vector(wear.momentum),
        angular_momentum=_vector(wear.angular_momentum),
        energy=float(wear.energy),
    )
