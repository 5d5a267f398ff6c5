"""Spheres in a pipe in decimal arithmetic, from impact to impact: the truth for the order and times of impacts.

Nothing of the server is used. Spheres fly straight, the pipe's axis is z, its ends may be closed, all impacts are
elastic and of two bodies each. Neighbouring orbits of convex bodies part exponentially: a digit is lost about every
dozen impacts, so 60 digits hold for hundreds.
"""

from decimal import Decimal, localcontext
from typing import Any

DIGITS = 60
TINY = Decimal("1e-40")  # [s]: the impact that has just been
NEVER = Decimal("Infinity")
WALL, TOP, BOTTOM = -1, -2, -3

Vector = list[Decimal]


def _dot(a: Vector, b: Vector) -> Decimal:
    return sum((p * q for p, q in zip(a, b, strict=True)), Decimal(0))


def _minus(a: Vector, b: Vector) -> Vector:
    return [p - q for p, q in zip(a, b, strict=True)]


def _first_root(a: Decimal, b: Decimal, c: Decimal) -> Decimal | None:
    """The first s > 0 of a s^2 + 2 b s + c = 0 at which it falls below zero; None: none."""
    square = b * b - a * c
    if square < 0:
        return None
    roots = sorted([(-b - square.sqrt()) / a, (-b + square.sqrt()) / a])
    falling = [s for s in roots if s > TINY and a * s + b < 0]
    return falling[0] if falling else None


class Spheres:
    """Equal spheres of unit mass in a pipe, at one time."""

    def __init__(self, x: Any, v: Any, radius: float, inner: float, half: float | None = None) -> None:
        """Centres x [m] and velocities v [m/s] (n,3), radii of spheres and bore [m], half length of a closed pipe."""
        self.x, self.v = ([[Decimal(float(c)) for c in row] for row in rows] for rows in (x, v))
        self.radius, self.inner = Decimal(radius), Decimal(inner)
        self.half = None if half is None else Decimal(half)
        self.time, count = Decimal(0), len(self.x)
        self.next: dict[tuple[int, int], Decimal] = {}
        with localcontext(prec=DIGITS):
            for i in range(count):
                self._look(i, range(i + 1, count))

    def event(self) -> tuple[Decimal, int, int]:
        """Goes on through the next impact: time [s], sphere, sphere or WALL, TOP, BOTTOM."""
        with localcontext(prec=DIGITS):
            (i, j), time = min(self.next.items(), key=lambda entry: entry[1])
            step, self.time = time - self.time, time
            for x, v in zip(self.x, self.v, strict=True):
                for k in range(3):
                    x[k] += step * v[k]
            self._bounce(i, j)
            for k in (i, j):
                if k >= 0:
                    self._look(k, range(len(self.x)))
            return time, i, j

    def _bounce(self, i: int, j: int) -> None:
        if j in {TOP, BOTTOM}:
            self.v[i][2] = -self.v[i][2]
            return
        n = [*self.x[i][:2], Decimal(0)] if j == WALL else _minus(self.x[i], self.x[j])
        against = self.v[i] if j == WALL else _minus(self.v[i], self.v[j])
        push = _dot(n, against) / _dot(n, n) * (2 if j == WALL else 1)
        self.v[i] = [p - push * q for p, q in zip(self.v[i], n, strict=True)]
        if j >= 0:
            self.v[j] = [p + push * q for p, q in zip(self.v[j], n, strict=True)]

    def _look(self, i: int, others: range) -> None:
        self.next[i, WALL] = self._wall(i)
        if self.half is not None:
            self.next[i, TOP], self.next[i, BOTTOM] = self._end(i, 1, self.half), self._end(i, -1, self.half)
        for j in others:
            if i != j:
                self.next[min(i, j), max(i, j)] = self._pair(i, j)

    def _later(self, s: Decimal | None) -> Decimal:
        return NEVER if s is None else self.time + s

    def _pair(self, i: int, j: int) -> Decimal:
        d, v = _minus(self.x[j], self.x[i]), _minus(self.v[j], self.v[i])
        b = _dot(d, v)
        if b >= 0:
            return NEVER
        return self._later(_first_root(_dot(v, v), b, _dot(d, d) - 4 * self.radius**2))

    def _wall(self, i: int) -> Decimal:
        d, v, room = self.x[i][:2], self.v[i][:2], self.inner - self.radius
        return self._later(_first_root(-_dot(v, v), -_dot(d, v), room**2 - _dot(d, d)))

    def _end(self, i: int, side: int, half: Decimal) -> Decimal:
        z, v = side * self.x[i][2], side * self.v[i][2]
        return NEVER if v <= 0 else self.time + (half - self.radius - z) / v
