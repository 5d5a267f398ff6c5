"""`comotion watch`: a running server live, or a recorded run, in a browser page or as a table in the terminal."""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from comotion.commands.arguments import add_command, add_network, count, positive
from comotion.commands.errors import BAD_OUTCOME, UserError
from comotion_protocol.zenoh_settings import DEFAULT_ENDPOINT

if TYPE_CHECKING:
    from comotion.watching.page_server import Source

NAME = "watch"
EXAMPLES = """\
  comotion watch --run channel                    prints the address of a page on this machine; open it in a browser
  comotion watch --run channel --table            a table in the terminal
  comotion watch --run ice --connect tcp/127.0.0.1:7450 --open
  comotion watch --replay out/channel             the same page plays what `comotion run --out` recorded

The server works for watchers only while one is there: while a page is open, or the table runs. Stop with Ctrl-C.
exit codes: 0 done; 1 no server, or it went away; 2 wrong use, nothing recorded
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "see a run: live, or recorded"
    description = "Watch a running server without taking part, or replay a recorded run."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--run", metavar="NAME", help="name of the run that a server serves")
    what.add_argument("--replay", metavar="DIR", type=Path, help="folder that `comotion run --out` wrote")
    parser.add_argument("--connect", metavar="E", help=f"endpoint of the server (default: {DEFAULT_ENDPOINT})")
    parser.add_argument("--table", action="store_true", help="a table in the terminal instead of a page")
    parser.add_argument("--port", metavar="P", type=count, default=0, help="port of the page (default: a free one)")
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument("--seconds", metavar="S", type=positive, help="end after this time (default: at Ctrl-C)")
    add_network(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Watch until told to stop."""
    if options.table and options.replay is not None:
        raise UserError("--table shows a running server: give it with --run")
    end = None if options.seconds is None else time.monotonic() + options.seconds
    try:
        return _watch(options, lambda: end is not None and time.monotonic() >= end)
    except KeyboardInterrupt:
        return 0


def _watch(options: argparse.Namespace, is_over: Callable[[], bool]) -> int:
    if options.replay is not None:
        from comotion.watching.replay_source import ReplaySource

        for needed in ("bodies.vtkhdf", "impacts.csv"):
            if not (options.replay / needed).is_file():
                raise UserError(f"--replay: there is no {needed} in {options.replay}; `comotion run --out` writes it")
        try:
            source = ReplaySource(options.replay)
        except (OSError, KeyError) as error:
            text = f"--replay: {options.replay} was not written by this version of `comotion run --out`: {error}"
            raise UserError(text) from None
        _serve(source, options, is_over)
        return 0
    from comotion_protocol.watch_client import WatchClient

    with WatchClient(
        options.run, options.connect, zenoh_config=options.zenoh_config, allow_insecure=options.insecure
    ) as client:
        if options.table:
            from comotion.watching.table import show_table

            show_table(client, is_over)
        else:
            from comotion.watching.live_source import LiveSource

            _serve(LiveSource(client), options, lambda: is_over() or not client.server_is_there)
        return 0 if client.server_is_there else _gone(options.run)


def _serve(source: "Source", options: argparse.Namespace, is_over: Callable[[], bool]) -> None:
    from importlib.util import find_spec

    if find_spec("websockets") is None:
        raise UserError("the page needs websockets: pip install 'comotion[view]'; or use --table")
    from comotion.watching.page_server import PageServer

    try:
        server = PageServer(source, options.port)
    except OSError as error:
        raise UserError(f"--port: {options.port} cannot be used: {error.strerror}") from None
    print(f"comotion: the page is at {server.address}; stop with Ctrl-C", flush=True)
    if options.open:
        import webbrowser

        webbrowser.open(server.address)
    server.run(is_over)


def _gone(run: str) -> int:
    import sys

    print(f"comotion: the server of run {run!r} is gone", file=sys.stderr)
    return BAD_OUTCOME
