"""The link over zenoh, both ends (SPEC, section Z). The only file that knows zenoh.

A client asks with `get` and waits for whichever comes first: the reply, the end of the query without one, or the news
that the server's liveliness token is gone. On the server's side callbacks only hand requests to a `Host`; answers are
sent from whatever thread made them.
"""

import contextlib
import secrets
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Self

import zenoh
import zenoh.shm

from comotion_protocol import codec, keys
from comotion_protocol.arena import Arena
from comotion_protocol.blocks import Frame
from comotion_protocol.errors import EndpointError, PeerAbsentError, RemoteProtocolError
from comotion_protocol.link import Host
from comotion_protocol.memory import keep_large_blocks
from comotion_protocol.zenoh_settings import configure, endpoints

QUERY_TIME = 300.0
"""Zenoh's own timeout of a query [s]. Until then zenoh keeps 0.7 kB of every query, answered or not; so it cannot be
endless. A step that takes longer is asked for again with the same bytes, which has no second effect (SPEC S3, Z4)."""

TIMED_OUT = b"Timeout"
"""What zenoh itself puts into an error reply when its timeout is over; an error of the protocol is a msgpack map."""

HEED_TIME = 0.25
"""Longest wait before Ctrl-C is looked for [s]."""

ASK_TIME = 2.0
"""Patience with a look at who is there [s]."""


class ZenohLink:
    """A client's way to the server of a run."""

    def __init__(
        self,
        run: str,
        connect: str | None = None,
        *,
        timeout: float = 5.0,
        zenoh_config: str | Path | None = None,
        allow_insecure: bool = False,
        shared_memory: bool = True,
    ) -> None:
        """Connect and wait until the server is there, `timeout` seconds at most for both.

        Raises:
            PeerAbsentError: nobody at the endpoint, or nobody who serves this run.
            EndpointError: the endpoint or zenoh's configuration cannot be used.
        """
        self.client_id = secrets.token_hex(8)
        self._run = run
        self._keys = {message: keys.message_key(run, message) for message in keys.MESSAGES}
        self._waiting: set[SimpleQueue[Any]] = set()
        self._server_there = threading.Event()
        deadline = time.monotonic() + timeout
        config = _configure(
            zenoh_config,
            mode="client",
            listen=(),
            connect=None if connect is None else (connect,),
            timeout=timeout,
            shared_memory=shared_memory,
            allow_insecure=allow_insecure,
        )
        where = ", ".join(endpoints(config, "connect/endpoints"))
        try:
            self._session = _open(config)
        except zenoh.ZError as error:
            text = f"no server at {where} within {timeout:g} s"
            raise PeerAbsentError("no_server", "Z5", text, {"endpoint": where, "reason": str(error)}) from None
        try:
            self._arena = Arena(_pool) if shared_memory else None
            self._token = self._session.liveliness().declare_token(keys.client_token(run, self.client_id))
            self._watch = self._session.liveliness().declare_subscriber(
                keys.server_token(run), zenoh.handlers.Callback(self._hear_of_server, indirect=False), history=True
            )
            there = self._server_there.wait(max(0.0, deadline - time.monotonic()))
        except BaseException:
            _close(self._session)
            raise
        if not there:
            _close(self._session)
            raise PeerAbsentError("no_server", "Z5", f"nobody at {where} serves run {run!r}", {"run": run})

    def ask(self, message: str, frame: Frame, timeout: float | None) -> tuple[bool, bytes, bytes]:
        """See `Link.ask`."""
        while True:
            answer = self._ask_once(message, frame, timeout)
            if answer != (False, TIMED_OUT, b""):
                return answer

    def _ask_once(self, message: str, frame: Frame, timeout: float | None) -> tuple[bool, bytes, bytes]:
        """The answer to one query (SPEC Z4), zenoh's own word for its timeout included."""
        if self._session.is_closed() or not self._server_there.is_set():
            raise self._absent(message)
        box: SimpleQueue[Any] = SimpleQueue()
        self._waiting.add(box)
        try:
            self._session.get(
                self._keys[message],
                zenoh.handlers.Callback(box.put, partial(box.put, None), indirect=False),
                target=zenoh.QueryTarget.BEST_MATCHING,
                consolidation=zenoh.ConsolidationMode.NONE,
                congestion_control=zenoh.CongestionControl.BLOCK,
                timeout=QUERY_TIME if timeout is None else timeout + 1.0,
                payload=_payload(frame, self._arena),
                attachment=frame.header,
            )
            reply = _take(box, timeout)
        except Empty:
            raise PeerAbsentError("no_reply", "Z7", f"no reply to {message!r} within {timeout} s") from None
        finally:
            self._waiting.discard(box)
        if reply is None:
            raise self._absent(message)
        return _unpack(reply)

    def subscribe(self, news: str, hear: Callable[[bytes, bytes], None]) -> Callable[[], None]:
        """Have `hear(header, bulk)` called in zenoh's thread for every news of a kind; returns what ends it."""

        def receive(sample: zenoh.Sample) -> None:
            header = sample.attachment
            hear(b"" if header is None else header.to_bytes(), _bytes_of(sample.payload))

        callback = zenoh.handlers.Callback(receive, indirect=False)
        subscriber = self._session.declare_subscriber(keys.news_key(self._run, news), callback)

        def end() -> None:
            with contextlib.suppress(zenoh.ZError):  # the session may be closed by now
                subscriber.undeclare()  # type: ignore[no-untyped-call]

        return end

    @property
    def server_is_there(self) -> bool:
        """Whether the server's token is there."""
        return self._server_there.is_set()

    def close(self) -> None:
        """See `Link.close`."""
        _close(self._session)

    def _hear_of_server(self, sample: zenoh.Sample) -> None:
        """The server's token came or went: with it goes every reply that is waited for (SPEC Z6)."""
        if sample.kind == zenoh.SampleKind.PUT:
            self._server_there.set()
            return
        self._server_there.clear()
        for box in tuple(self._waiting):
            box.put(None)

    def _absent(self, message: str) -> PeerAbsentError:
        return PeerAbsentError(
            "server_gone", "Z6", f"{message}: the server of run {self._run!r} is gone", {"run": self._run}
        )


def _take(box: SimpleQueue[Any], timeout: float | None) -> Any:
    """The next thing from the box; raises Empty after `timeout` seconds.

    Python hears a signal that arrives just before a wait only when the wait is over, so no wait is long.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    while True:
        left = HEED_TIME if deadline is None else deadline - time.monotonic()
        try:
            return box.get(timeout=min(HEED_TIME, max(left, 0.0)))
        except Empty:
            if left < HEED_TIME:
                raise


class _ZenohQuestion:
    """A query that waits for its answer."""

    def __init__(self, message: str, key: str, query: zenoh.Query, arena: Arena | None) -> None:
        self.message = message
        self._key = key
        self._query = query
        self._arena = arena

    def frame(self) -> tuple[bytes, bytes]:
        header, bulk = self._query.attachment, self._query.payload
        return b"" if header is None else header.to_bytes(), b"" if bulk is None else _bytes_of(bulk)

    def reply(self, frame: Frame) -> None:
        with self._query:
            self._query.reply(self._key, _payload(frame, self._arena), attachment=frame.header)

    def refuse(self, error: bytes) -> None:
        with self._query:
            self._query.reply_err(error)


class ZenohServer:
    """The server's end: hands the requests of a run to a host. A context manager."""

    def __init__(
        self,
        run: str,
        host: Host,
        *,
        listen: Sequence[str] | None = None,
        connect: Sequence[str] = (),
        zenoh_config: str | Path | None = None,
        allow_insecure: bool = False,
        shared_memory: bool = True,
        timeout: float = 5.0,
    ) -> None:
        """Open the endpoints. Without any, listen on the default one; if only told to connect, do not listen.

        Raises:
            EndpointError: an endpoint is taken, out of reach or unsafe, or the run is served already.
        """
        self._run = run
        self._host = host
        config = _configure(
            zenoh_config,
            mode=_server_mode(listen, connect),
            listen=() if listen is None and connect else listen,
            connect=tuple(connect) or None,
            timeout=timeout,
            shared_memory=shared_memory,
            allow_insecure=allow_insecure,
        )
        try:
            self._session = _open(config)
        except zenoh.ZError as error:
            where = ", ".join(endpoints(config, "listen/endpoints", "connect/endpoints"))
            text = f"cannot open {where}: taken by another program, or out of reach"
            raise EndpointError("endpoint_failed", "Z3", text, {"endpoint": where, "reason": str(error)}) from None
        self._arena = Arena(_pool) if shared_memory else None
        self.lost = False
        """Whether an older server of the run appeared."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        _close(self._session)

    def claim(self, instance: str, on_lost: Callable[[], None]) -> None:
        """Answer the run's keys, unless another server does (SPEC Z8).

        Of two that start at once neither may see the other yet. Each goes on looking, and the younger one has lost the
        run as soon as it sees the older one's token: `lost` is set and `on_lost` called.
        Raises EndpointError when the run is served already.
        """
        alive = self._session.liveliness()
        if self._tokens(keys.server_token(self._run)):
            raise self.served()
        mine = keys.instance_token(self._run, instance)

        def hear_of_server(sample: zenoh.Sample) -> None:
            if sample.kind == zenoh.SampleKind.PUT and str(sample.key_expr) < mine:
                self.lost = True
                on_lost()

        for message in keys.MESSAGES:
            self._declare(message)
        for pattern, hear in (
            (keys.client_token(self._run), self._hear_of_client),
            (keys.instance_token(self._run), hear_of_server),
        ):
            alive.declare_subscriber(pattern, zenoh.handlers.Callback(hear, indirect=False), history=True)
        self._publishers = {
            news: self._session.declare_publisher(
                keys.news_key(self._run, news), congestion_control=zenoh.CongestionControl.DROP
            )
            for news in keys.NEWS
        }
        self._tokens_held = [alive.declare_token(key) for key in (mine, keys.server_token(self._run))]

    def listens(self, news: str) -> bool:
        """See `Audience.listens`."""
        status: Any = self._publishers[news].matching_status  # zenoh's stub says bool
        return bool(status.matching)

    def publish(self, news: str, frame: Frame) -> None:
        """See `Audience.publish`."""
        self._publishers[news].put(frame.bulk(), attachment=frame.header)

    def _tokens(self, key: str) -> set[str]:
        """The liveliness tokens that match a key, wherever they are."""
        replies = [reply.ok for reply in self._session.liveliness().get(key, timeout=ASK_TIME)]
        return {str(sample.key_expr) for sample in replies if sample is not None}

    def _declare(self, message: str) -> None:
        key = keys.message_key(self._run, message)

        def receive(query: zenoh.Query) -> None:
            question = _ZenohQuestion(message, key, query, self._arena)
            try:
                self._host.receive(question)
            except Exception as error:  # noqa: BLE001  (zenoh would send an empty set of replies instead, SPEC E5)
                text = f"{message} failed: {type(error).__name__}: {error}"
                question.refuse(codec.encode_error(RemoteProtocolError("failed", "E5", text)))

        callback = zenoh.handlers.Callback(receive, indirect=False)
        self._session.declare_queryable(key, callback, complete=True)

    def _hear_of_client(self, sample: zenoh.Sample) -> None:
        client_id = str(sample.key_expr).rpartition("/")[2]
        self._host.client_alive(client_id, alive=sample.kind == zenoh.SampleKind.PUT)

    def served(self) -> EndpointError:
        """The error of a server that finds the run served by another one."""
        return EndpointError(
            "already_served", "Z8", f"run {self._run!r} is served already by another server", {"run": self._run}
        )


def _payload(frame: Frame, arena: Arena | None) -> Any:
    """The bulk as zenoh takes it: shared memory where it pays and can be had, else bytes."""
    shared = None if arena is None else arena.fill(frame)
    return frame.bulk() if shared is None else shared


def _unpack(reply: zenoh.Reply) -> tuple[bool, bytes, bytes]:
    """Accepted, header and bulk of a reply; for an error reply its payload as header (SPEC E1)."""
    if (sample := reply.ok) is not None:
        header = sample.attachment
        return True, b"" if header is None else header.to_bytes(), _bytes_of(sample.payload)
    error = reply.err
    return False, b"" if error is None else error.payload.to_bytes(), b""


def _server_mode(listen: Sequence[str] | None, connect: Sequence[str]) -> str:
    """How a server takes part. Routers do not carry peers' words to other peers: these should connect by gossip."""
    if not connect:
        return "peer"
    return "router" if listen else "client"


def _bytes_of(payload: zenoh.ZBytes) -> bytes:
    """A payload's bytes; from shared memory straight, which takes two thirds of the time of `to_bytes`."""
    shared = payload.as_shm()
    return payload.to_bytes() if shared is None else bytes(shared)


def _configure(zenoh_config: str | Path | None, **wanted: Any) -> zenoh.Config:
    """Zenoh's configuration, from a user's file or none, with our settings (SPEC Z9)."""
    try:
        config = zenoh.Config() if zenoh_config is None else zenoh.Config.from_file(zenoh_config)
    except zenoh.ZError as error:
        text = f"zenoh configuration {str(zenoh_config)!r} cannot be read: {error}"
        raise EndpointError("bad_config", "Z9", text, {"file": str(zenoh_config)}) from None
    configure(config, zenoh.Config(), **wanted)
    return config


def _open(config: zenoh.Config) -> zenoh.Session:
    keep_large_blocks()  # before zenoh starts its threads
    return zenoh.open(config)


def _pool(size: int) -> Callable[[int], zenoh.shm.ZShmMut | None]:
    """Shared memory of this many bytes to take buffers from; None where it cannot be had, or all of it is in use."""
    try:
        provider = zenoh.shm.ShmProvider.default_backend(size)
    except zenoh.ZError:
        return lambda _: None

    def allocate(wanted: int) -> zenoh.shm.ZShmMut | None:
        with contextlib.suppress(zenoh.ZError):
            return provider.alloc(wanted, zenoh.shm.GarbageCollect())
        return None

    return allocate


def _close(session: zenoh.Session) -> None:
    with contextlib.suppress(zenoh.ZError):
        session.close()  # type: ignore[no-untyped-call]  # zenoh's stub says nothing
