"""A motion client that knows how long it waited: what the protocol costs is that time less the server's own."""

from time import perf_counter
from typing import Any

from comotion_protocol.client import MotionClient
from comotion_protocol.messages import StepReply


class TimedMotion(MotionClient):
    """A `MotionClient` with `waited`: seconds spent in `step` so far."""

    waited = 0.0

    def step(self, *arguments: Any, **options: Any) -> StepReply:
        """See `MotionClient.step`."""
        start = perf_counter()
        try:
            return super().step(*arguments, **options)
        finally:
            self.waited += perf_counter() - start

    def protocol_share(self) -> float:
        """Share of the waiting that was not the server's computing: packing, sending, checking, unpacking."""
        return max(0.0, 1.0 - self.status().busy / self.waited) if self.waited > 0.0 else 0.0
