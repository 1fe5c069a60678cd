"""Life of a process that another one has started: it ends with its parent, and has a lower priority until then."""

from __future__ import annotations

import contextlib
import fcntl
import os
import resource
import signal
import socket
import threading
import time
from pathlib import Path

NICENESS = 5
"""Priority below that of the flight loop."""
_AUTOGROUP = Path("/proc/self/autogroup")
_AUTOGROUP_TRIES, _AUTOGROUP_PAUSE_S = 30, 0.1
"""The kernel lets one process at a time set the priority of its session, and the next one 0.1 s later."""
_OOM_SCORE = "500"
"""Score by which the kernel ends this process, rather than the flight, when the machine runs out of memory."""


def end_with_parent(lifeline_fd: int) -> None:
    """End this process when its parent has gone, whatever either of them is doing.

    The kernel signals the end of the lifeline, a socket of which the parent holds the other end, and the signal's
    default action ends the process.
    """
    # The service's own signals are its own business; it ends us by the lifeline.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    lifeline = socket.socket(fileno=lifeline_fd)
    fcntl.fcntl(lifeline, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(lifeline, fcntl.F_SETFL, fcntl.fcntl(lifeline, fcntl.F_GETFL) | os.O_ASYNC)
    # Where the signal does nothing (macOS), and for a parent that has ended before.
    threading.Thread(target=_wait_for_end, args=(lifeline,), daemon=True).start()


def _wait_for_end(lifeline: socket.socket) -> None:
    lifeline.recv(1)
    os._exit(0)


def step_back(memory_bytes: int, niceness: int = NICENESS) -> None:
    """Limit the memory of this process, and let others go first; the higher the niceness, the more of them."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
    # The hard limit stays: a process that this one starts may have a higher one.
    resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.nice(niceness)
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(_OOM_SCORE, encoding="ascii")


def step_back_as_session(niceness: int = NICENESS) -> None:
    """Let the processes of other sessions go first, those of the flight loop among them.

    Where the kernel groups processes by their sessions (``sched_autogroup_enabled``, as on desktops), priorities count
    within a session only, and each session gets the same share of the processor. Processes that have no session of
    their own are left alone: they would take that of others along.
    """
    if os.getsid(0) != os.getpid():
        return
    for _ in range(_AUTOGROUP_TRIES):
        try:
            _AUTOGROUP.write_text(str(niceness), encoding="ascii")
        except BlockingIOError:
            time.sleep(_AUTOGROUP_PAUSE_S)
        except OSError:
            return
        else:
            return
