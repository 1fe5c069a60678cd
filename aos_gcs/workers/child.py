"""Main program of a worker process: limits itself, imports what it needs, then answers one call after the other.

It ends with its parent, whatever either of them is doing: the kernel signals the end of the lifeline, a socket of which
the parent holds the other end, and the signal's default action ends the process.
"""

from __future__ import annotations

import contextlib
import fcntl
import importlib
import os
import pickle
import resource
import signal
import socket
import sys
import threading
import traceback
from pathlib import Path

from aos_gcs.errors import AosError
from aos_gcs.workers.arena import Arena, pack, unpack
from aos_gcs.workers.wire import receive, send

_NICENESS = 5
"""The flight loop comes first."""
_OOM_SCORE = "500"
"""When the machine runs out of memory, the kernel ends the worker rather than the flight."""
_OPENCV_OUT_OF_MEMORY = -4


def main(arguments: list[str]) -> None:
    """Serve until the parent is gone.

    Args:
        arguments: file descriptors of the control socket, the lifeline and the two arenas; the memory limit in bytes;
            names of modules to import before the first call.
    """
    control_fd, lifeline_fd, requests_fd, responses_fd, memory_bytes = map(int, arguments[:5])
    _end_with_parent(lifeline_fd)
    _step_back(memory_bytes)
    for name in arguments[5:]:
        importlib.import_module(name)
    with socket.socket(fileno=control_fd) as control:
        _serve(control, Arena(requests_fd), Arena(responses_fd))


def _end_with_parent(lifeline_fd: int) -> None:
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


def _step_back(memory_bytes: int) -> None:
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.nice(_NICENESS)
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(_OOM_SCORE, encoding="ascii")


def _serve(control: socket.socket, requests: Arena, responses: Arena) -> None:
    send(control, b"ready")
    while (request := receive(control)) is not None:
        send(control, _answer(request, requests, responses))


def _answer(request: bytes, requests: Arena, responses: Arena) -> bytes:
    """Return a packed pair: whether the function has returned, and what it has returned or raised."""
    try:
        function, args, kwargs = unpack(request, requests, copy=False)
        return pack((True, function(*args, **kwargs)), responses)
    except Exception as error:  # whatever it is: the parent raises it
        return pack((False, _portable(error)), responses)


def _portable(error: Exception) -> Exception:
    """Return the error, or what can be told of it where it cannot be sent."""
    if isinstance(error, MemoryError) or getattr(error, "code", None) == _OPENCV_OUT_OF_MEMORY:
        return MemoryError()
    if not isinstance(error, AosError):
        error.add_note("".join(traceback.format_exception(error)))
    error.__cause__ = error.__context__ = None
    try:
        pickle.loads(pickle.dumps(error))  # noqa: S301 - our own
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


if __name__ == "__main__":
    main(sys.argv[1:])
