"""Shared memory for large bulk on one host: room is made when first needed, and again when a bulk outgrows it.

Where it cannot be had, `fill` says so and the bulk goes plainly (SPEC Z10).
"""

import os
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from comotion_protocol.blocks import Frame

LEAST = 1 << 16
"""Smallest bulk that goes through shared memory [bytes]; below, the socket is as fast."""

CHUNK = 1 << 18
"""Piece in which arrays are copied [bytes]: small enough to stay in the processor's cache."""

BULKS = 4
"""Bulks that fit at once: one that is read, one that is written, and as much again for fragments."""

DIRECTORY = "/dev/shm"  # noqa: S108  (where Linux keeps shared memory; it is only asked for its free space)


class Arena:
    """Buffers from a pool.

    `allocator(size)` makes a pool of this size [bytes]: a function from the bytes wanted to a writable buffer, or None.
    """

    def __init__(self, allocator: Callable[[int], Callable[[int], Any]]) -> None:
        self._allocator = allocator
        self._allocate: Callable[[int], Any] | None = None
        self._size = 0
        self._lock = threading.Lock()

    def fill(self, frame: Frame) -> Any | None:
        """A shared buffer with the frame's bulk, or None if it is too small to pay or there is no room for it."""
        if frame.size < LEAST:
            return None
        with self._lock:
            buffer = self._buffer(frame.size)
        if buffer is None:
            return None
        start = 0
        for array in frame.arrays:
            raw = array.reshape(-1).view(np.uint8)
            for first in range(0, raw.size, CHUNK):
                piece = raw[first : first + CHUNK]
                buffer[start : start + piece.size] = piece.tobytes()
                start += piece.size
        return buffer

    def _buffer(self, size: int) -> Any | None:
        if self._allocate is None or BULKS * size > self._size:
            wanted = BULKS * size
            # Beyond the free space the kernel kills the process that touches the memory, instead of refusing it.
            if wanted > _free_bytes(DIRECTORY):
                return None
            self._allocate, self._size = self._allocator(wanted), wanted
        return self._allocate(size)


def _free_bytes(directory: str) -> int:
    try:
        space = os.statvfs(directory)
    except OSError:
        return 0
    return space.f_bavail * space.f_frsize
