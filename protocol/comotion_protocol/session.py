"""Who may say what, and when: the server's side of a session as a table (SPEC, sections S and L).

No threads, no network, no physics. The caller asks `judge_...` what a message calls for, does it, and reports what it
did; a message that is refused or fails changes nothing here. The situation of a message is looked up in `TABLE`, which
is the whole of the rules.
"""

import hmac
import secrets
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from comotion_protocol import limits
from comotion_protocol.blocks import Frame
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.messages import ClientInfo, CloseRequest, StepRequest


class Act(Enum):
    """What a message calls for."""

    GRANT = auto()
    """Give the lease out; whatever step was open is final."""
    ADVANCE = auto()
    """Make the open step final and take the next."""
    REDO = auto()
    """Take the open step again from its beginning."""
    REPEAT = auto()
    """Send the reply of the open step again, bit for bit."""
    RELEASE = auto()
    """Take the lease back."""


@dataclass(frozen=True)
class Refuse:
    """An error reply: code, number of the rule, text."""

    code: str
    rule: str
    text: str


TABLE: Mapping[tuple[str, str], Act | Refuse] = {
    ("open", "lease free"): Act.GRANT,
    ("open", "lease held"): Refuse("lease_held", "L1", "another client holds the lease"),
    ("step", "not the holder"): Refuse("wrong_lease", "L2", "this lease is not held"),
    ("step", "next step"): Act.ADVANCE,
    ("step", "higher attempt"): Act.REDO,
    ("step", "same attempt, same bytes"): Act.REPEAT,
    ("step", "same attempt, other bytes"): Refuse("conflict", "S4", "this step and attempt came with other bytes"),
    ("step", "lower attempt"): Refuse("attempt_passed", "S5", "a higher attempt of this step was accepted"),
    ("step", "other step"): Refuse("wrong_step", "S6", "neither the open step nor the next"),
    ("close", "not the holder"): Refuse("wrong_lease", "L2", "this lease is not held"),
    ("close", "last step"): Act.RELEASE,
    ("close", "other step"): Refuse("wrong_step", "S6", "not the step accepted last"),
}
"""Message and situation: what to do, or how to refuse."""


@dataclass
class Holder:
    """Who holds the lease, since when, and when last heard [s of the session's clock]."""

    lease: str
    client: ClientInfo
    since: float
    heard: float


@dataclass(frozen=True)
class OpenStep:
    """The step that can still be repeated or redone: its request's bytes and its reply."""

    request: tuple[bytes, bytes]
    reply: Frame


class Session:
    """The lease, the step index and the open step of one run."""

    def __init__(
        self,
        idle_time: float = limits.IDLE_TIME,
        clock: Callable[[], float] = time.monotonic,
        new_lease: Callable[[], str] = lambda: secrets.token_hex(16),
    ) -> None:
        self.step = 0
        """Step accepted last; 0 before the first."""
        self.attempt = 0
        """Its attempt accepted last."""
        self._holder: Holder | None = None
        self._open_step: OpenStep | None = None
        self._idle_time = idle_time
        self._clock = clock
        self._new_lease = new_lease
        self._working = False
        self._alive: set[str] = set()
        self._gone: deque[str] = deque(maxlen=1024)

    @property
    def holder(self) -> Holder | None:
        """Who holds the lease; a holder without a token that was silent for too long holds it no more (SPEC L5)."""
        holder = self._holder
        has_token = holder is not None and holder.client.id in self._alive
        waits = has_token or self._working
        if holder is not None and not waits and self._clock() - holder.heard > self._idle_time:
            self._release()
        return self._holder

    def at_work(self, *, working: bool) -> None:
        """A step begins or ends: while it lasts the holder need not be heard (SPEC L5)."""
        self._working = working
        if self._holder is not None:
            self._holder.heard = self._clock()

    def judge_open(self) -> Act:
        """What an open calls for."""
        holder = self.holder
        detail = {} if holder is None else {"holder": holder.client.name}
        return self._look_up("open", "lease free" if holder is None else "lease held", detail)

    def judge_step(self, request: StepRequest, frame: tuple[bytes, bytes]) -> Act:
        """What a step calls for; `frame` are the bytes it came in."""
        detail = {"step": request.step, "attempt": request.attempt, "last": self.step, "last_attempt": self.attempt}
        if not self._hear(request.lease):
            return self._look_up("step", "not the holder", {})
        return self._look_up("step", self._situation(request, frame), detail)

    def judge_close(self, request: CloseRequest) -> Act:
        """What a close calls for."""
        if not self._hear(request.lease):
            return self._look_up("close", "not the holder", {})
        situation = "last step" if request.step == self.step else "other step"
        return self._look_up("close", situation, {"step": request.step, "last": self.step})

    def grant(self, client: ClientInfo) -> str:
        """Give the lease out and return it. The lease of a client that died meanwhile is free again at once (L4)."""
        now = self._clock()
        lease = self._new_lease()
        self._open_step = None
        if client.id is None or client.id not in self._gone:
            self._holder = Holder(lease, client, now, now)
        return lease

    def accept(self, request: StepRequest, frame: tuple[bytes, bytes], reply: Frame) -> None:
        """A step was taken: it is kept even if its asker is gone by now (SPEC L4)."""
        self.step, self.attempt = request.step, request.attempt
        self._open_step = OpenStep(frame, reply) if self._hear(request.lease) else None

    def repeated(self) -> Frame:
        """The reply of the open step."""
        if self._open_step is None:
            raise LookupError("no step is open")
        return self._open_step.reply

    def release(self) -> None:
        """The lease was given back."""
        self._release()

    def client_alive(self, client_id: str, *, alive: bool) -> None:
        """A token came or went; with its token a client loses the lease (SPEC L4)."""
        if alive:
            self._alive.add(client_id)
            if client_id in self._gone:
                self._gone.remove(client_id)
            return
        self._alive.discard(client_id)
        self._gone.append(client_id)
        if self._holder is not None and self._holder.client.id == client_id:
            self._release()

    def _situation(self, request: StepRequest, frame: tuple[bytes, bytes]) -> str:
        if request.step == self.step + 1:
            return "next step"
        if request.step != self.step or self._open_step is None:
            return "other step"
        if request.attempt > self.attempt:
            return "higher attempt"
        if request.attempt < self.attempt:
            return "lower attempt"
        return "same attempt, same bytes" if frame == self._open_step.request else "same attempt, other bytes"

    def _hear(self, lease: str) -> bool:
        """Whether the lease is the holder's; if so, it was heard just now."""
        holder = self.holder
        if holder is None or not hmac.compare_digest(holder.lease.encode(), lease.encode()):
            return False
        holder.heard = self._clock()
        return True

    def _look_up(self, message: str, situation: str, detail: Mapping[str, Any]) -> Act:
        verdict = TABLE[message, situation]
        if isinstance(verdict, Refuse):
            numbers = ", ".join(f"{key} {value}" for key, value in detail.items())
            text = f"{message}: {verdict.text}" + (f" ({numbers})" if numbers else "")
            raise RemoteProtocolError(verdict.code, verdict.rule, text, detail)
        return verdict

    def _release(self) -> None:
        self._holder = None
        self._open_step = None
