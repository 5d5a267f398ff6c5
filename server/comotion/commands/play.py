"""Playing the mock CFD client against a server: what `run` and `mock` share."""

import argparse
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from comotion.progress import progress
from comotion.run_record import RunRecord
from comotion.summary import Summary
from comotion.timed_motion import TimedMotion
from comotion_mock_cfd.cfd_client import CfdClient, StepRecord
from comotion_mock_cfd.fluid import FluidScene
from comotion_mock_cfd.heave import HeaveRecord

OnStep = Callable[[StepRecord], None]


def overridden(scene: FluidScene, options: argparse.Namespace) -> FluidScene:
    """The scene with the duration [s] and step [s] of the command line, where given."""
    return replace(scene, duration=options.duration or scene.duration, dt=options.dt or scene.dt)


class Play:
    """One run of the mock client; every step goes to the observers."""

    def __init__(self, motion: TimedMotion, scene: FluidScene, *observers: OnStep) -> None:
        self._motion = motion
        self._scene = scene
        self._client = CfdClient(motion, scene)
        self._record = RunRecord()
        self._heave = HeaveRecord(scene, self._client.bodies) if scene.fluid and scene.fluid.heave else None
        self._observers = (self._record.add, *([self._heave.add] if self._heave else []), *observers)

    def to_the_end(self) -> Summary:
        """Play; an interrupt ends the play, not the program."""
        interrupted = False
        start = perf_counter()
        try:
            with progress(self._scene.duration) as show:
                self._client.run(lambda step: self._observe(step, show))
        except KeyboardInterrupt:
            interrupted = True
        return Summary(
            scene=self._scene.name,
            record=self._record,
            wall_time=perf_counter() - start,
            protocol_share=None if interrupted else self._motion.protocol_share(),
            heave=self._heave.period() if self._heave else None,
            interrupted=interrupted,
        )

    def _observe(self, step: StepRecord, show: Callable[[RunRecord], None]) -> None:
        for observe in self._observers:
            observe(step)
        show(self._record)
