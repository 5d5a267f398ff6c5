"""Zenoh's settings as plain data (SPEC, section Z): loopback, no scouting, short leases."""

import json
from collections.abc import Sequence
from typing import Any, Protocol

from comotion_protocol.endpoints import check_endpoint

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
"""Where a server listens and a client connects unless told otherwise (SPEC Z1)."""

TRANSPORT_LEASE = 2.0
"""A peer that is silent for so long is gone [s]; zenoh's own default is 10."""

COMMON: dict[str, Any] = {
    # Zenoh's default finds any peer on any network. A run is between those who were told its endpoint.
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "transport/link/tx/lease": round(1000 * TRANSPORT_LEASE),
    # Large bulk is put into shared memory by us, without the copies that zenoh's own way of doing it needs.
    "transport/shared_memory/mode": "init",
    "transport/shared_memory/transport_optimization/enabled": False,
    # Zenoh's default tries again after seconds.
    "connect/retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 2.0},
    # An endpoint that cannot be reached, or not listened on, is an error and not a line in a log.
    "connect/exit_on_failure": True,
    "listen/exit_on_failure": True,
}
"""Of both sides; each with the reason why zenoh's default does not do."""


class Config(Protocol):
    """The part of `zenoh.Config` that is used here."""

    def get_json(self, key: str) -> Any:
        """The value at a path, as JSON."""

    def insert_json5(self, key: str, value: Any) -> Any:
        """Set the value at a path."""


def configure(
    config: Config,
    default: Config,
    *,
    mode: str,
    listen: Sequence[str] | None,
    connect: Sequence[str] | None,
    timeout: float,
    shared_memory: bool,
    allow_insecure: bool,
) -> None:
    """Put our settings into `config`, where it has zenoh's own default (SPEC Z9).

    Args:
        config: from a user's file, or as zenoh makes it.
        default: as zenoh makes it. A file's value that equals it cannot be told from one that is not there.
        mode: zenoh's: "client" only connects, "peer" only listens, "router" does both and carries messages on.
        listen: endpoints; these go before those of a file. None: the file's, or the usual ones.
        connect: likewise.
        timeout: patience with connecting [s].
        shared_memory: whether to allow it.
        allow_insecure: permit endpoints beyond this machine without TLS.

    Raises:
        EndpointError: an endpoint is none, or unsafe.
    """
    values = COMMON | {
        "mode": mode,
        "listen/endpoints": [DEFAULT_ENDPOINT] if mode == "peer" else [],
        "connect/endpoints": [DEFAULT_ENDPOINT] if mode == "client" else [],
        "connect/timeout_ms": round(1000 * timeout),
        "transport/shared_memory/enabled": shared_memory,
    }
    for path, value in values.items():
        if config.get_json(path) == default.get_json(path):
            config.insert_json5(path, json.dumps(value))
    for path, given in (("listen/endpoints", listen), ("connect/endpoints", connect)):
        if given is not None:
            config.insert_json5(path, json.dumps(list(given)))
        for endpoint in endpoints(config, path):
            check_endpoint(endpoint, allow_insecure=allow_insecure)


def endpoints(config: Config, *paths: str) -> list[str]:
    """The endpoints at these paths; zenoh also lets them depend on the mode."""
    found: list[str] = []
    for path in paths:
        value = json.loads(config.get_json(path))
        found += value if isinstance(value, list) else [one for many in value.values() for one in many]
    return found
