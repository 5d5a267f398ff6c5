"""The messages of the protocol as frozen dataclasses (SPEC, section M). No bytes, no network, no physics.

SI units throughout; vectors are (x, y, z) in the world frame; arrays are C-contiguous float64 or uint32.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
IndexArray: TypeAlias = NDArray[np.uint32]
Vector: TypeAlias = tuple[float, float, float]

UNITS: Mapping[str, str] = {
    "length": "m",
    "mass": "kg",
    "time": "s",
    "velocity": "m/s",
    "angular_velocity": "rad/s",
    "force": "N",
    "moment": "N m",
    "impulse": "N s",
}
"""The units of every message (SPEC M3)."""


@dataclass(frozen=True, kw_only=True)
class Wants:
    """What a client asks for in every reply, and where its forces act (SPEC M4, M5)."""

    vertices: bool = True
    poses: bool = False
    twists: bool = False
    velocities: bool = False
    impacts: bool = False
    contacts: bool = False
    sample: Literal["end", "midpoint"] = "end"
    indexing: Literal["welded", "facets"] = "welded"


@dataclass(frozen=True, kw_only=True)
class ClientInfo:
    """Who asks. `id` names the client's liveliness token; it is no secret."""

    name: str
    version: str
    id: str | None = None


@dataclass(frozen=True, kw_only=True)
class ServerInfo:
    """Who answers. `instance` is drawn anew whenever a server starts."""

    name: str
    version: str
    instance: str


@dataclass(frozen=True, kw_only=True)
class RegionBody:
    """A body's share of its region's vertices: `vertex_count` of them from `first_vertex` on."""

    name: str
    first_vertex: int
    vertex_count: int


@dataclass(frozen=True, kw_only=True)
class Region:
    """A surface that forces act on: bodies in the order of their names. One that never moves is sent once, at open."""

    name: str
    vertex_count: int
    triangle_count: int
    moves: bool = True
    bodies: tuple[RegionBody, ...]


@dataclass(frozen=True, kw_only=True)
class PlanLine:
    """One stage of the server's step: whether it runs, and why."""

    stage: str
    kept: bool
    reason: str


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What this server takes; `idle_time` [s] is the patience with a silent holder that has no token."""

    header_bytes: int
    bulk_bytes: int
    blocks: int
    idle_time: float


@dataclass(frozen=True, kw_only=True)
class Sums:
    """Sum of all forces [N] and of their moments about the world origin [N m]."""

    force: Vector
    moment: Vector


@dataclass(frozen=True, kw_only=True)
class Budget:
    """Work bound of a step: responses allowed and used; exhausted means that the rest was held.

    `capped` impacts did not end and were answered without rebound; contacts were held by time-stepping in a share
    `fallback` of the step. Both are left out where there is nothing to tell.
    """

    limit: int
    used: int
    exhausted: bool
    capped: int | None = None
    fallback: float | None = None


@dataclass(frozen=True, kw_only=True)
class Books:
    """How well the step's impacts closed their books: worst relative errors, overlaps met and the largest one [m].

    `rest_energy` [J] was taken by contacts that came to rest, `shift_work` [J] done to keep held ones at their gap.
    """

    momentum: float
    angular_momentum: float
    energy: float
    overlaps: int
    overlap_max: float
    impacts: int
    rest_energy: float | None = None
    shift_work: float | None = None


@dataclass(frozen=True, kw_only=True)
class Impact:
    """One impact: `impulse` [N s] along `normal` and `friction` [N s] act on body_b, their opposites on body_a."""

    time: float
    body_a: str
    body_b: str
    point: Vector
    normal: Vector
    impulse: float
    approach_speed: float
    restitution: float
    law: str
    friction: Vector | None = None


@dataclass(frozen=True, kw_only=True)
class Contact:
    """All that a pair exchanged over the step: `impulse` [N s] on body_b, in `count` impacts and by held contacts.

    `held` is the share of the latter, left out where there was none.
    """

    body_a: str
    body_b: str
    impulse: Vector
    count: int
    held: Vector | None = None


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two bodies, in the order of their names."""

    body_a: str
    body_b: str


@dataclass(frozen=True, kw_only=True)
class Blocked:
    """Bodies kept in place from `time` [s] to the step's end, for their `contacts` leave no motion (SPEC M13)."""

    time: float
    bodies: tuple[str, ...]
    contacts: tuple[Pair, ...]


@dataclass(frozen=True, kw_only=True)
class Wear:
    """A body that was scaled down because it was pinched, and what went with the mass it lost (SPEC M14)."""

    time: float
    body: str
    scale: float
    depth: float
    mass: float
    momentum: Vector
    angular_momentum: Vector
    energy: float


@dataclass(frozen=True, kw_only=True)
class OpenRequest:
    """Ask for the lease (SPEC M6). `dt` [s] of the first step is needed for the midpoint sample."""

    client: ClientInfo
    protocol: tuple[int, int]
    wants: Wants = field(default_factory=Wants)
    dt: float | None = None
    digest: str | None = None
    resume: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class OpenReply:
    """The lease, the run, its surfaces and the first sample (SPEC M1).

    Per region: vertices [m] (vertex_count, 3) and triangles (triangle_count, 3), indices into them.
    """

    protocol: tuple[int, int]
    server: ServerInfo
    run: str
    lease: str
    step: int
    time: float
    sample_time: float
    units: Mapping[str, str]
    regions: tuple[Region, ...]
    digest: str
    plan: tuple[PlanLine, ...]
    limits: Limits
    vertices: Mapping[str, FloatArray]
    triangles: Mapping[str, IndexArray]
    velocities: Mapping[str, FloatArray] = field(default_factory=dict)
    poses: FloatArray | None = None
    twists: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class StepRequest:
    """Advance by dt [s] under forces (SPEC, section F).

    forces: per region (vertex_count, 3) [N] at the vertices last sent; or wrenches (bodies, 6): force [N] and moment
    [N m] about the centre of mass last sent. Neither means none.
    """

    lease: str
    step: int
    attempt: int
    dt: float
    dt_next: float | None = None
    sums: Sums | None = None
    forces: Mapping[str, FloatArray] = field(default_factory=dict)
    wrenches: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class StepReply:
    """Where everything is after the step (SPEC M8); nothing in it depends on the clock on the wall.

    vertices [m] and velocities [m/s]: per region (vertex_count, 3); poses (bodies, 7): x y z w qx qy qz; twists
    (bodies, 6): velocity [m/s] and angular velocity [rad/s]. All hold at `sample_time` [s]; `time` is the step's end.
    """

    step: int
    attempt: int
    time: float
    dt: float
    sample_time: float
    status: Literal["ok", "blocked"]
    sums: Sums
    budget: Budget
    books: Books
    dt_advice: float | None = None
    blocked: tuple[Blocked, ...] | None = None
    impacts: tuple[Impact, ...] | None = None
    contacts: tuple[Contact, ...] | None = None
    wear: tuple[Wear, ...] | None = None
    vertices: Mapping[str, FloatArray] = field(default_factory=dict)
    velocities: Mapping[str, FloatArray] = field(default_factory=dict)
    poses: FloatArray | None = None
    twists: FloatArray | None = None


@dataclass(frozen=True, kw_only=True)
class CloseRequest:
    """Give the lease back (SPEC L6); `step` is the last one accepted."""

    lease: str
    step: int


@dataclass(frozen=True, kw_only=True)
class CloseReply:
    """Steps accepted by the run so far, and its time in seconds."""

    steps: int
    time: float


@dataclass(frozen=True, kw_only=True)
class StatusRequest:
    """Ask what the server does (SPEC S8); there is nothing in it, and anyone may ask."""


@dataclass(frozen=True, kw_only=True)
class StatusReply:
    """What the server does just now (SPEC M11). Durations in seconds of the server's clock."""

    protocol: tuple[int, int]
    server: ServerInfo
    run: str
    phase: Literal["free", "idle", "computing"]
    phase_seconds: float
    step: int
    attempt: int
    time: float
    busy: float
    client: ClientInfo | None = None
    held_seconds: float | None = None


@dataclass(frozen=True, kw_only=True)
class LookRequest:
    """Ask for the surfaces without taking the lease (SPEC W1); there is nothing in it, and anyone may ask."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LookReply:
    """The surfaces of a run as they are at `time` [s], after `step` (SPEC W1); welded, in the order of the open reply.

    Per region: vertices [m] (vertex_count, 3) and triangles (triangle_count, 3); poses (bodies, 7): x y z w qx qy qz;
    scales (bodies, 1), None where all are 1 (W7).
    """

    protocol: tuple[int, int]
    server: ServerInfo
    run: str
    step: int
    attempt: int
    time: float
    regions: tuple[Region, ...]
    digest: str
    vertices: Mapping[str, FloatArray]
    triangles: Mapping[str, IndexArray]
    poses: FloatArray
    scales: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class StateNews:
    """Where the bodies are at the end of a step (SPEC W3): poses (bodies, 7), twists (bodies, 6), scales as in look."""

    step: int
    attempt: int
    time: float
    poses: FloatArray
    twists: FloatArray
    scales: FloatArray | None = None


@dataclass(frozen=True, kw_only=True)
class EventsNews:
    """What happened in a step (SPEC W4), as its reply tells it to a client that wants all of it."""

    step: int
    attempt: int
    time: float
    dt: float
    status: Literal["ok", "blocked"]
    budget: Budget
    books: Books
    impacts: tuple[Impact, ...]
    contacts: tuple[Contact, ...]
    blocked: tuple[Blocked, ...] | None = None


Request: TypeAlias = OpenRequest | StepRequest | CloseRequest | StatusRequest | LookRequest
Reply: TypeAlias = OpenReply | StepReply | CloseReply | StatusReply | LookReply
News: TypeAlias = StateNews | EventsNews | StatusReply
"""What is published: state, events, and as progress the same words as a reply to status (SPEC W5)."""
