"""Memory that is freed and soon asked for again."""

import numpy as np

KEPT = 31 << 20
"""Bytes of what glibc takes for the largest block that is worth keeping, below the most that it allows for."""


def keep_freed_memory() -> None:
    """Let memory that is freed be used again; else it goes back to the system, which clears each page of the next.

    glibc keeps blocks as large as the largest that was freed before (mallopt(3), M_MMAP_THRESHOLD), and at the end
    of its heap twice as much. A search makes and frees arrays of about a megabyte all the time. The block that is
    freed here is never written to, so it takes no memory. Elsewhere this does nothing.
    """
    np.empty(KEPT, np.uint8)
