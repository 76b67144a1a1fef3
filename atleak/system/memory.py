"""Give memory back that a process no longer uses: C libraries keep what was freed, in case it is wanted again."""

from __future__ import annotations

import ctypes
import gc
import sys
import threading


def give_back() -> None:
    """Collect what nothing refers to any more, and hand free memory to the system where the C library can be asked."""
    gc.collect()
    arrow = sys.modules.get("pyarrow")
    if arrow is not None:
        arrow.default_memory_pool().release_unused()
    if sys.platform.startswith("linux"):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of the GNU C library alone
        if trim is not None:
            trim(0)


def give_back_soon(seconds: float = 1.0) -> None:
    """Do so a little later, once whoever asks has let go of what it holds; a process that ends does not wait."""
    timer = threading.Timer(seconds, give_back)
    timer.daemon = True
    timer.start()
