"""How a message travels: the interface of a link, and the one that stays in memory.

A client's link asks and waits. On the server's side every request arrives at a `Host` as a `Question`, which is
answered exactly once, from any thread. Headers and bulk are bytes on both sides, so that a test over memory runs the
whole codec.
"""

import secrets
import threading
from typing import Protocol

from comotion_protocol.blocks import Frame
from comotion_protocol.errors import PeerAbsentError


class Question(Protocol):
    """A request that waits for its answer."""

    @property
    def message(self) -> str:
        """`open`, `step`, `close` or `status`."""

    def frame(self) -> tuple[bytes, bytes]:
        """Header and bulk as they came; the bulk is copied out here and not before."""

    def reply(self, frame: Frame) -> None:
        """Answer."""

    def refuse(self, error: bytes) -> None:
        """Answer with an error reply."""


class Host(Protocol):
    """What stands behind a link on the server's side. Neither call may block."""

    def receive(self, question: Question) -> None:
        """Take a request."""

    def client_alive(self, client_id: str, *, alive: bool) -> None:
        """A client's liveliness token came or went."""


class Audience(Protocol):
    """Those who watch a server (SPEC, section W)."""

    def listens(self, news: str) -> bool:
        """Whether someone subscribes to a kind of news just now; cheap enough to ask at every step."""

    def publish(self, news: str, frame: Frame) -> None:
        """Tell them; never waits for a slow one."""


class Link(Protocol):
    """A client's way to its server."""

    @property
    def client_id(self) -> str:
        """Names the liveliness token that this link holds up while it is open."""

    def ask(self, message: str, frame: Frame, timeout: float | None) -> tuple[bool, bytes, bytes]:
        """Send a request; return (accepted, header, bulk), the header being the error map if not accepted.

        Raises PeerAbsentError when nobody answers within `timeout` [s] (None: as long as the server is alive).
        """

    def close(self) -> None:
        """Give the token and the connection back; may be called twice."""


class _MemoryQuestion:
    """A request on its way through memory."""

    def __init__(self, message: str, header: bytes, bulk: bytes) -> None:
        self.message = message
        self._frame = (header, bulk)
        self._answered = threading.Event()
        self.answer: tuple[bool, bytes, bytes] = (False, b"", b"")

    def frame(self) -> tuple[bytes, bytes]:
        return self._frame

    def reply(self, frame: Frame) -> None:
        self.answer = (True, frame.header, bytes(frame.bulk()))
        self._answered.set()

    def refuse(self, error: bytes) -> None:
        self.answer = (False, error, b"")
        self._answered.set()

    def wait(self, timeout: float | None) -> bool:
        return self._answered.wait(timeout)


class MemoryLink:
    """A link to a host in the same process."""

    def __init__(self, host: Host) -> None:
        self._host = host
        self._open = True
        self.client_id = secrets.token_hex(8)
        host.client_alive(self.client_id, alive=True)

    def ask(self, message: str, frame: Frame, timeout: float | None) -> tuple[bool, bytes, bytes]:
        """See `Link.ask`."""
        if not self._open:
            raise PeerAbsentError("link_closed", "Z6", "the link to the server is closed")
        question = _MemoryQuestion(message, frame.header, bytes(frame.bulk()))
        self._host.receive(question)
        if not question.wait(timeout):
            raise PeerAbsentError("no_reply", "Z7", f"no reply to {message!r} within {timeout} s")
        return question.answer

    def close(self) -> None:
        """See `Link.close`."""
        if self._open:
            self._open = False
            self._host.client_alive(self.client_id, alive=False)
