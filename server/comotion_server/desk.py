"""The desk between links and the service: one worker thread computes, another answers what must not wait for it.

`receive` only sorts requests into two queues, so that a link's callback never blocks. Open, step and close go through
the worker in the order they came. Status is answered at once, and so is an open that would be refused (SPEC S8, S9).
"""

import logging
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Self

from comotion_protocol import limits
from comotion_protocol.codec import encode_error
from comotion_protocol.errors import ProtocolError, RemoteProtocolError
from comotion_protocol.link import Question
from comotion_server.service import Service

log = logging.getLogger(__name__)

STOP_TIME = 1.0
"""Patience at the end with a step that still runs [s]; its thread is left behind then."""


class Desk:
    """Takes requests from links, has the service answer them. A context manager: threads run inside."""

    def __init__(self, service: Service, waiting_most: int = limits.WAITING) -> None:
        self._service = service
        self._waiting_most = waiting_most
        self._stopping = False
        self._front: SimpleQueue[Question | None] = SimpleQueue()
        self._work: SimpleQueue[Question | None] = SimpleQueue()
        self._threads = (
            threading.Thread(target=self._answer_front, name="comotion front", daemon=True),
            threading.Thread(target=self._answer_work, name="comotion worker", daemon=True),
        )

    def receive(self, question: Question) -> None:
        """Take a request; never blocks."""
        (self._front if question.message in {"status", "open"} or self._is_full() else self._work).put(question)

    def client_alive(self, client_id: str, *, alive: bool) -> None:
        """A client's liveliness token came or went."""
        self._service.client_alive(client_id, alive=alive)

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Refuse what waits and end the threads; a step that still runs is waited for only shortly."""
        self._stopping = True
        for queue in (self._front, self._work):
            queue.put(None)
        for thread in self._threads:
            thread.join(STOP_TIME)

    @property
    def waiting(self) -> int:
        """Requests that wait for the worker now."""
        return self._work.qsize()

    def _is_full(self) -> bool:
        return self.waiting >= self._waiting_most

    def _answer_front(self) -> None:
        while (question := self._front.get()) is not None:
            try:
                self._sort(question)
            except ProtocolError as error:
                _refuse(question, error)
            del question  # zenoh ends a query only when nobody holds it any longer

    def _sort(self, question: Question) -> None:
        """Answer here, or pass on to the worker."""
        if question.message == "status":
            self._answer(question)
        elif self._is_full():
            text = f"{self._waiting_most} requests wait already"
            raise RemoteProtocolError("busy", "S9", text, {"waiting": self._waiting_most})
        else:
            self._service.refuse_open()
            self._work.put(question)

    def _answer_work(self) -> None:
        while (question := self._work.get()) is not None:
            self._answer(question)
            del question
            _deliver(self._service.tell)

    def _answer(self, question: Question) -> None:
        """Every request gets exactly one answer, whatever goes wrong (SPEC E5)."""
        if self._stopping:
            _refuse(question, RemoteProtocolError("stopping", "E5", "the server shuts down"))
            return
        try:
            frame = self._service.handle(question.message, *question.frame())
        except ProtocolError as error:
            _refuse(question, error)
        except Exception as error:
            log.exception("a request failed")
            text = f"{question.message} failed: {type(error).__name__}: {error}"
            _refuse(question, RemoteProtocolError("failed", "E5", text))
        else:
            _deliver(lambda: question.reply(frame))


def _refuse(question: Question, error: ProtocolError) -> None:
    _deliver(lambda: question.refuse(encode_error(error)))


def _deliver(send: Callable[[], None]) -> None:
    """Send an answer or news; who is gone by now does not hear it, and that is all."""
    try:
        send()
    except Exception:  # any link's own error
        log.warning("an answer or news could not be delivered", exc_info=True)
