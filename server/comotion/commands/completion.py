"""`comotion completion`: tab completion for a shell."""

import argparse
from typing import Any

from comotion.commands.arguments import add_command

NAME = "completion"
EXAMPLES = """\
  comotion completion bash > ~/.local/share/bash-completion/completions/comotion
  comotion completion zsh > ~/.zfunc/_comotion
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "print a completion script for a shell"
    parser = add_command(commands, NAME, summary, "Print a script that completes comotion's command line.", EXAMPLES)
    parser.add_argument("shell", choices=("bash", "zsh"), help="which shell")
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Print the script."""
    import shtab

    from comotion.main import build_parser

    print(shtab.complete(build_parser(), shell=options.shell))
    return 0
