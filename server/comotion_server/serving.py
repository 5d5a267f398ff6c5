"""Serving a run over zenoh until told to stop."""

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from comotion_protocol import limits
from comotion_protocol.zenoh_link import ZenohServer
from comotion_server.desk import Desk
from comotion_server.engine import Engine
from comotion_server.service import Service

HEED_TIME = 0.25  # [s] longest wait before Ctrl-C is looked for


def serve(
    simulation: Engine,
    run: str,
    listen: Sequence[str] | None = None,
    connect: Sequence[str] = (),
    *,
    zenoh_config: str | Path | None = None,
    allow_insecure: bool = False,
    shared_memory: bool = True,
    idle_time: float = limits.IDLE_TIME,
    stop: threading.Event,
    on_ready: Callable[[], None] = lambda: None,
) -> None:
    """Serve the run of a simulation; return within 2 s once `stop` is set.

    Args:
        simulation: what to serve.
        run: the run's name, by which clients ask for it.
        listen: endpoints to listen on; tcp/127.0.0.1:7447 unless given here or in `zenoh_config`; none if only
            `connect` is given.
        connect: endpoints of routers or peers to connect to.
        zenoh_config: zenoh's own configuration file, for TLS and the like.
        allow_insecure: permit endpoints beyond this machine without TLS.
        shared_memory: use it for large arrays with clients on this machine.
        idle_time: patience with a silent client that shows no liveliness token [s].
        stop: ends the serving when set; it is set here if an older server of the run appears.
        on_ready: called once clients can open.

    Raises:
        EndpointError: an endpoint is taken, out of reach or unsafe, or the run is served already.
        LocalProtocolError: the run's name is none.
    """
    service = Service(simulation, run, idle_time)
    desk = Desk(service)
    server = ZenohServer(
        run,
        desk,
        listen=listen,
        connect=connect,
        zenoh_config=zenoh_config,
        allow_insecure=allow_insecure,
        shared_memory=shared_memory,
    )
    with server, desk:  # at the end the desk refuses what waits, and only then the server goes
        server.claim(service.info.instance, on_lost=stop.set)
        service.meet(server)
        on_ready()
        while not stop.wait(HEED_TIME):
            pass  # Python hears a signal that arrives just before a wait only when the wait is over
        if server.lost:
            raise server.served()
