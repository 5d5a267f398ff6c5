"""The protocol between a CFD client and the motion server: messages, bytes, session, links, client.

Public names are loaded when first used, so that a command's `--help` costs no numpy and no zenoh.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from comotion_protocol.client import MotionClient as MotionClient
    from comotion_protocol.errors import EndpointError as EndpointError
    from comotion_protocol.errors import LocalProtocolError as LocalProtocolError
    from comotion_protocol.errors import PeerAbsentError as PeerAbsentError
    from comotion_protocol.errors import ProtocolError as ProtocolError
    from comotion_protocol.errors import RemoteProtocolError as RemoteProtocolError
    from comotion_protocol.messages import OpenReply as OpenReply
    from comotion_protocol.messages import StatusReply as StatusReply
    from comotion_protocol.messages import StepReply as StepReply
    from comotion_protocol.messages import Sums as Sums
    from comotion_protocol.messages import Wants as Wants

_HOME = {
    "MotionClient": "client",
    "EndpointError": "errors",
    "LocalProtocolError": "errors",
    "PeerAbsentError": "errors",
    "ProtocolError": "errors",
    "RemoteProtocolError": "errors",
    "OpenReply": "messages",
    "StatusReply": "messages",
    "StepReply": "messages",
    "Sums": "messages",
    "Wants": "messages",
}
__all__ = sorted(_HOME)  # noqa: PLE0605  (one list of names, not two)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
