"""Contacts that come up on the way: of points that have yet to slide on to the face on which they will meet."""

from comotion_server.kernels.contact_manifold import gap_of_pair, manifold
from comotion_server.kernels.contacts import FULL
from comotion_server.kernels.flight import fly
from comotion_server.kernels.jit import jit, lean_jit

CLEAR = 0.1  # of delta: bodies farther apart do not meet
ABOUT = 0.15  # of delta: nearer ones are about to
ALSO = 1.5  # of the gap: points of contact up to there
HALVINGS = 40


@lean_jit
def _gap_at(solids, flights, bodies, a, b, time, state, limit, witness, work):
    """The gap of two bodies flown to a local time [m], exact below `limit`; their states are then in `state`."""
    x, v, R, L, w = state
    for i in (a, b):
        fly(flights, bodies, i, time, x[i], v[i], R[i], L[i], w[i])
    return gap_of_pair(solids, a, b, x, R, limit, witness, work)


@lean_jit
def _approach(solids, flights, bodies, a, b, begin, h, state, delta, witness, work):
    """The time [s] after `begin` at which bodies are about to meet, and their gap [m]; (-1, gap) where they do not."""
    parts = (solids, flights, bodies, a, b)
    gap = _gap_at(*parts, begin + h, state, delta, witness, work)
    if gap >= CLEAR * delta:
        return -1.0, gap
    gap = _gap_at(*parts, begin, state, delta, witness, work)
    if gap < CLEAR * delta:
        return -1.0, gap
    low, high = 0.0, h
    for _ in range(HALVINGS):
        if gap <= ABOUT * delta:
            break
        middle = 0.5 * (low + high)
        there = _gap_at(*parts, begin + middle, state, delta, witness, work)
        if there < CLEAR * delta:
            high = middle
        else:
            low, gap = middle, there
    return low, _gap_at(*parts, begin + low, state, delta, witness, work)


@jit
def foreseen(solids, flights, bodies, pairs, delta, begin, h, state, witness, contacts, pair_of, work):
    """The contacts of pairs (p,2) that are about to meet within `h` [s] of their flights: how many, or FULL.

    delta (p,) [m]; state, witness (2,) int64: to work with; contacts: as they are just before they meet; pair_of (c,):
    which pair; work: of `new_patch_work`.
    """
    x, _, R, _, _ = state
    count = 0
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        witness[:] = -1
        after, gap = _approach(solids, flights, bodies, a, b, begin, h, state, delta[k], witness, work)
        if after < 0.0:
            continue
        reach = ALSO * gap
        rows = manifold(solids, a, b, x, R, reach, 0.0, reach, contacts, count, work)
        if rows == FULL:
            return FULL
        pair_of[count : count + rows] = k
        count += rows
    return count
