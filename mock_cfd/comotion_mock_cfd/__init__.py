"""A mock CFD client: hydrostatics, drag and added mass in place of a flow solver."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from comotion_mock_cfd.cfd_client import CfdClient, StepRecord, wants
    from comotion_mock_cfd.fluid import Fluid, FluidError, FluidScene, load_fluid

__all__ = ["CfdClient", "Fluid", "FluidError", "FluidScene", "StepRecord", "load_fluid", "wants"]


def __getattr__(name: str) -> Any:
    """Import on first use: the shipped scenes' names are wanted without pydantic and numpy."""
    if name in {"CfdClient", "StepRecord", "wants"}:
        from comotion_mock_cfd import cfd_client

        return getattr(cfd_client, name)
    if name in {"Fluid", "FluidError", "FluidScene", "load_fluid"}:
        from comotion_mock_cfd import fluid

        return getattr(fluid, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
