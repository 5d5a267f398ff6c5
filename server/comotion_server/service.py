"""The service: bytes in, bytes out. A request is decoded, judged by the session, done by the simulation, and answered.

One worker at a time calls `handle` for open, step, close and look, and `tell` (see `Desk`); for status, `refuse_open`
and the coming and going of clients any thread may call, at any time. A request that is refused or fails leaves
everything as it was.
"""

import secrets
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import metadata
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion_protocol import codec, limits
from comotion_protocol import messages as m
from comotion_protocol.blocks import Frame
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.keys import check_run
from comotion_protocol.link import Audience
from comotion_protocol.session import Act, Session
from comotion_server.engine import Engine, EngineSample
from comotion_server.replies import (
    events_news,
    motion_arrays,
    plan_lines,
    scales_told,
    state_news,
    step_reply,
    sums_found,
)
from comotion_server.step_input import check_dt, check_step, check_sums
from comotion_server.surfaces import Surface, surface_digest, surfaces_of


@dataclass(frozen=True)
class View:
    """What the present client sees: its wants, the surfaces in its indexing, and the sample its forces act on."""

    wants: m.Wants
    surfaces: dict[str, Surface]
    sent: EngineSample


@dataclass(frozen=True)
class Beginning:
    """What a step that is taken again starts from."""

    checkpoint: Any
    sent: EngineSample


class Service:
    """One run of a simulation, as the protocol sees it."""

    def __init__(
        self,
        engine: Engine,
        run: str,
        idle_time: float = limits.IDLE_TIME,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.run = check_run(run)
        self.info = m.ServerInfo(name="comotion", version=metadata.version("comotion"), instance=_new_instance())
        self._engine = engine
        self._rows = _rows_with_surface(engine)
        self._idle_time = idle_time
        self._digest = surface_digest(engine.regions, engine.sample(0.0).vertices)
        self._view: View | None = None
        self._beginning: Beginning | None = None
        self._audience: Audience | None = None
        self._untold: tuple[m.StepRequest, Any] | None = None
        # What other threads see, under the lock.
        self._lock = threading.Lock()
        self._clock = clock
        self._session = Session(idle_time, clock)
        self._computing = False
        self._phase: tuple[Any, float] = ("free", clock())
        self._busy = 0.0
        self._time = engine.time

    def handle(self, message: str, header: bytes, bulk: bytes) -> Frame:
        """Answer a request, or raise: ProtocolError for a refusal, anything else for a fault of ours."""
        request = codec.decode_request(message, header, bulk)
        match request:
            case m.OpenRequest():
                return self._open(request)
            case m.StepRequest():
                return self._step(request, (header, bulk))
            case m.CloseRequest():
                return self._close(request)
            case m.StatusRequest():
                return codec.encode_reply(self.status())
            case m.LookRequest():
                return self._look()

    def meet(self, audience: Audience) -> None:
        """From now on tell these what goes on, as far as they listen (SPEC, section W)."""
        self._audience = audience

    def tell(self) -> None:
        """Tell the audience how things are, and once of the step accepted last; in the worker, after an answer."""
        self._tell_progress()
        untold, self._untold = self._untold, None
        audience = self._audience
        if untold is None or audience is None:
            return
        request, out = untold
        if audience.listens("state"):
            sample = self._engine.sample(0.0, vertices=False)
            audience.publish("state", codec.encode_news(state_news(request, out, sample, self._rows)))
        if audience.listens("events"):
            audience.publish("events", codec.encode_news(events_news(request, out)))

    def _tell_progress(self) -> None:
        if self._audience is not None and self._audience.listens("progress"):
            self._audience.publish("progress", codec.encode_news(self.status()))

    def _look(self) -> Frame:
        """The surfaces as they are (SPEC W1)."""
        surfaces = surfaces_of(self._engine.regions, "welded")
        sample = self._engine.sample(0.0)
        with self._lock:
            step, attempt = self._session.step, self._session.attempt
        return codec.encode_reply(
            m.LookReply(
                protocol=limits.PROTOCOL,
                server=self.info,
                run=self.run,
                step=step,
                attempt=attempt,
                time=float(sample.time),
                regions=tuple(surface.describe() for surface in surfaces.values()),
                digest=self._digest,
                vertices={name: surface.send(sample.vertices[name]) for name, surface in surfaces.items()},
                triangles={name: surface.triangles for name, surface in surfaces.items()},
                poses=np.ascontiguousarray(sample.poses[self._rows]),
                scales=scales_told(sample, self._rows),
            )
        )

    def refuse_open(self) -> None:
        """Raise ProtocolError if an open would be refused now: nobody should wait for a step to hear that."""
        with self._lock:
            self._session.judge_open()

    def client_alive(self, client_id: str, *, alive: bool) -> None:
        """A client's liveliness token came or went (SPEC L4)."""
        with self._lock:
            self._session.client_alive(client_id, alive=alive)

    def status(self) -> m.StatusReply:
        """What goes on now (SPEC M11, S8)."""
        with self._lock:
            now = self._clock()
            phase, since = self._phase_now(now)
            holder = self._session.holder
            return m.StatusReply(
                protocol=limits.PROTOCOL,
                server=self.info,
                run=self.run,
                phase=phase,
                phase_seconds=now - since,
                step=self._session.step,
                attempt=self._session.attempt,
                time=self._time,
                busy=self._busy + (now - since if phase == "computing" else 0.0),
                client=None if holder is None else holder.client,
                held_seconds=None if holder is None else now - holder.since,
            )

    def _open(self, request: m.OpenRequest) -> Frame:
        """Give the lease out and send the surfaces (SPEC M1). The step before is final from now on (SPEC S7)."""
        self.refuse_open()
        if request.digest is not None and request.digest != self._digest:
            text = f"digest: the server's surfaces have {self._digest}, the client's {request.digest}"
            raise RemoteProtocolError("digest_mismatch", "M7", text, {"expected": self._digest})
        if request.dt is None and request.wants.sample == "midpoint":
            raise RemoteProtocolError("missing", "M6", "dt is missing: the midpoint sample needs it", {"field": "dt"})
        dt = 0.0 if request.dt is None else check_dt("dt", request.dt)
        surfaces = surfaces_of(self._engine.regions, request.wants.indexing)
        with self._at_work():
            sample = self._sample(request.wants, dt, vertices=True)
        self._engine.mark_sent(sample)
        self._view, self._beginning = View(request.wants, surfaces, sample), None
        with self._lock:
            lease = self._session.grant(request.client)
            step = self._session.step + 1
        return codec.encode_reply(
            m.OpenReply(
                protocol=limits.PROTOCOL,
                server=self.info,
                run=self.run,
                lease=lease,
                step=step,
                time=float(self._engine.time),
                sample_time=float(sample.time),
                units=m.UNITS,
                regions=tuple(surface.describe() for surface in surfaces.values()),
                digest=self._digest,
                plan=plan_lines(self._engine.plan),
                limits=m.Limits(
                    header_bytes=limits.REQUEST_HEADER_BYTES,
                    bulk_bytes=limits.BULK_BYTES,
                    blocks=limits.BLOCKS,
                    idle_time=self._idle_time,
                ),
                vertices={name: surface.send(sample.vertices[name]) for name, surface in surfaces.items()},
                triangles={name: surface.triangles for name, surface in surfaces.items()},
                **motion_arrays(sample, request.wants, surfaces, self._rows),
            )
        )

    def _step(self, request: m.StepRequest, frame: tuple[bytes, bytes]) -> Frame:
        """Advance, take a step again, or answer from memory (SPEC, section S)."""
        with self._lock:
            act = self._session.judge_step(request, frame)
            if act is Act.REPEAT:
                return self._session.repeated()
        view = self._view
        if view is None:
            raise LookupError("a step was judged to be due before any open")
        check_step(request, view.surfaces, len(self._rows))
        before = self._engine.checkpoint()
        beginning = self._beginning if act is Act.REDO and self._beginning else Beginning(before, view.sent)
        try:
            with self._at_work():
                reply, sample, out = self._advance(request, view, beginning)
        except Exception as error:
            self._engine.restore(before)
            if isinstance(error, ValueError):  # the simulation's word for input that it cannot use
                raise RemoteProtocolError("bad_step", "F8", str(error)) from error
            raise
        self._view, self._beginning = replace(view, sent=sample), beginning
        with self._lock:
            self._time = float(self._engine.time)
            self._session.accept(request, frame, reply)
        self._untold = (request, out)
        return reply

    def _advance(self, request: m.StepRequest, view: View, beginning: Beginning) -> tuple[Frame, EngineSample, Any]:
        """Take the step from its beginning; the reply, the sample in it, where the next forces act, and the result."""
        self._engine.restore(beginning.checkpoint)
        forces = {name: view.surfaces[name].receive(array) for name, array in request.forces.items()}
        if request.wrenches is None:
            out = self._engine.step(request.dt, forces=forces)
        else:
            wrenches = np.zeros((len(self._engine.bodies.names), 6))
            wrenches[self._rows] = request.wrenches
            out = self._engine.step(request.dt, wrenches=wrenches)
        if request.sums is not None:
            check_sums(request, sums_found(out), self._reach(beginning.sent))
        sample = self._sample(view.wants, request.dt_next or request.dt, vertices=view.wants.vertices)
        self._engine.mark_sent(sample)
        reply = codec.encode_reply(step_reply(request, out, sample, view.wants, view.surfaces, self._rows))
        return reply, sample, out

    def _sample(self, wants: m.Wants, dt: float, *, vertices: bool) -> Any:
        """Where everything is now, or will be in the middle of the next step of dt [s] (SPEC M4)."""
        offset = 0.5 * dt if wants.sample == "midpoint" else 0.0
        return self._engine.sample(offset, vertices=vertices, velocities=wants.velocities)

    def _reach(self, sent: EngineSample) -> float:
        """Largest distance [m] from the world origin at which a force of this step may act."""
        vertices = sent.vertices or self._engine.sample(0.0).vertices
        points = [*vertices.values(), sent.poses[:, :3]]
        return max(float(np.abs(rows).max(initial=0.0)) for rows in points) * float(np.sqrt(3.0))

    def _close(self, request: m.CloseRequest) -> Frame:
        """Take the lease back (SPEC L6)."""
        with self._lock:
            self._session.judge_close(request)
            self._session.release()
            return codec.encode_reply(m.CloseReply(steps=self._session.step, time=self._time))

    @contextmanager
    def _at_work(self) -> Iterator[None]:
        """While the simulation computes: status shows it and counts the time."""
        self._set_computing(computing=True)
        self._tell_progress()
        started = self._clock()
        try:
            yield
        finally:
            self._busy += self._clock() - started
            self._set_computing(computing=False)

    def _set_computing(self, *, computing: bool) -> None:
        with self._lock:
            self._computing = computing
            self._session.at_work(working=computing)
            self._phase_now(self._clock())

    def _phase_now(self, now: float) -> tuple[Any, float]:
        """The phase, and since when."""
        held = self._session.holder is not None
        phase = "computing" if self._computing else "idle" if held else "free"
        if phase != self._phase[0]:
            self._phase = (phase, now)
        return self._phase


def _rows_with_surface(engine: Engine) -> NDArray[np.intp]:
    """Rows of the bodies that a client knows: those that are in a region, in the order of their names (SPEC M12)."""
    known = {body.name for region in engine.regions for body in region.bodies}
    return np.array([row for row, name in enumerate(engine.bodies.names) if name in known], dtype=np.intp)


def _new_instance() -> str:
    """A name for this start of the server, by which the older of two goes first (SPEC Z8)."""
    return f"{time.time_ns():016x}{secrets.token_hex(4)}"
