"""`comotion report`: error against run time, stiff and extreme cases, what is left out, and how cost grows."""

import argparse
import json
from pathlib import Path
from typing import Any

from comotion.commands.arguments import add_command, add_json, closest
from comotion.commands.errors import BAD_OUTCOME, UserError

NAME = "report"
EXAMPLES = """\
  comotion report --out out/report         everything, up to an hour
  comotion report --quick                  everything in small, two minutes
  comotion report attitude extreme         some of it
"""


def add_to(commands: Any) -> None:
    """Add the command's options."""
    summary = "measure this machine: error against run time, extreme cases, what is left out"
    description = "Measure and write tables (JSON, Markdown) and figures (PNG, SVG) to a folder."
    parser = add_command(commands, NAME, summary, description, EXAMPLES)
    parser.add_argument("study", metavar="NAME", nargs="*", help="studies (default: all)")
    parser.add_argument("--out", metavar="DIR", type=Path, default=Path("out/report"), help="default: out/report")
    parser.add_argument("--quick", action="store_true", help="small sizes: at most two minutes, figures are rough")
    add_json(parser)
    parser.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run the studies one after the other; a study that fails does not keep the others from running."""
    from comotion.report.runner import run_studies
    from comotion.report.study import STUDIES

    known = {study.name: study for study in STUDIES}
    for name in options.study:
        if name not in known:
            raise UserError(f"there is no study {name!r}{closest(name, known)}; allowed: {', '.join(known)}")
    chosen = [known[name] for name in options.study] or list(STUDIES)
    outcomes = run_studies(chosen, options.out, quick=options.quick)
    if options.json:
        print(
            json.dumps({"folder": str(options.out), "studies": [outcome.as_data() for outcome in outcomes]}, indent=2)
        )
    else:
        for outcome in outcomes:
            print(f"{outcome.study.name:<13} {outcome.seconds:6.1f} s  {outcome.error or 'done'}")
        print(f"written to {options.out}")
    return BAD_OUTCOME if any(outcome.error for outcome in outcomes) else 0
