"""A blocking client: what a CFD adapter calls once per step.

Example::

    with MotionClient.open(run="channel") as motion:
        reply = motion.step(0.005, {"ice": forces})
        reply.vertices["ice"]
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from comotion_protocol import codec, limits
from comotion_protocol.errors import LocalProtocolError, ProtocolError
from comotion_protocol.link import Link
from comotion_protocol.messages import (
    ClientInfo,
    CloseReply,
    CloseRequest,
    FloatArray,
    IndexArray,
    OpenReply,
    OpenRequest,
    PlanLine,
    Region,
    Request,
    StatusReply,
    StatusRequest,
    StepReply,
    StepRequest,
    Sums,
    Wants,
)

OPEN_TIMEOUT = 60.0
"""Patience with an open [s]: it may have to wait for the last step of a holder that died."""

STATUS_TIMEOUT = 5.0
"""Patience with a status [s]: it never waits for a step."""

_T = TypeVar("_T")


class MotionClient:
    """One client's session with a motion server. For one thread at a time; only `status` may be called from another."""

    def __init__(self, link: Link, opened: OpenReply, wants: Wants) -> None:
        self._link = link
        self._step = opened.step - 1
        self._attempt = 0
        self._closed = False
        self._wants = wants
        self.opened = opened
        """The open reply."""

    @classmethod
    def open(
        cls,
        run: str,
        connect: str | None = None,
        *,
        wants: Wants | None = None,
        dt: float | None = None,
        digest: str | None = None,
        name: str = "python",
        connect_timeout: float = 5.0,
        zenoh_config: str | Path | None = None,
        allow_insecure: bool = False,
        shared_memory: bool = True,
        link: Link | None = None,
    ) -> Self:
        """Connect to the server of `run` and take the lease.

        Args:
            run: name of the run.
            connect: the server's endpoint; tcp/127.0.0.1:7447 unless given here or in `zenoh_config`.
            wants: what every reply should carry; vertices at the end of the step unless told otherwise.
            dt: size of the first step [s]; needed for the midpoint sample.
            digest: refuse to open unless the server has the surfaces with this digest.
            name: of the program that asks, for status and messages.
            connect_timeout: how long to wait for a server to be there [s].
            zenoh_config: zenoh's own configuration file, for TLS and the like.
            allow_insecure: permit an endpoint beyond this machine without TLS.
            shared_memory: use it for large arrays when the server is on this machine.
            link: another way than zenoh, such as a `MemoryLink`.

        Raises:
            PeerAbsentError: no server.
            LocalProtocolError: the server refuses, or what was asked for is wrong.
        """
        if link is None:
            from comotion_protocol.zenoh_link import ZenohLink

            link = ZenohLink(
                run,
                connect,
                timeout=connect_timeout,
                zenoh_config=zenoh_config,
                allow_insecure=allow_insecure,
                shared_memory=shared_memory,
            )
        wants = wants or Wants()
        request = OpenRequest(
            client=ClientInfo(name=name, version=metadata.version("comotion"), id=link.client_id),
            protocol=limits.PROTOCOL,
            wants=wants,
            dt=None if dt is None else float(dt),
            digest=digest,
        )
        try:
            return cls(link, _exchange(link, "open", request, codec.decode_open_reply, OPEN_TIMEOUT), wants)
        except BaseException:
            link.close()
            raise

    @property
    def regions(self) -> tuple[Region, ...]:
        """The surfaces, in the order of their names."""
        return self.opened.regions

    @property
    def plan(self) -> tuple[PlanLine, ...]:
        """What the server's step runs and leaves out, and why."""
        return self.opened.plan

    @property
    def units(self) -> Mapping[str, str]:
        """Units of all quantities."""
        return self.opened.units

    @property
    def vertices(self) -> Mapping[str, FloatArray]:
        """Vertices [m] of the open reply, (vertex_count, 3) per region: where the forces of the first step act."""
        return self.opened.vertices

    @property
    def triangles(self) -> Mapping[str, IndexArray]:
        """Triangles of the open reply, (triangle_count, 3) per region: indices into its vertices."""
        return self.opened.triangles

    def step(
        self,
        dt: float,
        forces: Mapping[str, ArrayLike] | None = None,
        *,
        wrenches: ArrayLike | None = None,
        dt_next: float | None = None,
        sums: Sums | None = None,
    ) -> StepReply:
        """Advance by dt [s] and wait for the reply, however long it takes.

        Args:
            dt: step size [s].
            forces: per region (vertex_count, 3) [N] at the vertices last received; a region left out has none.
            wrenches: instead of forces: (bodies, 6) [N, N m] about the centres of mass last received.
            dt_next: size of the step after this one [s], for the midpoint sample; the same dt unless given.
            sums: what the server should find; it refuses the step if it does not.

        Raises:
            LocalProtocolError: the server refuses; its state is as before.
            PeerAbsentError: the server is gone.
        """
        return self._advance(self._step + 1, 0, dt, forces, wrenches, dt_next, sums)

    def redo(
        self,
        dt: float,
        forces: Mapping[str, ArrayLike] | None = None,
        *,
        wrenches: ArrayLike | None = None,
        dt_next: float | None = None,
        sums: Sums | None = None,
    ) -> StepReply:
        """Take the last step again from its beginning, with other forces or another dt; arguments as for `step`."""
        return self._advance(max(self._step, 0), self._attempt + 1, dt, forces, wrenches, dt_next, sums)

    def status(self, timeout: float = STATUS_TIMEOUT) -> StatusReply:
        """What the server does just now; answered during a long step, too."""
        return _exchange(self._link, "status", StatusRequest(), codec.decode_status_reply, timeout)

    def close(self) -> CloseReply | None:
        """Give the lease back and close the link; None if that was done before."""
        if self._closed:
            return None
        self._closed = True
        try:
            request = CloseRequest(lease=self.opened.lease, step=self._step)
            return _exchange(self._link, "close", request, codec.decode_close_reply, OPEN_TIMEOUT)
        finally:
            self._link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
        else:  # the lease falls free with the token; the error that ended the block is the one to be seen
            self._closed = True
            self._link.close()

    def _advance(
        self,
        step: int,
        attempt: int,
        dt: float,
        forces: Mapping[str, ArrayLike] | None,
        wrenches: ArrayLike | None,
        dt_next: float | None,
        sums: Sums | None,
    ) -> StepReply:
        request = StepRequest(
            lease=self.opened.lease,
            step=step,
            attempt=attempt,
            dt=float(dt),
            dt_next=None if dt_next is None else float(dt_next),
            sums=sums,
            forces={name: _array(f"forces of {name!r}", array) for name, array in (forces or {}).items()},
            wrenches=None if wrenches is None else _array("wrenches", wrenches),
        )
        reply = _exchange(self._link, "step", request, codec.decode_step_reply, None)
        self._step, self._attempt = step, attempt
        return self._with_still_regions(reply)

    def _with_still_regions(self, reply: StepReply) -> StepReply:
        """Add the regions that never move: they came with the open reply and are not sent again (SPEC M8)."""
        still = [region.name for region in self.regions if not region.moves]
        vertices, velocities = dict(reply.vertices), dict(reply.velocities)
        if self._wants.vertices:
            vertices |= {name: self.opened.vertices[name] for name in still}
        if self._wants.velocities:
            velocities |= {name: self.opened.velocities[name] for name in still}
        return replace(reply, vertices=vertices, velocities=velocities) if still else reply


def _array(what: str, values: ArrayLike) -> FloatArray:
    """Contiguous doubles in rows; anything else is the caller's fault (SPEC B4, B5)."""
    try:
        array = np.ascontiguousarray(values, dtype="<f8")
    except (TypeError, ValueError) as error:
        raise LocalProtocolError("wrong_type", "B4", f"{what}: expected numbers, got {error}") from None
    if array.ndim != 2:
        raise LocalProtocolError("wrong_shape", "B5", f"{what}: expected rows of numbers, got shape {array.shape}")
    return array


def _exchange(
    link: Link, message: str, request: Request, decode: Callable[[bytes, bytes], _T], timeout: float | None
) -> _T:
    """Ask and decode; an error reply becomes an exception."""
    accepted, header, bulk = link.ask(message, codec.encode_request(request), timeout)
    if not accepted:
        error: ProtocolError = codec.decode_error(header)
        raise error
    return decode(header, bulk)
