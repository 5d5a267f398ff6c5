"""The studies of a report, by name."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from comotion.report.findings import Findings

Progress = Callable[[str], None]
"""Says what is measured now."""


@dataclass(frozen=True)
class Study:
    """A question, the module whose `study(quick, say)` answers it, and about how long the full answer takes."""

    name: str
    title: str
    minutes: float

    def run(self, *, quick: bool, say: Progress) -> Findings:
        """Measure; the module is imported now, so that a report loads only what it runs."""
        found: Findings = import_module(f"comotion.report.{self.name}").study(quick=quick, say=say)
        return found


STUDIES = (
    Study("attitude", "Attitude of a free top: error against run time", 1.0),
    Study("contact_time", "Time of a contact: error against run time", 1.0),
    Study("many_impacts", "A hundred impacts of 23 spheres: error against run time", 0.5),
    Study("engines", "Bouncing and elastic balls beside other engines", 20.0),
    Study("staircase", "Hull in a row of floes: error against run time", 1.0),
    Study("floating", "Heave and roll under two ways to sample forces", 2.0),
    Study("roundness", "A meshed ball beside the round one", 2.0),
    Study("distance", "Distance queries beside coal and python-fcl", 2.0),
    Study("extreme", "Stiff and extreme cases", 4.0),
    Study("leaving_out", "What scenes leave out, and what that saves", 6.0),
    Study("scaling", "Time per step against size", 10.0),
)
