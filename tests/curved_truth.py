"""Distances of curved shapes in arithmetic of 50 digits, by means that share nothing with the kernels.

Convex bodies: weak duality. Any two points of the bodies are at least as far apart as the bodies are, and for any unit
vector n the bodies are at least n . D - h_a(n) - h_b(-n) apart, with h how far a body reaches from its centre. Where
the two agree, both are the distance. A plane reaches no farther than itself along its own normal only.

Pipes: the least distance from a body's points to the rectangles that the pipe turns about its axis, searched for on a
fine grid and narrowed by golden sections.
"""

from dataclasses import dataclass

import mpmath as mp
import numpy as np

PLANE, SPHERE, CAPSULE, CYLINDER, PIPE = 1, 2, 3, 4, 5
DIGITS = 50
GOLDEN = (mp.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class Posed:
    """A shape somewhere: as `curved_gap` takes it."""

    kind: int
    size: tuple
    axis: tuple
    x: np.ndarray
    R: np.ndarray

    @property
    def arguments(self):
        return self.kind, np.array(self.size, dtype=float), np.array(self.axis, dtype=float), self.x, self.R

    @property
    def u(self):
        axis = mp.matrix([sum(mp.mpf(float(self.R[i, k])) * mp.mpf(self.axis[k]) for k in range(3)) for i in range(3)])
        return axis / mp.norm(axis)


def vector(v):
    return mp.matrix([mp.mpf(float(c)) for c in v])


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def across(v, u):
    return v - dot(v, u) * u


def reach(shape, n):
    """How far a convex shape reaches from its centre along n."""
    r, h = mp.mpf(shape.size[0]), mp.mpf(shape.size[1])
    if shape.kind == PLANE:
        assert mp.norm(n - shape.u) < 1e-14, "a plane reaches nowhere along its normal alone"
        return mp.mpf(0)
    if shape.kind == SPHERE:
        return r
    if shape.kind == CAPSULE:
        return r + h * abs(dot(n, shape.u))
    return h * abs(dot(n, shape.u)) + r * mp.norm(across(n, shape.u))


def outside(shape, p):
    """How far a point is from a convex shape: 0 on it and in it; a plane is solid below."""
    P, u = vector(p) - vector(shape.x), shape.u
    z, rho = dot(P, u), mp.norm(across(P, u))
    r, h = mp.mpf(shape.size[0]), mp.mpf(shape.size[1])
    if shape.kind == PLANE:
        return max(z, mp.mpf(0))
    if shape.kind == SPHERE:
        return max(mp.norm(P) - r, mp.mpf(0))
    if shape.kind == CAPSULE:
        return max(mp.hypot(rho, max(abs(z) - h, 0)) - r, mp.mpf(0))
    return mp.hypot(max(rho - r, 0), max(abs(z) - h, 0))


def bounds(a, b, p, q, n):
    """(lower, upper) bound of the distance of two convex shapes, shown by a direction and by two points."""
    with mp.workdps(DIGITS):
        direction = vector(n) / mp.norm(vector(n))
        if a.kind == PLANE:
            direction = a.u
        lower = dot(direction, vector(b.x) - vector(a.x)) - reach(a, direction) - reach(b, -direction)
        upper = mp.norm(vector(q) - vector(p)) + outside(a, p) + outside(b, q)
        return float(lower), float(upper)


def pipe_rectangles(size):
    inner, outer, half, caps = (mp.mpf(s) for s in size)
    solid = [(inner, outer, -half, half)]
    if caps:
        solid += [(mp.mpf(0), outer, half, half), (mp.mpf(0), outer, -half, -half)]
    return solid


def to_pipe(pipe, P):
    """Distance of a point (from the pipe's centre) to the pipe: 0 in the wall."""
    u = pipe.u
    z, rho = dot(P, u), mp.norm(across(P, u))
    return min(
        mp.hypot(max(lo - rho, rho - hi, 0), max(low - z, z - high, 0))
        for lo, hi, low, high in pipe_rectangles(pipe.size)
    )


def least(f, lo, hi, samples):
    """The least value of a function: the best of a grid, and of golden sections about its low points."""
    grid = [lo + (hi - lo) * mp.mpf(k) / samples for k in range(samples + 1)]
    values = [f(t) for t in grid]
    order = sorted(range(samples + 1), key=values.__getitem__)[:4]
    best = min(values)
    for k in order:
        a, b = grid[max(k - 1, 0)], grid[min(k + 1, samples)]
        for _ in range(75):
            c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
            if f(c) <= f(d):
                b = d
            else:
                a = c
        best = min(best, f((a + b) / 2))
    return best


def pipe_and_round(pipe, other, samples=120):
    """Distance of a pipe and a sphere or capsule."""
    with mp.workdps(DIGITS):
        D, radius = vector(other.x) - vector(pipe.x), mp.mpf(other.size[0])
        if other.kind == SPHERE:
            return float(to_pipe(pipe, D) - radius)
        M = mp.mpf(other.size[1]) * other.u
        return float(least(lambda t: to_pipe(pipe, D + t * M), mp.mpf(-1), mp.mpf(1), samples) - radius)


def pipe_and_rims(pipe, cylinder, samples=60):
    """Distance of a closed pipe and a cylinder inside of it: convex in a cavity, so its rims are nearest."""
    with mp.workdps(DIGITS):
        D, v, r = vector(cylinder.x) - vector(pipe.x), cylinder.u, mp.mpf(cylinder.size[0])
        helper = mp.matrix([1, 0, 0]) if abs(v[0]) < 0.6 else mp.matrix([0, 1, 0])
        e = across(helper, v)
        e = e / mp.norm(e)
        f = mp.matrix([v[1] * e[2] - v[2] * e[1], v[2] * e[0] - v[0] * e[2], v[0] * e[1] - v[1] * e[0]])
        best = mp.inf
        for end in (-1, 1):
            c = D + end * mp.mpf(cylinder.size[1]) * v
            rim = lambda t, c=c: to_pipe(pipe, c + r * (mp.cos(t) * e + mp.sin(t) * f))
            best = min(best, least(rim, mp.mpf(0), 2 * mp.pi, samples))
        return float(best)
