"""A watcher: sees a run without taking part in it (SPEC, section W).

Example::

    with WatchClient("channel") as watch:
        watch.look().vertices["ice"]
        with watch.listening({"state": print}):
            time.sleep(1.0)
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Self

from comotion_protocol import codec
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.messages import LookReply, LookRequest, StatusReply, StatusRequest
from comotion_protocol.zenoh_link import ZenohLink

LOOK_TIMEOUT = 60.0
"""Patience with a look [s]: it waits for the step under way."""

STATUS_TIMEOUT = 5.0
"""Patience with a status [s]: it never waits for a step."""


class WatchClient:
    """A connection to the server of a run. A context manager."""

    def __init__(
        self,
        run: str,
        connect: str | None = None,
        *,
        connect_timeout: float = 5.0,
        zenoh_config: str | Path | None = None,
        allow_insecure: bool = False,
    ) -> None:
        """Connect; arguments as for `MotionClient.open`.

        Raises:
            PeerAbsentError: no server.
        """
        self._link = ZenohLink(
            run, connect, timeout=connect_timeout, zenoh_config=zenoh_config, allow_insecure=allow_insecure
        )

    @property
    def server_is_there(self) -> bool:
        """Whether the server is there still."""
        return self._link.server_is_there

    def look(self) -> LookReply:
        """The surfaces as they are."""
        return codec.decode_look_reply(*self._ask("look", LookRequest(), LOOK_TIMEOUT))

    def status(self) -> StatusReply:
        """What the server does just now."""
        return codec.decode_status_reply(*self._ask("status", StatusRequest(), STATUS_TIMEOUT))

    @contextmanager
    def listening(self, hear: Mapping[str, Callable[[Any], None]]) -> Iterator[None]:
        """While inside, have these called with the news of their kind, in a thread of the link's.

        News that cannot be read are left out: a watcher goes on.
        """
        with ExitStack() as ends:
            for news, call in hear.items():
                ends.callback(self._link.subscribe(news, _reader(news, call)))
            yield

    def close(self) -> None:
        """Close the connection."""
        self._link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, message: str, request: LookRequest | StatusRequest, timeout: float) -> tuple[bytes, bytes]:
        accepted, header, bulk = self._link.ask(message, codec.encode_request(request), timeout)
        if not accepted:
            raise codec.decode_error(header)
        return header, bulk


def _reader(news: str, call: Callable[[Any], None]) -> Callable[[bytes, bytes], None]:
    def hear(header: bytes, bulk: bytes) -> None:
        try:
            told = codec.decode_news(news, header, bulk)
        except RemoteProtocolError:
            return
        call(told)

    return hear
