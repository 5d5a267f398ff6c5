"""Plain words for what a user can mend. What is left is a fault of ours and keeps its traceback."""

import os
from dataclasses import dataclass

BAD_OUTCOME = 1
WRONG_INPUT = 2


OTHER_SIDE = {"lease_held", "busy", "stopping", "failed"}  # refusals (SPEC E2) that have their cause on the other side


class UserError(Exception):
    """A mistake on the command line or in the surroundings; the text is all that the user needs."""

    def __init__(self, text: str, exit_code: int = WRONG_INPUT) -> None:
        super().__init__(f"comotion: {text}")
        self.exit_code = exit_code


class ChildError(UserError):
    """A process that we started ended badly; the text is what it said."""

    def __init__(self, text: str, exit_code: int) -> None:
        Exception.__init__(self, text)
        self.exit_code = exit_code


@dataclass(frozen=True)
class Explained:
    """What to print on standard error, and the exit code."""

    text: str
    exit_code: int


def explain(error: Exception) -> Explained | None:
    """What to tell the user, or None when the error is not theirs."""
    if isinstance(error, UserError):
        return Explained(str(error), error.exit_code)
    if isinstance(error, ModuleNotFoundError):
        return Explained(f"comotion: {error.name} is not installed: pip install 'comotion[server,view]'", WRONG_INPUT)
    from comotion_mock_cfd.fluid import FluidError
    from comotion_protocol.errors import PeerAbsentError, ProtocolError
    from comotion_server.scene import SceneError

    if isinstance(error, FluidError):
        return Explained(f"comotion: {error}", WRONG_INPUT)
    if isinstance(error, SceneError):
        return Explained(str(error), WRONG_INPUT)
    if isinstance(error, PeerAbsentError):
        return Explained(f"comotion: {error.message}", BAD_OUTCOME)
    if isinstance(error, ProtocolError):
        return Explained(f"comotion: {error}", BAD_OUTCOME if error.code in OTHER_SIDE else WRONG_INPUT)
    if isinstance(error, OSError):
        return Explained(f"comotion: {_of_system(error)}", WRONG_INPUT)
    return None


def _of_system(error: OSError) -> str:
    reason = os.strerror(error.errno) if error.errno else str(error)
    return f"{error.filename}: {reason}" if error.filename else reason
