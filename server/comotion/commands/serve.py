"""`comotion serve`: the server, until it is told to stop."""

import argparse
import json
import threading
from typing import TYPE_CHECKING, Any

from comotion.commands.arguments import add_command, add_json, add_network, add_scene, scene_path
from comotion_protocol.zenoh_settings import DEFAULT_ENDPOINT

if TYPE_CHECKING:
    from comotion_server.simulation import Simulation

NAME = "serve"
EXAMPLES = """\
  comotion serve channel
  comotion serve my_scene.toml --run ice --listen tcp/127.0.0.1:7450
  comotion serve channel --connect tcp/127.0.0.1:7447                       (to a zenoh router)
  comotion serve channel --listen tcp/0.0.0.0:7447 --insecure               (a private network)

Stop it with Ctrl-C or SIGTERM. exit codes: 0 stopped; 2 wrong use, a scene or an endpoint that cannot be used
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "serve a scene to a CFD client"
    description = "Load a scene and serve it to a CFD client until stopped; prints one line when clients can open."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    add_scene(parser)
    parser.add_argument(
        "--run", metavar="NAME", help="name of the run, by which clients ask (default: the scene's name)"
    )
    parser.add_argument("--listen", metavar="E", help=f"endpoint to listen on (default: {DEFAULT_ENDPOINT})")
    parser.add_argument("--connect", metavar="E", help="endpoint of a zenoh router to connect to")
    add_network(parser)
    stop = "stop when standard input ends, for a program that starts a server and must not leave it behind"
    parser.add_argument("--stop-with-stdin", action="store_true", help=stop)
    add_json(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Load, serve, stop."""
    from comotion.stop_signals import Interrupts, stop_with_stdin

    stop = threading.Event()
    if options.stop_with_stdin:
        stop_with_stdin(stop)
    try:
        with Interrupts():
            _serve(options, stop)
    except KeyboardInterrupt:
        return 0
    return 0


def _serve(options: argparse.Namespace, stop: threading.Event) -> None:
    path = scene_path(options.scene)
    from comotion.progress import waiting
    from comotion_server.serving import serve
    from comotion_server.simulation import Simulation
    from comotion_server.warm_up import warm_up

    with waiting("loading the scene (a first start on a machine compiles the kernels: one to three minutes)"):
        simulation = Simulation.load(path)
        warm_up(simulation.scene)
    run = options.run or simulation.scene.name
    serve(
        simulation,
        run,
        None if options.listen is None else [options.listen],
        () if options.connect is None else (options.connect,),
        zenoh_config=options.zenoh_config,
        allow_insecure=options.insecure,
        stop=stop,
        on_ready=lambda: print(_ready_line(options, run, simulation), flush=True),
    )


def _ready_line(options: argparse.Namespace, run: str, simulation: "Simulation") -> str:
    """One line, and the only one: where to find the run, and how each body moves."""
    at_router = options.connect if options.listen is None else None
    endpoint = options.listen or at_router or DEFAULT_ENDPOINT
    if options.json:
        with_surface = [body for members in simulation.scene.regions.values() for body in members]
        motion = {body.name: type(body.motion).__name__.lower() for body in with_surface}
        return json.dumps({"ready": True, "run": run, "endpoint": endpoint, "motion": motion})
    place = f"through {endpoint}" if at_router else f"on {endpoint}"
    return f"comotion: run {run!r} is served {place}; stop with Ctrl-C"
