"""Time as a compensated sum: ten thousand steps of 0.005 s end at 50 s, not at 50.000000000018 s."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Clock:
    """Seconds since the start of the scene; `lost` is what rounding took from `sum` (Neumaier)."""

    sum: float = 0.0
    lost: float = 0.0

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.sum + self.lost

    def after(self, dt: float) -> "Clock":
        """The clock `dt` [s] later."""
        total = self.sum + dt
        large, small = (self.sum, dt) if abs(self.sum) >= dt else (dt, self.sum)
        return Clock(total, self.lost + ((large - total) + small))
