"""Main program of a worker process: limits itself, imports what it needs, then answers one call after the other."""

from __future__ import annotations

import importlib
import socket
import sys
import traceback

from aos_gcs.errors import AosError
from aos_gcs.workers.answers import pack_error, pack_result
from aos_gcs.workers.arena import Arena, unpack
from aos_gcs.workers.lifeline import end_with_parent, step_back, step_back_as_session
from aos_gcs.workers.wire import receive, send

_OPENCV_OUT_OF_MEMORY = -4


def main(arguments: list[str]) -> None:
    """Serve until the parent is gone.

    Args:
        arguments: file descriptors of the control socket, the lifeline and the two arenas; the memory limit in bytes;
            the niceness; names of modules to import before the first call.
    """
    control_fd, lifeline_fd, requests_fd, responses_fd, memory_bytes, niceness = map(int, arguments[:6])
    end_with_parent(lifeline_fd)
    step_back(memory_bytes, niceness)
    step_back_as_session(niceness)
    for name in arguments[6:]:
        importlib.import_module(name)
    with socket.socket(fileno=control_fd) as control:
        _serve(control, Arena(requests_fd), Arena(responses_fd))


def _serve(control: socket.socket, requests: Arena, responses: Arena) -> None:
    send(control, b"ready")
    while (request := receive(control)) is not None:
        send(control, _answer(request, requests, responses))


def _answer(request: bytes, requests: Arena, responses: Arena) -> bytes:
    """Return the answer to a request: what the function has returned or raised."""
    try:
        function, args, kwargs = unpack(request, requests)
        return pack_result(function(*args, **kwargs), responses)
    except Exception as error:  # whatever it is: the parent raises it
        return pack_error(_told(error), responses)


def _told(error: Exception) -> Exception:
    """Return the error, with its place in a note where it is a defect."""
    if isinstance(error, MemoryError) or getattr(error, "code", None) == _OPENCV_OUT_OF_MEMORY:
        return MemoryError()
    if not isinstance(error, AosError):
        error.add_note("".join(traceback.format_exception(error)))
    return error


if __name__ == "__main__":
    main(sys.argv[1:])
