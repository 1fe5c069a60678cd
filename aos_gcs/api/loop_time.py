"""Real time for what concerns connections rather than the mission, whose clock may run faster."""

from __future__ import annotations

import asyncio


def loop_time_s() -> float:
    """Return the running event loop's own time, which never jumps."""
    return asyncio.get_running_loop().time()
