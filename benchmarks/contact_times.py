"""Contact times: never missed and never late, and how long they take beside other ways.

    python benchmarks/contact_times.py [--quick] [--cases N] [--linear N]

1. N random cases (tumbling, L shapes, linked tori, bullets through thin walls, rods at 1e5 rad/s) against dense
   sampling of intersection (`tests/contact_cases.py`): none missed, none late, the gap in (0, tolerance], the contact
   time right to 1e-9 wherever it does not graze.
2. Two tumbling bodies under constant accelerations and torques, coarse to fine, on one thread: beside plain
   conservative advancement and the paper's rule at N = 4, on the same flights and with the same warm distance. The
   parties take turns, and of each its least time over the rounds counts. A miss of the paper's rule is a contact that
   it does not report, or reports late.
3. Linear vertex-face and edge-edge motion, exact in rational numbers (`tests/exact_motion.py`), beside ipctk's
   Tight-Inclusion and additive CCD. Theirs are called from Python one by one, about 5 us each, get 15 s, and are asked
   the general families only: coplanar and parallel ones take them minutes each. Brackets: queries answered.

Targets: no fault in 1 and 3; at most 0.6 of the time of conservative advancement, and faster than the paper's rule, as
geometric means. Exit code 1 if one is missed.
"""

import argparse
import sys
import time
from collections import Counter
from math import inf
from pathlib import Path

import numpy as np
from contact_peers import Ipctk, ipctk_queries, repeat_conservative, repeat_ours, repeat_prediction
from geometry_shapes import ball, spring, torus

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from contact_cases import FAMILIES, faults
from exact_motion import queries
from meshes_by_hand import l_shape
from triangle_families import turn

from comotion_server.geometry import Motion, time_of_impact
from comotion_server.geometry.contact_time import default_tolerance, near_distance
from comotion_server.geometry.motion import flights_of
from comotion_server.geometry.prepared_pair import arrays_of
from comotion_server.kernels.impact_query import COUNTS, PAIRS, STEPS, WINDOWS
from comotion_server.kernels.linear_impact import linear_impacts
from comotion_server.kernels.pair_window import new_work
from comotion_server.meshes import TriangleMesh, box

SHARES = {"convex": 0.3, "ell": 0.3, "linked": 0.25, "bullet": 0.03, "fast spin": 0.12}
REPEATS = 10
GENERAL = ("vertex face", "edge edge", "vertex on edge of face", "edge on end of edge")
PATIENCE = 15.0  # [s] for ipctk's queries: on degenerate ones it takes up to seconds each
PARTS = 4  # N of the paper's rule
AGAINST_ADVANCEMENT, AGAINST_PAPER = 0.6, 1.0
LINEAR_TOLERANCE = 2.0**-30


def random_cases(count):
    """A row per family; whether no case was at fault."""
    print(f"{'family':<12} {'cases':>6} {'contacts':>9} {'plain':>6} {'faults':>7}  ends")
    good = True
    for name, share in SHARES.items():
        rng, found, ends, plain = np.random.default_rng(101), [], Counter(), 0
        cases = max(1, round(share * count))
        for _ in range(cases):
            case = FAMILIES[name](rng)
            answer = time_of_impact(*case.query)
            wrong, steep = faults(case, answer, default_tolerance(*case.query))
            found += wrong
            plain += steep
            ends[answer.status] += 1
        contacts = ends["hit"] + ends["touching"]
        print(f"{name:<12} {cases:6} {contacts:9} {plain:6} {len(found):7}  {dict(ends)} {found[:2] or ''}", flush=True)
        good &= not found
    return good


def shapes():
    """Pairs of meshes, coarse to fine; about their centres."""
    turned = TriangleMesh(l_shape().vertices, l_shape().triangles)
    return {
        "boxes": (box([1.0, 0.8, 0.6]), box([0.5, 1.2, 0.7])),
        "L shapes": (l_shape(), turned),
        "balls 128": (ball(2), ball(2, stretch=(1.0, 0.7, 0.5))),
        "tori 200": (torus(10, 10), torus(10, 10, tube=0.2)),
        "tori 1000": (torus(25, 20), torus(25, 20, tube=0.2)),
        "rough 2048": (ball(4, 0.02), ball(4, 0.02, (1.0, 0.8, 0.6))),
        "springs 2000": (spring(3, 100, 10), spring(3, 100, 10)),
        "balls 8192": (ball(5), ball(5, stretch=(1.0, 0.7, 0.5))),
        "tori 10000": (torus(100, 50), torus(100, 50, tube=0.2)),
        "box on ball 8192": (box([0.7, 0.9, 0.5]), ball(5)),
    }


def throw(rng, meshes):
    """Motions that meet with some luck: towards each other, tumbling, one under a held torque."""
    n = rng.normal(size=3)
    n *= 0.5 * (meshes[0].size + meshes[1].size) / np.linalg.norm(n) * rng.uniform(1.0, 1.5)
    inertia = np.diag([0.3, 0.4, 0.5])
    one = Motion((turn(rng), np.zeros(3)), 0.2 * rng.normal(size=3), rng.normal(size=3), 0.3 * rng.normal(size=3))
    spin = {"angular_velocity": rng.normal(size=3), "inertia": inertia, "torque": 0.1 * rng.normal(size=3)}
    return one, Motion((turn(rng), n), -n * rng.uniform(0.7, 1.5) + 0.1 * rng.normal(size=3), **spin)


class Parties:
    """The three ways on one case; each is repeated in compiled code, so that calls from Python do not count."""

    def __init__(self, meshes, motions, t_max):
        self.m, self.b = arrays_of(*meshes)
        self.flights, self.bodies = flights_of(motions)
        self.end, self.work = t_max, new_work()
        self.tolerance = default_tolerance(meshes[0], motions[0], meshes[1], motions[1], t_max)
        self.near = min(map(near_distance, meshes))

    def ours(self, repeats):
        self.counts = np.zeros(COUNTS, np.int64)
        arguments = (self.m, self.flights, self.bodies, self.b, self.end, self.tolerance, self.near)
        return repeat_ours(*arguments, self.work, self.counts, repeats)

    def conservative(self, repeats):
        arguments = (self.m, self.flights, self.bodies, self.b, self.end, self.tolerance)
        return repeat_conservative(*arguments, self.work, repeats)

    def paper(self, repeats):
        arguments = (self.m, self.flights, self.bodies, self.b, self.end, self.tolerance, PARTS)
        return repeat_prediction(*arguments, self.work, repeats)


def clock(run):
    begin = time.perf_counter()
    result = run(REPEATS)
    return (time.perf_counter() - begin) / REPEATS, *result


def timed(meshes, count, rounds, seed):
    """Means of least times [s], distance queries and our counts over `count` cases that meet; misses of P10."""
    rng, spent, asked, counts, misses, done = np.random.default_rng(seed), np.zeros(3), np.zeros(3), 0, 0, 0
    while done < count:
        parties = Parties(meshes, throw(rng, meshes), 2.0)
        contact, _ = parties.ours(1)
        if contact in {0.0, inf}:
            continue
        done += 1
        runs = (parties.ours, parties.conservative, parties.paper)
        measured = np.array([[clock(run) for run in runs] for _ in range(rounds)])
        spent += measured[:, :, 0].min(axis=0)
        asked += measured[0, :, 2]
        counts = counts + parties.counts
        assert abs(measured[0, 1, 1] - contact) < 1e-6
        misses += measured[0, 2, 1] > measured[0, 0, 1] + 1e-6
    return spent / count, asked / count, counts / count, misses


def race(quick):
    """A row per pair of shapes; whether the targets of time are met."""
    print(f"\n{'bodies':<18} {'ours':>7} {'CA':>7} {'P10':>7} [us]  ours/CA  /P10", end="")
    print("   distances of all three   windows, pairs, steps of ours")
    ratios, missed, count = [], 0, 6 if quick else 20
    for name, meshes in shapes().items():
        spent, asked, counts, misses = timed(meshes, count, 3 if quick else 5, 7)
        ratios.append((spent[0] / spent[1], spent[0] / spent[2]))
        missed += misses
        us = " ".join(f"{1e6 * s:7.0f}" for s in spent)
        pairs = f"{counts[WINDOWS]:6.1f} {counts[PAIRS]:6.0f} {counts[STEPS]:6.0f}"
        queries_made = " ".join(f"{q:5.0f}" for q in asked)
        print(
            f"{name:<18} {us}       {ratios[-1][0]:6.2f} {ratios[-1][1]:5.2f}   {queries_made:>22}   {pairs}",
            flush=True,
        )
    against_advancement, against_paper = np.exp(np.log(ratios).mean(axis=0))
    print(
        f"geometric means: {against_advancement:.2f} of conservative advancement (at most {AGAINST_ADVANCEMENT}), ",
        end="",
    )
    print(f"{against_paper:.2f} of the paper's rule at N = {PARTS} (below {AGAINST_PAPER}),", end=" ")
    print(f"which missed {missed} of {count * len(ratios)} contacts")
    return against_advancement <= AGAINST_ADVANCEMENT and against_paper < AGAINST_PAPER


def linear(count):
    """A row per party on linear motion; whether ours is without a fault."""
    a, b, velocity_a, velocity_b, when, names = queries(np.random.default_rng(3), count)
    status, ours = np.empty(count, np.int64), np.empty(count)
    arguments = (a, b, velocity_a, velocity_b, 1.0, LINEAR_TOLERANCE, status, ours)
    linear_impacts(*arguments)
    truth = np.array([float(t) for t in when])
    print(f"\n{count} contacts of vertices, faces and edges     us   missed   late   median of (truth - time)")
    begin = time.perf_counter()
    linear_impacts(*arguments)
    spent = time.perf_counter() - begin
    hit = status == 1
    report("ours", spent / count, hit, ours, truth)
    good = bool(hit.all() and (ours <= truth).all())
    general = np.isin(names, GENERAL)
    asked, truth = ipctk_queries(a[general], b[general], velocity_a[general], velocity_b[general]), truth[general]
    for name in ("tight inclusion", "additive"):
        found, times = np.zeros(len(asked), bool), np.empty(len(asked))
        answered, spent = Ipctk(name).run(asked, found, times, PATIENCE)
        done = slice(answered)
        report(f"ipctk, {name} ({answered})", spent / answered, found[done], times[done], truth[done])
    return good


def report(name, seconds, hit, times, truth):
    early = np.median((truth - times)[hit])
    print(
        f"{name:<40} {1e6 * seconds:8.1f} {np.sum(~hit):8} {np.sum(times[hit] > truth[hit]):6} {early:12.1e}",
        flush=True,
    )


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--quick", action="store_true", help="fewer cases and rounds")
    options.add_argument("--cases", type=int, help="random cases (1000; quick: 100)")
    options.add_argument("--linear", type=int, help="linear queries (10000; quick: 1200)")
    chosen = options.parse_args()
    good = random_cases(chosen.cases or (100 if chosen.quick else 1000))
    good &= race(chosen.quick)
    good &= linear(chosen.linear or (1200 if chosen.quick else 10_000))
    print("\nall targets met" if good else "\nTARGET MISSED")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
