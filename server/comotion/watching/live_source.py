"""A running server as the page sees it: subscribed only while a page is open."""

import threading
from collections import deque
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.body_shapes import body_shapes
from comotion.outputs.surface import Surface
from comotion.watching.page_message import page_message
from comotion.watching.scene_message import scene_message
from comotion_protocol.messages import EventsNews, StateNews, StatusReply
from comotion_protocol.watch_client import WatchClient

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

IMPACTS_KEPT = 200  # the newest ones between two messages


class LiveSource:
    """Gathers news; `messages` gives what a page has not seen."""

    def __init__(self, client: WatchClient) -> None:
        self._client = client
        self._lock = threading.Lock()
        self._listening: AbstractContextManager[None] | None = None
        self._pages = 0
        self._clear()

    def enter(self) -> list[bytes]:
        """A page opens: its first messages."""
        look, status = self._client.look(), self._client.status()
        with self._lock:
            self._pages += 1
            if self._listening is None:
                self._clear()
                self._listening = self._client.listening(
                    {"state": self._take_state, "events": self._take_events, "progress": self._take_progress}
                )
                self._listening.__enter__()
        shapes = body_shapes(Surface(look.regions, look.vertices, look.triangles), look.poses, look.scales)
        still = {body.name: "fixed" for region in look.regions if not region.moves for body in region.bodies}
        state = {"kind": "state", "step": look.step, "time": look.time, "impacts": [], "count": 0}
        return [
            scene_message(look.run, "live", shapes, still, None),
            page_message(state, {"poses": look.poses} | _scales(look.scales)),
            _progress_message(status),
        ]

    def leave(self) -> None:
        """A page closes; the last one ends the subscriptions."""
        with self._lock:
            self._pages -= 1
            ending = self._listening if self._pages == 0 else None
            if ending is not None:
                self._listening = None
        if ending is not None:
            ending.__exit__(None, None, None)

    def messages(self, seen: int) -> tuple[int, list[bytes]]:
        """What came after number `seen`, and the number to ask with next time: the newest state, not all of them."""
        if not self._client.server_is_there:
            return seen, [page_message({"kind": "gone"})]
        with self._lock:
            number, state, progress = self._number, self._state, self._progress
            impacts = [hit for order, hit in self._impacts if order > seen]
            count, blocked = self._count, self._blocked
        if number == seen:
            return seen, []
        told = [] if progress is None else [_progress_message(progress)]
        if state is not None:
            header = {"kind": "state", "step": state.step, "time": state.time, "impacts": impacts}
            header |= {"count": count, "blocked": blocked}
            told.append(page_message(header, {"poses": state.poses, "twists": state.twists} | _scales(state.scales)))
        return number, told

    def _clear(self) -> None:
        self._number = self._count = 0
        self._state: StateNews | None = None
        self._progress: StatusReply | None = None
        self._impacts: deque[tuple[int, list[float]]] = deque(maxlen=IMPACTS_KEPT)
        self._blocked: list[str] = []

    def _take_state(self, news: StateNews) -> None:
        with self._lock:
            self._number += 1
            self._state = news

    def _take_progress(self, news: StatusReply) -> None:
        with self._lock:
            self._number += 1
            self._progress = news

    def _take_events(self, news: EventsNews) -> None:
        with self._lock:
            self._number += 1
            self._count += news.books.impacts
            self._blocked = sorted({name for block in news.blocked or () for name in block.bodies})
            for hit in news.impacts[-IMPACTS_KEPT:]:
                self._impacts.append((self._number, [hit.time, *hit.point, hit.impulse]))


def _scales(scales: NDArray[np.float64] | None) -> dict[str, NDArray[np.float64]]:
    return {} if scales is None else {"scales": scales}


def _progress_message(status: StatusReply) -> bytes:
    figures: dict[str, Any] = asdict(status)
    kept = ("run", "phase", "step", "attempt", "time", "busy")
    client = None if status.client is None else status.client.name
    header = {name: figures[name] for name in kept} | {"client": client, "server": status.server.version}
    return page_message({"kind": "progress", **header})
