"""The command `comotion`: reads the command line, runs one command, turns mistakes into plain words.

Exit codes: 0 done; 1 it ran, with a bad outcome (a blocked or interrupted run, a scene with problems, a peer that
died); 2 wrong use or input that cannot be used. Nothing heavy is imported here or by the commands' modules: each
command imports what it needs when it runs, so that `comotion --help` answers at once.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from typing import Any

from comotion.commands import check, completion, mock, plan, report, run, serve, watch
from comotion.commands.arguments import closest
from comotion.commands.errors import explain

COMMANDS = (run, serve, mock, watch, check, plan, report, completion)

DESCRIPTION = "Motion and collisions of rigid bodies of any shape, as a co-simulation server for CFD solvers."
EPILOG = """\
SCENE is a TOML file or the name of a shipped scene.

examples:
  comotion run float_box               server and mock CFD client on this machine, summary at the end
  comotion run channel --out out/ice   the same with a report, pictures, an animation, tables, ParaView series
  comotion watch --run channel         see a running server live in the browser
  comotion check my_scene.toml         is my scene sound?
  comotion COMMAND --help              options and examples of one command

exit codes: 0 done, 1 ran but with a bad outcome, 2 wrong use or input
"""


class ShowVersion(argparse.Action):
    """Print the version; looked up only when it is asked for."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """What argparse calls when it meets the option."""
        from importlib.metadata import version

        print(f"comotion {version('comotion')}")
        parser.exit()


def build_parser() -> argparse.ArgumentParser:
    """The whole command line."""
    parser = argparse.ArgumentParser(
        prog="comotion",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action=ShowVersion, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, title="commands")
    for command in COMMANDS:
        command.add_to(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    parser = build_parser()
    names = [command.NAME for command in COMMANDS]
    if arguments and not arguments[0].startswith("-") and arguments[0] not in names:
        parser.error(f"there is no command {arguments[0]!r}{closest(arguments[0], names)}; allowed: {', '.join(names)}")
    return _execute(parser.parse_args(arguments))


def _execute(options: argparse.Namespace) -> int:
    try:
        code: int = options.execute(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        print("comotion: interrupted", file=sys.stderr)
        return 1
    except BrokenPipeError:  # the reader of our output went away, as in `comotion plan channel | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as error:
        known = explain(error)
        if known is None:
            raise
        print(known.text, file=sys.stderr)
        return known.exit_code
    return code
