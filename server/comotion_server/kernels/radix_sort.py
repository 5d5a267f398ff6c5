"""Sorting by whole numbers in linear time: one digit of nine bits after the other, the lowest first."""

import numpy as np

from comotion_server.kernels.jit import jit

DIGIT = 9  # bits; 512 stretches being written to at once
DIGITS = 1 << DIGIT


@jit
def _sort_by_digit(keys, values, shift, counts, keys_out, values_out):
    """Stable, by one digit of the keys."""
    counts[:] = 0
    for i in range(len(keys)):
        counts[(keys[i] >> shift) & (DIGITS - 1)] += 1
    total = 0
    for d in range(DIGITS):
        total, counts[d] = total + counts[d], total
    for i in range(len(keys)):
        d = (keys[i] >> shift) & (DIGITS - 1)
        keys_out[counts[d]], values_out[counts[d]] = keys[i], values[i]
        counts[d] += 1


@jit
def sort_by_key(keys, values, largest):
    """Sort keys (n,) >= 0 and values (n,) int64 along with them, stable; `largest`: no key exceeds it."""
    spare_keys, spare_values = np.empty(len(keys), np.int64), np.empty(len(keys), np.int64)
    counts, shift = np.empty(DIGITS, np.int64), 0
    while largest >> shift > 0:
        _sort_by_digit(keys, values, shift, counts, spare_keys, spare_values)
        _sort_by_digit(spare_keys, spare_values, shift + DIGIT, counts, keys, values)
        shift += 2 * DIGIT
