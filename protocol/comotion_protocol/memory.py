"""Memory for large messages that is kept and used again, instead of being given back to the kernel after each.

Fresh pages cost more than all copies of a message together: at 24 MB a plain round trip takes a third longer. Glibc
gives large blocks back at once; two of its settings change that for this process. A third one, a single heap for all
threads, made messages of 2 MB slower: zenoh's threads waited for each other.
"""

import ctypes

MMAP_THRESHOLD = (-3, 1 << 30)
"""M_MMAP_THRESHOLD [bytes]: blocks up to here come from the heap."""

TRIM_THRESHOLD = (-1, (1 << 31) - 1)
"""M_TRIM_THRESHOLD [bytes]: the heap keeps as much when it is free."""


def keep_large_blocks() -> None:
    """Make this process keep the memory of large messages; where there is no glibc, nothing happens."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    for option, value in (MMAP_THRESHOLD, TRIM_THRESHOLD):
        mallopt(option, value)
