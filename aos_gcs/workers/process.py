"""Workers in processes of their own, supervised: one that dies, hangs or takes too much memory is replaced."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, ParamSpec, TypeVar, cast

from aos_gcs.errors import WorkerError
from aos_gcs.workers.answers import MAX_HEAD_BYTES, MalformedAnswerError, unpack_answer
from aos_gcs.workers.arena import Arena, pack
from aos_gcs.workers.lifeline import NICENESS
from aos_gcs.workers.wire import receive, send

P = ParamSpec("P")
T = TypeVar("T")

_log = logging.getLogger(__name__)
START_S = 60.0
"""Time for the first process to import its modules, on a machine that is busy; nothing flies yet."""
RESTART_S = 10.0
"""Time for a process that replaces another one; it starts when the other has failed, before the next call."""
_KILL_S = 2.0
"""Time for the kernel to end a process."""
_ENVIRONMENT = {
    # Largest image that OpenCV decodes, whatever its headers say.
    "OPENCV_IO_MAX_IMAGE_PIXELS": "250000000",
    # Threads of BLAS would wait for one another in a loop, and take a stack each from the memory limit.
    "OPENBLAS_NUM_THREADS": "1",
    # Arrays of a step are freed and asked for again at once: glibc would hand their pages back and forth each time,
    # which takes a sixth of the time of a step's pictures.
    "MALLOC_MMAP_THRESHOLD_": "33554432",
    "MALLOC_TRIM_THRESHOLD_": "67108864",
}


@dataclass(frozen=True, slots=True)
class WorkerSettings:
    """A worker's name, limits and preparations."""

    name: str
    """Work of the process, as operators read it: ``Image analysis``."""
    memory_bytes: int
    """Limit of the memory that it allocates; frames that it is handed do not count."""
    timeout_s: float
    """Time limit of one call, real seconds."""
    modules: tuple[str, ...] = ()
    """Modules that it imports before the first call."""
    niceness: int = NICENESS
    """Distance of its priority from the usual one, as for ``nice``."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Variables of its environment beside those of this process, or in their place."""


class StillStartingError(WorkerError):
    """The process has not imported its modules yet; a later call may find it ready."""


class ProcessWorker:
    """Implements ``aos_gcs.ports.Worker`` in a process; made by :func:`open_worker`."""

    def __init__(self, settings: WorkerSettings) -> None:
        self._settings = settings
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=f"worker {settings.name}")
        self._child = Child(settings)
        self._is_closed = False

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        """See ``aos_gcs.ports.Worker``."""
        call = self._thread.submit(self._call, function, args, kwargs)
        return cast("T", await asyncio.wrap_future(call))

    async def ready(self) -> None:
        """Wait until the process has imported its modules.

        Raises:
            WorkerError: it cannot be started.
        """
        await asyncio.wrap_future(self._thread.submit(self._child.await_ready, START_S))

    async def close(self) -> None:
        """End the process and what it is doing."""
        self._is_closed = True
        await asyncio.to_thread(self._end)

    def _end(self) -> None:
        self._child.kill()
        self._thread.shutdown(cancel_futures=True)
        self._child.kill()  # the one that the thread may have started meanwhile
        self._child.release()

    # --- in the worker's thread ---------------------------------------------------------------------------------------

    def _call(self, function: Callable[..., object], args: tuple[object, ...], kwargs: dict[str, object]) -> object:
        try:
            has_returned, result = self._child.call(function, args, kwargs)
        except StillStartingError:
            raise
        except (WorkerError, OSError) as error:
            self._restart(str(error))
            raise WorkerError(str(error)) from error
        if isinstance(result, MemoryError):
            text = f"{self._settings.name} has run out of memory (limit {self._settings.memory_bytes / 2**30:.1f} GiB)"
            self._restart(text)
            raise WorkerError(text) from result
        if not has_returned:
            raise cast("Exception", result)
        return result

    def _restart(self, reason: str) -> None:
        """Replace the process; the new one gets ready while nobody waits for it.

        Where the machine has no room for one, the next call tries again.
        """
        if self._is_closed:
            return
        _log.warning("%s: a new process is started", reason)
        self._child.kill()
        self._child.release()
        try:
            self._child = Child(self._settings)
        except OSError as error:
            _log.warning("%s cannot be started: %s", self._settings.name, error)


class Child:
    """One process, and the memory shared with it. All but :meth:`kill` is called in one thread."""

    def __init__(self, settings: WorkerSettings) -> None:
        self._settings = settings
        self._control, theirs = socket.socketpair()
        self._lifeline, their_lifeline = socket.socketpair()
        self._requests, self._responses = Arena.create(), Arena.create()
        self._is_ready = False
        fds = (theirs.fileno(), their_lifeline.fileno(), self._requests.fd, self._responses.fd)
        arguments = [*map(str, (*fds, settings.memory_bytes, settings.niceness)), *settings.modules]
        path = os.pathsep.join(filter(None, sys.path))
        with theirs, their_lifeline:
            try:
                self._process = subprocess.Popen(  # noqa: S603 - our own interpreter and module
                    [sys.executable, "-P", "-m", "aos_gcs.workers.child", *arguments],
                    pass_fds=fds,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    env={**_ENVIRONMENT, **os.environ, **settings.environment, "PYTHONPATH": path},
                    start_new_session=True,
                )
            except OSError:
                self.release()
                raise

    def call(
        self, function: Callable[..., object], args: tuple[object, ...], kwargs: dict[str, object]
    ) -> tuple[bool, Any]:
        """Return whether the function has returned, and what it has returned or raised.

        Raises:
            WorkerError: the process has died, taken longer than it may, or sent what is no answer.
        """
        self.await_ready(RESTART_S)
        self._send(pack((function, args, kwargs), self._requests))
        message = self._receive(self._settings.timeout_s)
        try:
            return unpack_answer(message, self._responses, self._settings.memory_bytes)
        except MalformedAnswerError as error:
            raise MalformedAnswerError(f"{self._settings.name} has sent {error}") from error

    def await_ready(self, timeout_s: float) -> None:
        """Wait until the process has imported its modules.

        Raises:
            StillStartingError: it has taken longer.
            WorkerError: it has died.
        """
        if self._is_ready:
            return
        try:
            self._control.settimeout(timeout_s)
            self._control.recv(1, socket.MSG_PEEK)
        except TimeoutError:
            raise StillStartingError(f"{self._settings.name} is still starting") from None
        except OSError as error:
            raise WorkerError(f"{self._settings.name} is not running") from error
        self._receive(timeout_s)
        self._is_ready = True

    def kill(self) -> None:
        """End the process; a call in hand raises."""
        self._process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):  # it waits for a disk that does not answer
            self._process.wait(_KILL_S)

    def release(self) -> None:
        """Give back what was shared with the process, which has ended."""
        self._is_ready = False
        self._control.close()
        self._lifeline.close()
        self._requests.close()
        self._responses.close()

    def _send(self, message: bytes) -> None:
        try:
            self._control.settimeout(self._settings.timeout_s)
            send(self._control, message)
        except OSError as error:
            raise WorkerError(f"{self._settings.name} has ended{self._why()}") from error

    def _receive(self, timeout_s: float) -> bytes:
        self._control.settimeout(timeout_s)
        try:
            message = receive(self._control, MAX_HEAD_BYTES)
        except ValueError as error:
            raise MalformedAnswerError(f"{self._settings.name} has sent {error}") from error
        except TimeoutError:
            raise WorkerError(f"{self._settings.name} has taken longer than {timeout_s:g} s") from None
        if message is None:
            raise WorkerError(f"{self._settings.name} has ended{self._why()}")
        return message

    def _why(self) -> str:
        try:
            status = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            return ""
        return f" (status {status})" if status >= 0 else f" ({signal.Signals(-status).name})"


@asynccontextmanager
async def open_worker(settings: WorkerSettings) -> AsyncIterator[ProcessWorker]:
    """Start a worker for as long as the context is entered; ``ready`` waits for it."""
    worker = ProcessWorker(settings)
    try:
        yield worker
    finally:
        await worker.close()
