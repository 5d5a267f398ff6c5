"""What can go wrong, as types: your fault, the peer's fault, nobody there (SPEC, section E).

Every error carries the code and the number of the rule that was broken, a message for people and a detail for programs.
"""

from collections.abc import Mapping
from typing import Any

CODES: Mapping[str, str] = {
    "malformed": "the bytes are not a header or do not fit their blocks",
    "missing": "a required key is not there",
    "wrong_type": "a value has another type than its table says",
    "out_of_range": "a value lies outside what its table allows",
    "too_large": "a limit on sizes is exceeded",
    "protocol_version": "the peers speak different major versions",
    "not_supported": "the request asks for something this server does not do",
    "digest_mismatch": "the client knows other surfaces than the server has",
    "unknown_message": "no message has this name",
    "unknown_block": "a block is none of those that the message takes",
    "unknown_region": "a block names a region that the run does not have",
    "wrong_shape": "an array has another shape than its region or the bodies need",
    "not_finite": "an array holds NaN or infinity",
    "bad_dt": "a step size is not a positive finite number",
    "bad_step": "the simulation cannot take these forces with this step size",
    "sums_mismatch": "the client's sums differ from those of the forces received",
    "lease_held": "another client holds the lease",
    "wrong_lease": "the lease is not the one given out last, or nobody holds one",
    "wrong_step": "the step is neither the open one nor the next",
    "attempt_passed": "a higher attempt of this step was accepted already",
    "conflict": "the same step and attempt came before with other bytes",
    "busy": "too many requests wait already",
    "stopping": "the server shuts down",
    "failed": "the server could not do it, by its own fault; the state is unchanged",
}
"""Codes of error replies and what they mean (SPEC E2)."""

SERVER_FAULTS = frozenset({"failed", "busy", "stopping"})
"""Codes of error replies that are not the asker's fault (SPEC E3)."""


class ProtocolError(Exception):
    """Base of all: `code` and `rule` for programs, `message` for people, `detail` with names and numbers."""

    def __init__(self, code: str, rule: str, message: str, detail: Mapping[str, Any] | None = None) -> None:
        super().__init__(f"{message} [{code}, {rule}]")
        self.code = code
        self.rule = rule
        self.message = message
        self.detail: Mapping[str, Any] = dict(detail or {})


class LocalProtocolError(ProtocolError):
    """Your fault: what this side said or asked for breaks a rule."""


class RemoteProtocolError(ProtocolError):
    """The peer's fault: what came from the other side breaks a rule."""


class PeerAbsentError(ProtocolError):
    """Nobody there, or no longer: no server, a killed or a frozen one."""


class EndpointError(LocalProtocolError):
    """This side cannot open its end: a port that is taken, an unsafe endpoint, a run that is served already."""
