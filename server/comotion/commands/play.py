"""Playing the mock CFD client against a server: what `run` and `mock` share."""

import argparse
import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from time import perf_counter

from comotion.commands.errors import BAD_OUTCOME
from comotion.progress import progress
from comotion.run_record import RunRecord
from comotion.stop_signals import Interrupts
from comotion.summary import Summary
from comotion.timed_motion import TimedMotion
from comotion_mock_cfd.cfd_client import CfdClient, StepRecord
from comotion_mock_cfd.fluid import FluidScene
from comotion_mock_cfd.heave import HeaveRecord

OnStep = Callable[[StepRecord], None]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C or SIGTERM during the play; `summary` tells how far it came.

    An exception, so that the session is dropped on the way out: a step may be under way, and then there is no closing.
    """

    def __init__(self, summary: Summary) -> None:
        super().__init__()
        self.summary = summary


def overridden(scene: FluidScene, options: argparse.Namespace) -> FluidScene:
    """The scene with the duration [s] and step [s] of the command line, where given."""
    return replace(scene, duration=options.duration or scene.duration, dt=options.dt or scene.dt)


def tell(summary: Summary, options: argparse.Namespace) -> int:
    """Print the summary; returns the exit code."""
    if options.json:
        print(json.dumps(summary.as_data(), indent=2, allow_nan=False))
    else:
        print("\n".join(summary.lines()))
    return 0 if summary.status == "ok" else BAD_OUTCOME


class Play:
    """One run of the mock client."""

    def __init__(self, motion: TimedMotion, scene: FluidScene, interrupts: Interrupts) -> None:
        self._motion = motion
        self._scene = scene
        self._interrupts = interrupts
        self._client = CfdClient(motion, scene)
        self._record = RunRecord(start=motion.opened.time, time=motion.opened.time)
        self._heave = HeaveRecord(scene, self._client.bodies) if scene.fluid and scene.fluid.heave else None

    def to_the_end(self, *observers: OnStep) -> Summary:
        """Play; every step goes to the observers, whole.

        Raises:
            Interrupted: by Ctrl-C or SIGTERM.
        """
        start = perf_counter()
        try:
            with progress(self._scene.duration) as show:
                self._client.run(lambda step: self._observe(step, (*observers, lambda _: show(self._record))))
        except KeyboardInterrupt:
            raise Interrupted(self._summary(perf_counter() - start, None, interrupted=True)) from None
        return self._summary(perf_counter() - start, self._motion.protocol_share())

    def _summary(self, wall_time: float, protocol_share: float | None, *, interrupted: bool = False) -> Summary:
        heave = self._heave.period() if self._heave else None
        return Summary(self._scene.name, self._record, wall_time, protocol_share, heave, interrupted)

    def _observe(self, step: StepRecord, observers: Iterable[OnStep]) -> None:
        with self._interrupts.held():
            self._record.add(step)
            if self._heave is not None:
                self._heave.add(step)
            for observe in observers:
                observe(step)
