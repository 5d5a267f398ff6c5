"""Random clusters for the impact law: mixed restitution and masses, locks, given motion, rows twice."""

from dataclasses import dataclass

import numpy as np
from clusters_by_hand import Clump, answer

from comotion_server.kernels.flight import SPIN_FREE, SPIN_NONE
from comotion_server.kernels.impact_cluster import BLOCKED, TOGETHER, WORK

KINDS = ("elastic", "mixed", "ratio", "twice", "locks", "given", "everything")


def turned(rng):
    """A random rotation."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.linalg.det(q)


def random_clump(rng, kind, mu=0.0):
    """Between 2 and 8 bodies with 1 to 15 contacts."""
    clump, n = Clump(), int(rng.integers(2, 9))
    heavy = 10.0 if kind in ("ratio", "everything") else 1.0
    locks, given = kind in ("locks", "everything"), kind in ("given", "everything")
    for i in range(n):
        v, w = rng.normal(size=3), rng.normal(size=3)
        if i == 0 and (given or rng.random() < 0.3):
            clump.given(v if given else (0, 0, 0), w if given else (0, 0, 0))
            continue
        mass = 10.0 ** rng.uniform(-0.5, 0.5 if heavy == 1.0 else heavy - 0.5)
        moments = mass * rng.uniform(0.05, 0.15) * (1.0 + 0.4 * rng.random(3))
        free, spin = (1, 1, 1), SPIN_FREE
        if locks and rng.random() < 0.6:
            free = rng.integers(0, 2, 3)
            spin = int(rng.integers(SPIN_NONE, 3))
            v = v * free
            w = w * ([1, 1, 1] if spin == SPIN_FREE else [spin == k for k in range(3)])
        clump.body(mass, moments, v, w, free=free, spin=spin, R=turned(rng))
    count = int(rng.integers(1, 16))
    e = rng.choice([0.0, 0.3, 0.7, 1.0, rng.random()], size=count) if kind != "elastic" else np.ones(count)
    if kind == "twice":
        e[:] = rng.choice([0.0, 0.5])
    while len(clump.rows) < count:
        a, b = sorted(rng.choice(n, 2, replace=False).tolist())
        row = (a, b, rng.normal(size=3), e[len(clump.rows)], rng.normal(size=3) * 0.4, rng.normal(size=3) * 0.4, mu)
        for _ in range(2 if kind in ("twice", "everything") and rng.random() < 0.5 else 1):
            clump.touch(*row)
    clump.restitution = clump.restitution[: len(clump.rows)]
    return clump


def renumbered(clump, rng):
    """The same cluster with bodies and contacts in another order; and where each body went."""
    n, order = len(clump.mass), rng.permutation(len(clump.mass))
    place, other = np.empty(n, int), Clump()
    for new, old in enumerate(order):
        place[old] = new
        for column in ("mass", "moments", "reacts", "free", "spin", "v", "w", "R"):
            getattr(other, column).append(getattr(clump, column)[old])
    for i in rng.permutation(len(clump.rows)):
        a, b, normal, arm_a, arm_b = clump.rows[i]
        a, b = place[a], place[b]
        if a > b:
            a, b, normal, arm_a, arm_b = b, a, -normal, arm_b, arm_a
        other.rows.append((a, b, normal, arm_a, arm_b))
        other.restitution.append(clump.restitution[i])
        other.friction.append(clump.friction[i])
    return other, place


@dataclass
class Audit:
    """The worst of what was seen, each relative to its scale."""

    growth: float = -np.inf  # of energy beyond the work of given motion
    book: float = 0.0  # change of energy against work - lost
    momentum: float = 0.0  # of each body against its impulses
    closing: float = 0.0  # speed at which a contact still closes, to the fastest approach
    numbering: float = 0.0  # other velocities when bodies and contacts come in another order
    repeats: bool = True  # to the bit
    same_status: bool = True  # in another order
    reflections: int = 0
    status: int = 0

    def add(self, other):
        for name, value in vars(other).items():
            better = min if isinstance(value, bool) else max
            setattr(self, name, better(getattr(self, name), value))


def opening_speeds(clump, v, w):
    """Of all contacts of a clump."""
    return np.array([
        n @ (v[b] + np.cross(w[b], arm_b) - v[a] - np.cross(w[a], arm_a)) for a, b, n, arm_a, arm_b in clump.rows
    ])  # fmt: skip


def audit(clump, rng, law=TOGETHER):
    """The books of one impact, and the same impact once more and renumbered."""
    other, place = renumbered(clump, rng)
    one, again, two = answer(clump, law), answer(clump, law), answer(other, law)
    seen = Audit(status=one.status, same_status=one.status == two.status)
    if BLOCKED in (one.status, two.status):
        return seen
    seen.repeats = all(np.array_equal(getattr(one, k), getattr(again, k)) for k in ("v", "L", "w", "impulse"))
    lost, work = one.report.book.sum() - one.report.book[WORK], one.report.book[WORK]
    scale, mass = one.scale + abs(work), np.array(clump.mass)[:, None]
    reacts = np.array(clump.reacts)[:, None]
    seen.growth, seen.book = (one.growth - work) / scale, abs(one.growth - work + lost) / scale
    seen.numbering = np.abs((two.v[place] - one.v) * np.sqrt(mass) * reacts).max() / np.sqrt(2 * scale)
    closing = -opening_speeds(clump, one.v, one.w).min()
    seen.closing = closing / max(np.abs(one.report.approach).max(), 1e-30)
    given = np.zeros((len(mass), 3))
    for (a, b, *_), J in zip(clump.rows, one.impulse, strict=True):
        given[a] -= J
        given[b] += J
    free = np.array(clump.free) * reacts
    before = mass * np.array(clump.v) * free
    size = np.abs(before).max() + np.abs(one.impulse).max() + 1e-300
    seen.momentum = np.abs((mass * one.v * free - before) - given * free).max() / size
    seen.reflections = int(one.report.reflections[0])
    return seen
