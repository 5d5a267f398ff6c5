"""The page and its messages over websockets, on this machine only.

Who may connect: programs on this machine, and in a browser only our own page: the names `Host` and `Origin` must be
those of this address, so that a foreign page cannot reach it, not even under a name that it resolves to 127.0.0.1.
Nothing that comes from a page is acted on, and it may not be longer than `TAKEN_BYTES`.
"""

import asyncio
import contextlib
import socket
from collections.abc import Callable
from importlib.resources import files
from typing import Protocol

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

HOST = "127.0.0.1"
INTERVAL = 1 / 30  # [s] between messages to a page: what a screen shows smoothly
TAKEN_BYTES = 1024  # largest message from a page [bytes]
PAGES = 8  # most pages at once
HEED_TIME = 0.2  # [s] longest wait before the end is looked for
TYPES = {"html": "text/html; charset=utf-8", "js": "text/javascript; charset=utf-8", "css": "text/css; charset=utf-8"}
PATHS = {"/": "index.html", "/page.js": "page.js", "/three.module.min.js": "three.module.min.js"}
FEED = "/feed"
POLICY = "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; connect-src 'self'; img-src data:"


class Source(Protocol):
    """What a page is told of."""

    def enter(self) -> list[bytes]:
        """A page opens: its first messages."""

    def leave(self) -> None:
        """A page closes."""

    def messages(self, seen: int) -> tuple[int, list[bytes]]:
        """What came after number `seen`, and the number for the next time."""


class PageServer:
    """Serves one source at `address`, from its making on until `run` ends."""

    def __init__(self, source: Source, port: int = 0) -> None:
        """Take a port of this machine, any free one for 0; OSError when it is taken."""
        self._source = source
        self._socket = socket.create_server((HOST, port))
        self._port = self._socket.getsockname()[1]
        self._names = {f"{name}:{self._port}" for name in (HOST, "localhost")}
        self._pages = 0

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self._port}/"

    def run(self, ended: Callable[[], bool]) -> None:
        """Serve until `ended()`."""
        asyncio.run(self._run(ended))

    async def _run(self, ended: Callable[[], bool]) -> None:
        async with serve(
            self._feed, sock=self._socket, process_request=self._answer, max_size=TAKEN_BYTES, compression=None
        ):
            while not ended():  # noqa: ASYNC110  (it is also what lets Python hear a signal)
                await asyncio.sleep(HEED_TIME)

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Give out the page's files; let its feed through."""
        origin = request.headers.get("Origin")
        if request.headers.get("Host") not in self._names or (
            origin is not None and origin.removeprefix("http://") not in self._names
        ):
            return connection.respond(403, "only this machine's own page is served\n")
        if request.path == FEED:
            return None if self._pages < PAGES else connection.respond(503, f"{PAGES} pages are open already\n")
        name = PATHS.get(request.path)
        if name is None:
            return connection.respond(404, "there is no such file\n")
        body = (files("comotion.watching") / "page" / name).read_bytes()
        headers = {"Content-Type": TYPES[name.rpartition(".")[2]], "Content-Length": str(len(body))}
        headers |= {"Content-Security-Policy": POLICY, "X-Content-Type-Options": "nosniff", "Connection": "close"}
        return Response(200, "OK", Headers(headers), body)

    async def _feed(self, connection: ServerConnection) -> None:
        self._pages += 1
        try:
            first = await asyncio.to_thread(self._source.enter)
            try:
                await self._send(connection, first)
            finally:
                await asyncio.to_thread(self._source.leave)
        finally:
            self._pages -= 1

    async def _send(self, connection: ServerConnection, first: list[bytes]) -> None:
        """All that there is and will be, until the page goes; a slow page gets fewer states, not older ones."""
        with contextlib.suppress(ConnectionClosed):
            for message in first:
                await connection.send(message)
            seen = 0
            closed = asyncio.ensure_future(connection.wait_closed())
            while not closed.done():
                seen, news = self._source.messages(seen)
                for message in news:
                    await connection.send(message)
                await asyncio.wait([closed], timeout=INTERVAL)
