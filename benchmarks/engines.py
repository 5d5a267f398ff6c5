"""Error against run time: comotion beside MuJoCo, Bullet and DART on the same scenes (`engine_cases.py`).

    python benchmarks/engines.py [--cases NAME ...] [--parties NAME ...] [--steps S ...] [--patience S] [--out DIR]

Every party runs every case at every step; wall time is that of advancing alone, start-up and compilation are not in it.
It prints a table and writes `engines.json` and, if matplotlib is there, `engines.png`. A run that takes longer than the
patience is ended and judged by how far it came. Steps [s] are the engines' own; those of comotion are coupling steps,
within which it finds the times of contact.
"""

import argparse
import json
import os
import platform
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
from engine_cases import CASES
from engine_parties import PARTIES

STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4)
COUPLING_STEPS = (1e-1, 1e-2, 1e-3)
MARKS = {"Comotion": "o-", "MuJoCo": "s--", "Bullet": "^--", "Dart": "v--"}


def run(case, party, dt, patience):
    """Wall time per simulated second, the error, and how many seconds were simulated."""
    every = 1 if case.samples is None else max(1, round(case.duration / dt / case.samples))
    now, spent, done = 0.0, 0.0, 0
    times, states = [now], [party.state()]
    while done < round(case.duration / dt) and spent < patience:
        begin = time.perf_counter()
        party.advance(every)
        spent += time.perf_counter() - begin
        done += every
        times.append(done * dt)
        states.append(party.state())
        if not np.isfinite(states[-1].position).all():
            return spent / times[-1], np.inf, times[-1]
    return spent / times[-1], case.error(case, times, states), times[-1]


def rows(options):
    """A dictionary for every run."""
    for name in options.cases:
        print(f"\n{name}: {CASES[name].__doc__ or ''}")
        print(f"{'party':<10} {'step [s]':>9} {'wall / s':>9} {'error':>10}   {CASES[name]().error_name}")
        for party in options.parties:
            for dt in options.steps or (COUPLING_STEPS if party == "Comotion" else STEPS):
                case = CASES[name]()
                wall, error, simulated = run(case, PARTIES[party](case, dt), dt, options.patience)
                short = "" if simulated >= case.duration - dt else f"   ended at {simulated:.3g} s"
                print(f"{party:<10} {dt:9g} {wall:9.3g} {error:10.2e}{short}", flush=True)
                numbers = {"wall_per_simulated_second": wall, "error": error, "simulated_s": simulated}
                yield {"case": name, "party": party, "dt_s": dt, "error_of": case.error_name} | numbers


def machine():
    """What the wall times depend on."""
    libraries = {name: version(name) for name in ("comotion", "numba", "numpy")}
    peers = {party.library: version(party.library) for party in PARTIES.values() if party.library != "comotion_server"}
    return (
        {"python": platform.python_version(), "cores": os.cpu_count(), "processor": platform.machine()}
        | libraries
        | peers
    )


def draw(path, found):
    """A panel for each case: error against wall time, a curve for each party."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    cases = list(dict.fromkeys(row["case"] for row in found))
    figure = Figure(figsize=(4.2 * len(cases), 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, case in zip(np.atleast_1d(figure.subplots(1, len(cases))), cases, strict=True):
        for party in dict.fromkeys(row["party"] for row in found):
            mine = [row for row in found if (row["case"], row["party"]) == (case, party)]
            walls, errors = ([row[key] for row in mine] for key in ("wall_per_simulated_second", "error"))
            axes.loglog(walls, np.maximum(errors, 1e-17), MARKS[party], label=party)
        axes.set_title(case)
        axes.set_xlabel("wall seconds per simulated second")
        axes.set_ylabel(next(row["error_of"] for row in found if row["case"] == case) + " error")
        axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--parties", nargs="+", choices=PARTIES, default=list(PARTIES))
    parser.add_argument("--steps", nargs="+", type=float, help="[s], of all parties (default: each its own)")
    parser.add_argument("--patience", type=float, default=60.0, help="[s] of wall time for one run (default: 60)")
    parser.add_argument("--out", type=Path, default=Path("out/engines"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    found = list(rows(options))
    table = {"machine": machine(), "runs": found}
    (options.out / "engines.json").write_text(json.dumps(table, indent=2) + "\n", encoding="utf-8")
    try:
        draw(options.out / "engines.png", found)
    except ImportError:
        print("engines.png is left out: matplotlib is not installed (pip install 'comotion[view]')")


if __name__ == "__main__":
    main()
