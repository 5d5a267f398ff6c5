"""Motion and collisions of rigid bodies."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from comotion_server.simulation import Simulation

__all__ = ["Simulation"]


def __getattr__(name: str) -> Any:
    """`Simulation` imports numba, which takes half a second: only when it is asked for."""
    if name == "Simulation":
        from comotion_server.simulation import Simulation

        return Simulation
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
