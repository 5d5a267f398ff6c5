"""`comotion mock`: the mock CFD client against any server."""

import argparse
from typing import Any

from comotion.commands.arguments import (
    add_command,
    add_json,
    add_network,
    add_play,
    add_scene,
    positive,
    scene_path,
)
from comotion_protocol.zenoh_settings import DEFAULT_ENDPOINT

NAME = "mock"
EXAMPLES = """\
  comotion mock float_box --run float_box
  comotion mock channel --run ice --connect tcp/127.0.0.1:7450 --duration 1
  comotion mock channel --run ice --connect tcp/server:7447 --insecure     (a private network)

exit codes: 0 done; 1 blocked, interrupted, no server or a dead one; 2 wrong use or a scene that cannot be used
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "run the mock CFD client against a server"
    description = "Play the CFD solver's side of a scene (its [fluid] table) against a running server."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    add_scene(parser)
    parser.add_argument("--run", required=True, metavar="NAME", help="name of the run that the server serves")
    connect = f"endpoint of the server, or of a zenoh router (default: {DEFAULT_ENDPOINT})"
    parser.add_argument("--connect", metavar="E", default=DEFAULT_ENDPOINT, help=connect)
    wait = "how long to wait for the server to be there [s] (default: 5)"
    parser.add_argument("--wait", metavar="S", type=positive, default=5.0, help=wait)
    add_network(parser)
    add_play(parser)
    add_json(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Connect, play, tell how it was."""
    path = scene_path(options.scene)
    from comotion.commands.play import Interrupted, Play, overridden, tell
    from comotion.fluid_scene import load_fluid_scene
    from comotion.stop_signals import Interrupts
    from comotion.timed_motion import TimedMotion
    from comotion_mock_cfd.cfd_client import wants

    scene = overridden(load_fluid_scene(path), options)
    try:
        with (
            Interrupts() as interrupts,
            TimedMotion.open(
                options.run,
                options.connect,
                wants=wants(options.sample),
                dt=scene.dt,
                name="comotion mock",
                connect_timeout=options.wait,
                zenoh_config=options.zenoh_config,
                allow_insecure=options.insecure,
            ) as motion,
        ):
            summary = Play(motion, scene, interrupts).to_the_end()
    except Interrupted as stop:
        summary = stop.summary
    return tell(summary, options)
