"""Spheres in a pipe in arithmetic of 60 digits, from impact to impact: the truth for the event queue's order and times.

Nothing of the server is used. Spheres fly straight, the pipe's axis is z, its ends may be closed, all impacts are
elastic and of two bodies each.
"""

import mpmath as mp

mp.mp.dps = 60
WALL, TOP, BOTTOM = -1, -2, -3


def _first_root(a, b, c):
    """The first s > 0 of a s^2 + 2 b s + c = 0 at which it falls below zero; None: none."""
    square = b * b - a * c
    if square < 0:
        return None
    roots = sorted([(-b - mp.sqrt(square)) / a, (-b + mp.sqrt(square)) / a])
    falling = [s for s in roots if s > TINY and a * s + b < 0]
    return falling[0] if falling else None


TINY = mp.mpf(10) ** -40


class Spheres:
    """Equal spheres of unit mass in a pipe, at one time."""

    def __init__(self, x, v, radius, inner, half=None):
        self.x, self.v = [[[mp.mpf(float(c)) for c in row] for row in rows] for rows in (x, v)]
        self.radius, self.inner, self.half = (None if c is None else mp.mpf(float(c)) for c in (radius, inner, half))
        self.time, count = mp.mpf(0), len(self.x)
        self.next = {}
        for i in range(count):
            self._look(i, range(i + 1, count))

    def _look(self, i, others):
        self.next[i, WALL] = self._wall(i)
        if self.half is not None:
            self.next[i, TOP], self.next[i, BOTTOM] = self._end(i, 1), self._end(i, -1)
        for j in others:
            if i != j:
                self.next[min(i, j), max(i, j)] = self._pair(i, j)

    def _later(self, s):
        return mp.inf if s is None else self.time + s

    def _pair(self, i, j):
        d = [p - q for p, q in zip(self.x[j], self.x[i], strict=True)]
        v = [p - q for p, q in zip(self.v[j], self.v[i], strict=True)]
        b = mp.fdot(d, v)
        if b >= 0:
            return mp.inf
        return self._later(_first_root(mp.fdot(v, v), b, mp.fdot(d, d) - 4 * self.radius**2))

    def _wall(self, i):
        d, v, room = self.x[i][:2], self.v[i][:2], self.inner - self.radius
        return self._later(_first_root(-mp.fdot(v, v), -mp.fdot(d, v), room**2 - mp.fdot(d, d)))

    def _end(self, i, side):
        z, v = side * self.x[i][2], side * self.v[i][2]
        return mp.inf if v <= 0 else self.time + (self.half - self.radius - z) / v

    def event(self):
        """Goes on through the next impact: (time, sphere, sphere or WALL, TOP, BOTTOM)."""
        (i, j), time = min(self.next.items(), key=lambda entry: entry[1])
        step, self.time = time - self.time, time
        for x, v in zip(self.x, self.v, strict=True):
            for k in range(3):
                x[k] += step * v[k]
        if j in (TOP, BOTTOM):
            self.v[i][2] = -self.v[i][2]
        else:
            n = [*self.x[i][:2], mp.mpf(0)] if j == WALL else [p - q for p, q in zip(self.x[i], self.x[j], strict=True)]
            against = self.v[i] if j == WALL else [p - q for p, q in zip(self.v[i], self.v[j], strict=True)]
            push = mp.fdot(n, against) / mp.fdot(n, n) * (2 if j == WALL else 1)
            self.v[i] = [p - push * q for p, q in zip(self.v[i], n, strict=True)]
            if j >= 0:
                self.v[j] = [p + push * q for p, q in zip(self.v[j], n, strict=True)]
        everybody = range(len(self.x))
        for k in (i, j):
            if k >= 0:
                self._look(k, everybody)
        return time, i, j
