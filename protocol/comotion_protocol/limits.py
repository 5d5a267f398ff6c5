"""Sizes and ranges that no message may exceed (SPEC B10, B11). What they protect: a reader's memory and time."""

PROTOCOL = (1, 0)
"""Major and minor version; peers of one major version understand each other (SPEC M2)."""

REQUEST_HEADER_BYTES = 1 << 20
"""Largest request header [bytes]; 4096 block descriptors take a third of it."""

REPLY_HEADER_BYTES = 1 << 24
"""Largest reply header [bytes]; `IMPACTS` impacts fit in it."""

BULK_BYTES = 1 << 29
"""Largest bulk [bytes]: 22 million vertices in one message. Below zenoh's own 1 GiB."""

BLOCKS = 4096
"""Most blocks of a message."""

ITEMS = 1 << 16
"""Most entries of any list or map in a header."""

TEXT_BYTES = 4096
"""Longest string of a header [bytes of UTF-8], but for names."""

NAME_LENGTH = 128
"""Longest name of a region, a body or a client [characters]."""

BLOCK_NAME_LENGTH = 144
"""Longest name of a block [characters]: a region's and `/velocities`."""

RUN_LENGTH = 64
"""Longest run name and longest client id [characters]."""

COUNT_MAX = (1 << 53) - 1
"""Largest integer of a header: every language holds it exactly, even as a double."""

IMPACTS = 50_000
"""Most impacts listed in one step reply (SPEC M10); `books.impacts` counts all."""

WAITING = 64
"""Most requests that wait for the worker at once (SPEC S9)."""

IDLE_TIME = 600.0
"""Time after which a silent holder without a liveliness token loses the lease [s] (SPEC L5)."""

SUMS_TOLERANCE = 1e-9
"""Largest difference of a client's sums from ours, relative to the sum of magnitudes (SPEC F7): sums of a million
doubles in any order agree to 1e-10; one lost vertex among a million makes 1e-6."""
