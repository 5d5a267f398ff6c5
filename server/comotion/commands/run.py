"""`comotion run`: the main job on one machine, server and mock CFD client as two processes over zenoh on loopback."""

import argparse
import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comotion.commands.arguments import (
    add_command,
    add_json,
    add_play,
    add_scene,
    closest,
    count,
    positive,
    scene_path,
    steps,
)
from comotion.commands.errors import UserError

if TYPE_CHECKING:
    from comotion.child_server import Ready
    from comotion.commands.play import Play
    from comotion.outputs.run_outputs import Subject
    from comotion.stop_signals import Interrupts
    from comotion.summary import Summary
    from comotion.timed_motion import TimedMotion
    from comotion_mock_cfd.fluid import FluidScene

NAME = "run"
FRAMES = 25  # 24 spans of time between them
EXAMPLES = """\
  comotion run float_box                            summary on the terminal
  comotion run channel --out out/channel            and report.html, pictures, animation, tables, ParaView series
  comotion run channel --out out --frames 6         six pictures, as in a paper
  comotion run channel --out out --every 0.05       a picture every 0.05 s of simulated time
  comotion run channel --out out --stl 0:1200:100   the surfaces of every 100th step as STL files
  comotion run channel --duration 1 --dt 0.01 --json
  comotion run my_scene.toml --out out --resistance-of ship --window 0.5

exit codes: 0 done; 1 blocked, interrupted, or the server died; 2 wrong use or a scene that cannot be used
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "run server and mock CFD client on this machine"
    description = "Run a scene: the server and the mock CFD client as two processes, and a summary at the end."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    add_scene(parser)
    add_play(parser)
    parser.add_argument("--out", metavar="DIR", type=Path, help="write report, pictures, plots, tables and series here")
    often = parser.add_mutually_exclusive_group()
    frames = f"pictures spread evenly over the run, with its start and end (default: {FRAMES}; 0: none)"
    often.add_argument("--frames", metavar="N", type=count, default=FRAMES, help=frames)
    often.add_argument(
        "--every", metavar="S", type=positive, help="a picture every S seconds of simulated time instead"
    )
    stl = "write the surfaces of steps as STL: 100 or 10,20 or 0:1000:50 or all or last (default: last)"
    parser.add_argument("--stl", metavar="STEPS", nargs="?", const="last", type=steps, help=stl)
    resistance_of = "body whose contact resistance is plotted (default: the first one with prescribed motion)"
    parser.add_argument("--resistance-of", metavar="BODY", help=resistance_of)
    window = "resistance is impulse per this window [s] (default: 0.1)"
    parser.add_argument("--window", metavar="S", type=positive, default=0.1, help=window)
    add_json(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Start the server, play the client, stop the server, tell how it was."""
    from comotion.stop_signals import Interrupts

    path = scene_path(options.scene)
    if options.stl is not None and options.out is None:
        raise UserError("--stl: say where to write the files by --out DIR")
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
    with Interrupts() as interrupts:
        summary, notes = _with_server(path, options, interrupts)
    for note in notes:
        print(f"comotion: {note}", file=sys.stderr)
    from comotion.commands.play import tell

    return tell(summary, options)


def _with_server(path: Path, options: argparse.Namespace, interrupts: "Interrupts") -> tuple["Summary", list[str]]:
    from comotion.child_server import ServerProcess

    with ServerProcess(path) as server:
        # Imported while the server starts up beside us.
        from comotion.commands.play import Interrupted, Play, overridden
        from comotion.fluid_scene import load_fluid_scene
        from comotion.progress import waiting
        from comotion.timed_motion import TimedMotion
        from comotion_mock_cfd.cfd_client import wants
        from comotion_protocol.errors import PeerAbsentError

        with waiting("starting the server (its first start on a machine compiles the kernels: one to three minutes)"):
            ready = server.wait_until_ready()
        scene = overridden(load_fluid_scene(path), options)
        subject = _subject(ready, scene, options)
        try:
            with TimedMotion.open(
                ready.run, ready.endpoint, wants=wants(options.sample), dt=scene.dt, name="comotion run"
            ) as motion:
                play = Play(motion, scene, interrupts)
                return _play(play, motion, subject, options.out)
        except Interrupted as stop:
            return stop.summary, []
        except PeerAbsentError as error:
            raise server.failure(error.message) from None


def _subject(ready: "Ready", scene: "FluidScene", options: argparse.Namespace) -> "Subject":
    from comotion.outputs.run_outputs import Subject

    body = options.resistance_of
    if body is not None and body not in ready.motion:
        raise UserError(f"--resistance-of: there is no body {body!r}{closest(body, ready.motion)}")
    as_told = [name for name, motion in ready.motion.items() if motion == "prescribed"]
    level = scene.fluid.level if scene.fluid is not None else None
    every = options.every or (scene.duration / max(options.frames - 1, 1) if options.frames else None)
    resisting = body or min(as_told, default=None)
    path = scene_path(options.scene)
    return Subject(scene.name, path, ready.motion, level, resisting, options.window, every, options.stl)


def _play(play: "Play", motion: "TimedMotion", subject: "Subject", folder: Path | None) -> tuple["Summary", list[str]]:
    """Play the client; write everything there is to write, as far as an interrupt allows."""
    from comotion.commands.play import Interrupted
    from comotion.outputs.run_outputs import RunOutputs
    from comotion.progress import counting

    if folder is None:
        return play.to_the_end(), []
    with closing(RunOutputs(folder, motion.opened, subject, lambda: motion.waited)) as outputs:
        try:
            summary = play.to_the_end(outputs.add)
        except Interrupted as stop:
            outputs.write_summary(stop.summary.as_data())
            raise
        with counting("drawing") as show:
            outputs.draw(summary, show)
        outputs.write_summary(summary.as_data())
        return summary, outputs.notes
