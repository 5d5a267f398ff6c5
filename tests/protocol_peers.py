"""A server of the trivial engine and ways to it, over memory or over zenoh on loopback: for tests of the protocol."""

import socket
import threading
from contextlib import ExitStack

from trivial_engine import TrivialEngine

from comotion_protocol import MotionClient, ProtocolError
from comotion_protocol.blocks import Frame
from comotion_protocol.codec import decode_error, encode_request
from comotion_protocol.header import pack
from comotion_protocol.link import MemoryLink
from comotion_server.desk import Desk
from comotion_server.service import Service

RUN = "test"
PATIENCE = 20.0
"""Longest wait for anything that must happen [s]; a test that waits so long fails."""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Clock:
    """A clock that goes when told."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


class Peers:
    """One server and its clients; links and threads end with the context."""

    def __init__(self, kind, engine=None, **service):
        self.kind = kind
        self.engine = engine or TrivialEngine()
        self.clock = Clock()
        self.service = Service(self.engine, RUN, clock=self.clock, **service)
        self.desk = Desk(self.service)
        self._stack = ExitStack()

    def __enter__(self):
        if self.kind == "zenoh":
            from comotion_protocol.zenoh_link import ZenohServer

            self.endpoint = f"tcp/127.0.0.1:{free_port()}"
            self.server = self._stack.enter_context(ZenohServer(RUN, self.desk, listen=[self.endpoint]))
            self._stack.enter_context(self.desk)
            self.server.claim(self.service.info.instance, on_lost=lambda: None)
        else:
            self._stack.enter_context(self.desk)
        return self

    def __exit__(self, *error):
        if isinstance(self.engine, TrivialEngine):
            self.engine.hold.set()
        return self._stack.__exit__(*error)

    def link(self):
        if self.kind == "memory":
            link = MemoryLink(self.desk)
        else:
            from comotion_protocol.zenoh_link import ZenohLink

            link = ZenohLink(RUN, self.endpoint)
        self._stack.callback(link.close)
        return link

    def open(self, **wanted):
        return MotionClient.open(RUN, link=self.link(), **wanted)

    def in_background(self, call, *arguments):
        """Run a call in a thread; returns a function that waits for it and returns what it returned or raised."""
        result = []

        def run():
            try:
                result.append(call(*arguments))
            except ProtocolError as error:
                result.append(error)

        thread = threading.Thread(target=run)
        thread.start()
        self._stack.callback(thread.join)
        self._stack.callback(self.engine.hold.set)

        def wait():
            thread.join(PATIENCE)
            return result[0]

        return wait


def ask(link, message, header, arrays=(), timeout=PATIENCE):
    """Send a header as it is (a dict, or bytes) and arrays; the answer (accepted, header, bulk)."""
    data = header if isinstance(header, bytes) else pack(header)
    return link.ask(message, Frame(data, tuple(arrays)), timeout)


def send(link, request, message="step"):
    """Send a request; the answer (accepted, header, bulk)."""
    return link.ask(message, encode_request(request), PATIENCE)


def error_of(answer):
    """The error in an answer that must be a refusal."""
    accepted, header, _ = answer
    assert not accepted
    return decode_error(header)
