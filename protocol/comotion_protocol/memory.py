"""Memory for large messages that is kept and used again, instead of being given back to the kernel after each.

Fresh pages cost more than all copies of a message together: at 24 MB a plain round trip takes a third longer. Glibc
gives large blocks back at once, and keeps little of what threads free; three of its settings change that.
"""

import ctypes

MMAP_THRESHOLD = (-3, 1 << 30)
"""M_MMAP_THRESHOLD [bytes]: blocks up to here come from the heap."""

TRIM_THRESHOLD = (-1, (1 << 31) - 1)
"""M_TRIM_THRESHOLD [bytes]: the heap keeps as much when it is free."""

ARENA_MAX = (-8, 1)
"""M_ARENA_MAX: threads started from now on share one heap; a heap of their own ends at 64 MiB."""


def keep_large_blocks() -> None:
    """Make this process keep the memory of large messages; where there is no glibc, nothing happens."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    for option, value in (MMAP_THRESHOLD, TRIM_THRESHOLD, ARENA_MAX):
        mallopt(option, value)
