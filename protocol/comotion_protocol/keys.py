"""The key space of a run (SPEC, section K)."""

import re

from comotion_protocol import limits
from comotion_protocol.errors import LocalProtocolError

MESSAGES = ("open", "step", "close", "status", "look")
"""Messages a server answers, each on its own key (SPEC K1)."""

NEWS = ("state", "events", "progress")
"""What a server publishes for those who watch, each on its own key (SPEC K5)."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def is_name(name: object) -> bool:
    """Whether `name` may name a run or a client (SPEC K2)."""
    return isinstance(name, str) and len(name) <= limits.RUN_LENGTH and _NAME.fullmatch(name) is not None


def check_run(run: object) -> str:
    """Return the run's name, or raise LocalProtocolError."""
    if not is_name(run):
        allowed = f"1 to {limits.RUN_LENGTH} of A-Z a-z 0-9 _ . -, the first a letter or a digit"
        raise LocalProtocolError("out_of_range", "K2", f"run name {run!r}: expected {allowed}", {"got": str(run)})
    return str(run)


def message_key(run: str, message: str) -> str:
    """The key on which a server answers one kind of message (SPEC K1)."""
    return f"comotion/1/{check_run(run)}/{message}"


def news_key(run: str, news: str) -> str:
    """The key on which a server publishes one kind of news (SPEC K5)."""
    return f"comotion/1/{check_run(run)}/{news}"


def server_token(run: str) -> str:
    """The liveliness token of the run's server (SPEC K3)."""
    return f"comotion/1/{check_run(run)}/alive/server"


def instance_token(run: str, instance: str = "*") -> str:
    """The liveliness token of one server that wants to serve the run, or the pattern of all (SPEC K3)."""
    return f"comotion/1/{check_run(run)}/alive/instance/{instance}"


def client_token(run: str, client_id: str = "*") -> str:
    """The liveliness token of one client, or the pattern of all (SPEC K4)."""
    return f"comotion/1/{check_run(run)}/alive/client/{client_id}"
