"""`comotion run`: the main job on one machine, server and mock CFD client as two processes over zenoh on loopback."""

import argparse
import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comotion.commands.arguments import add_command, add_json, add_play, add_scene, closest, positive, scene_path
from comotion.commands.errors import UserError

if TYPE_CHECKING:
    from comotion.child_server import Ready
    from comotion.commands.play import Play
    from comotion.outputs.run_outputs import Subject
    from comotion.stop_signals import Interrupts
    from comotion.summary import Summary
    from comotion_mock_cfd.fluid import FluidScene
    from comotion_protocol.messages import OpenReply

NAME = "run"
EXAMPLES = """\
  comotion run float_box                            summary on the terminal
  comotion run channel --out out/channel            and tables, plot, ParaView series, picture
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
    parser.add_argument("--out", metavar="DIR", type=Path, help="write tables, plot, series, picture and summary here")
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

        with waiting("starting the server (its first start on a machine compiles the kernels)"):
            ready = server.wait_until_ready()
        scene = overridden(load_fluid_scene(path), options)
        subject = _subject(ready, scene, options)
        try:
            with TimedMotion.open(
                ready.run, ready.endpoint, wants=wants(options.sample), dt=scene.dt, name="comotion run"
            ) as motion:
                play = Play(motion, scene, interrupts)
                return _play(play, motion.opened, subject, options.out)
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
    return Subject(ready.motion, level, body or min(as_told, default=None), options.window)


def _play(play: "Play", opened: "OpenReply", subject: "Subject", folder: Path | None) -> tuple["Summary", list[str]]:
    """Play the client; write everything there is to write, as far as an interrupt allows."""
    from comotion.commands.play import Interrupted
    from comotion.outputs.run_outputs import RunOutputs

    if folder is None:
        return play.to_the_end(), []
    with closing(RunOutputs(folder, opened, subject)) as outputs:
        try:
            summary = play.to_the_end(outputs.add)
        except Interrupted as stop:
            outputs.write_summary(stop.summary.as_data())
            raise
        outputs.draw()
        outputs.write_summary(summary.as_data())
        return summary, outputs.notes
