"""Ten thousand random clusters given straight to the impact law: energy, books, numbering, repeats, reflections, time.

    python benchmarks/impact_clusters.py [--quick] [--friction MU] [--sequential]

Seven kinds: elastic, mixed restitution, mass ratio 1e10, every second contact twice, locked axes, moving given bodies,
and all of these at once. Exit code 1 if a bar is missed. Clusters are those of the tests, 2 to 8 bodies, 1 to 15 contacts.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from clusters_by_hand import answer
from random_clusters import KINDS, Audit, audit, random_clump

from comotion_server.kernels.impact_cluster import SEQUENTIAL, TOGETHER

BARS = {"growth": 1e-14, "book": 1e-12, "numbering": 1e-12}
STATUS = ("solved", "capped", "jammed", "blocked")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="700 clusters")
    parser.add_argument("--friction", type=float, default=0.0)
    parser.add_argument("--sequential", action="store_true")
    options = parser.parse_args()
    law, each = SEQUENTIAL if options.sequential else TOGETHER, 100 if options.quick else 1429
    print(f"{each} clusters of each kind")
    print(f"{'kind':12}{'growth':>9}{'book':>9}{'momentum':>9}{'number.':>9}{'closing':>9} bits"
          "  solved/capped/jammed/blocked  reflections med/p99/max  us med/p99")  # fmt: skip
    missed = False
    for kind in KINDS:
        rng, worst, status, reflections, times = np.random.default_rng(7), Audit(), [0] * 4, [], []
        for _ in range(each):
            clump = random_clump(rng, kind, options.friction)
            seen = audit(clump, rng, law)
            status[seen.status] += 1
            reflections.append(seen.reflections)
            worst.add(seen)
            start = time.perf_counter()
            answer(clump, law)
            times.append(1e6 * (time.perf_counter() - start))
        figures = "".join(
            f"{getattr(worst, k):9.1e}" for k in ("growth", "book", "momentum", "numbering", "closing")
        )
        median, rare = np.percentile(reflections, [50, 99])
        us, slow = np.percentile(times, [50, 99])
        print(f"{kind:12}{figures} {'same' if worst.repeats else 'DIFFER'}  "
              f"{'/'.join(map(str, status)):>28}  {median:.0f}/{rare:.0f}/{max(reflections)}  {us:.0f}/{slow:.0f}",
              flush=True)  # fmt: skip
        missed |= not (worst.repeats and worst.same_status)
        missed |= any(getattr(worst, k) > bar for k, bar in BARS.items() if k != "numbering" or law == TOGETHER)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
