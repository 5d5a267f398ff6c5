"""Which endpoints are safe: those that stay on this machine, and those under TLS (SPEC Z2)."""

import ipaddress

from comotion_protocol.errors import EndpointError

SECURE = frozenset({"tls", "quic", "unixsock-stream", "unixpipe"})
"""Protocols of zenoh that encrypt, or that cannot leave the machine."""


def check_endpoint(endpoint: str, *, allow_insecure: bool) -> str:
    """Return the endpoint, or raise EndpointError if it is no endpoint or reaches beyond this machine without TLS."""
    protocol, slash, rest = endpoint.partition("/")
    address = rest.partition("?")[0].partition("#")[0]
    if not slash or not protocol or not address:
        raise EndpointError(
            "bad_endpoint", "Z1", f"endpoint {endpoint!r}: expected such as tcp/127.0.0.1:7447", {"endpoint": endpoint}
        )
    if protocol in SECURE or _is_loopback(address) or allow_insecure:
        return endpoint
    raise EndpointError(
        "insecure_endpoint",
        "Z2",
        f"endpoint {endpoint!r} reaches beyond this machine without TLS: use tls/... with a zenoh configuration file, "
        "or allow it explicitly",
        {"endpoint": endpoint},
    )


def _is_loopback(address: str) -> bool:
    host = address.rpartition(":")[0].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
