"""Processes beside the flight's that follow a mission, started and watched by it: whatever they do, it goes on."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Final

from aos_gcs.bridge.host import MissionHost
from aos_gcs.bridge.messages import framed
from aos_gcs.errors import AosError, LinkError
from aos_gcs.ports import Notice, Severity

START_S: Final = 60.0
"""Time for the process to import its modules, on a machine that is busy."""
SILENT_S: Final = 10.0
"""Silence after which it is replaced: its loop hangs, or it is stopped."""
PAUSES_S: Final = (0.0, 1.0, 2.0, 5.0, 10.0, 30.0)
"""Pauses before it is started again, by the number of failures since it last worked for a minute."""
_STEADY_S: Final = 60.0
_LOOK_S: Final = 0.5
_GRACE_S: Final = 5.0
"""Time for answers on their way when the service ends."""


@dataclass(frozen=True, slots=True)
class Program:
    """Main program of a process that follows a mission."""

    title: str
    """Subject of sentences for operators, such as ``The dashboard``."""
    module: str
    """Module that is run. Its arguments are file descriptors: the connection, the lifeline and what else is given."""
    start: bytes
    """First message to the process; it may hold secrets."""


class Supervisor:
    """Starts a process, connects it with the mission, and replaces it when it fails.

    Args:
        program: what is run.
        notify: takes notices for operators.
        passed: further sockets that the process gets.
    """

    def __init__(
        self, program: Program, notify: Callable[[Notice], None], passed: Sequence[socket.socket] = ()
    ) -> None:
        self._program = program
        self._notify = notify
        self._passed = passed
        loop = asyncio.get_running_loop()
        self._host: asyncio.Future[MissionHost] = loop.create_future()
        self._has_served: asyncio.Future[None] = loop.create_future()
        self._is_heard = self._serves = False
        self._running = asyncio.create_task(self._run())

    @asynccontextmanager
    async def following(self, host: MissionHost) -> AsyncIterator[None]:
        """Have the process follow a mission for as long as the context is entered, which waits until it does its work.

        Args:
            host: the flight's side of the connection.

        Raises:
            LinkError: the process cannot be started.
        """
        following = asyncio.create_task(host.run())
        self._host.set_result(host)
        try:
            await asyncio.shield(self._has_served)
            yield
        finally:
            await self.close()
            following.cancel()

    async def close(self) -> None:
        """End the process."""
        self._running.cancel()
        self._has_served.cancel()
        await asyncio.wait({self._running})

    def _on_alive(self, serves: bool) -> None:
        self._is_heard = True
        if not serves or self._serves:
            return
        self._serves = True
        if self._has_served.done():
            self._notify(Notice(Severity.INFO, f"{self._program.title} is available again"))
        else:
            self._has_served.set_result(None)

    # --- one process after the other ----------------------------------------------------------------------------------

    async def _run(self) -> None:
        """Keep a process running until cancelled, or until the first one has failed."""
        loop, failures = asyncio.get_running_loop(), 0
        while True:
            began_s = loop.time()
            self._is_heard = self._serves = False
            reason = await self._serve_once()
            if not self._has_served.done():
                self._has_served.set_exception(
                    LinkError(f"{self._program.title} cannot be started: {reason}; see the log.")
                )
                return
            failures = 0 if loop.time() - began_s > _STEADY_S else failures + 1
            text = f"{self._program.title}'s process {reason} and is replaced. The mission goes on"
            self._notify(Notice(Severity.WARNING, text))
            await asyncio.sleep(PAUSES_S[min(max(failures - 1, 0), len(PAUSES_S) - 1)])

    async def _serve_once(self) -> str:
        """Run a process to its end, and return why it has ended."""
        try:
            process, control, lifeline = await self._launch()
        except OSError as error:
            return f"cannot be started ({error.strerror})"
        reader, writer = await asyncio.open_connection(sock=control)
        writer.write(framed(self._program.start))
        tasks = {
            exited := asyncio.create_task(process.wait()),
            watching := asyncio.create_task(self._watch()),
            serving := asyncio.create_task(self._talk(reader, writer)),
        }
        try:
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            if watching.done() or serving.done():
                with suppress(TimeoutError):  # it may be on its way out, and its status says more
                    await asyncio.wait_for(asyncio.shield(exited), 0.0 if watching.done() else _LOOK_S)
            return _why(process.returncode, serving)
        finally:
            for task in tasks - {exited}:
                task.cancel()
            writer.transport.abort()
            if not watching.done():
                await asyncio.wait({exited}, timeout=_GRACE_S)
            if process.returncode is None:
                process.kill()
            lifeline.close()
            await asyncio.wait({exited}, timeout=_GRACE_S)

    async def _launch(self) -> tuple[asyncio.subprocess.Process, socket.socket, socket.socket]:
        """Start a process; return it, and our ends of its connection and its lifeline."""
        control, theirs = socket.socketpair()
        lifeline, their_lifeline = socket.socketpair()
        fds = [theirs.fileno(), their_lifeline.fileno(), *(one.fileno() for one in self._passed)]
        path = os.pathsep.join(filter(None, sys.path))
        with theirs, their_lifeline:
            try:
                process = await asyncio.create_subprocess_exec(
                    *(sys.executable, "-P", "-m", self._program.module, *map(str, fds)),
                    pass_fds=fds,
                    stdin=asyncio.subprocess.DEVNULL,
                    stdout=asyncio.subprocess.DEVNULL,
                    env={**os.environ, "PYTHONPATH": path},
                    start_new_session=True,
                )
            except OSError:
                control.close()
                lifeline.close()
                raise
        return process, control, lifeline

    async def _talk(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        host = await asyncio.shield(self._host)
        await host.serve(reader, writer, self._on_alive)

    async def _watch(self) -> None:
        """Return when the process has been silent for too long.

        Silence is counted in looks: after a stall of this process its messages are read before the next one.
        """
        await asyncio.shield(self._host)
        silent_s, limit_s = 0.0, START_S
        while silent_s < limit_s:
            await asyncio.sleep(_LOOK_S)
            silent_s += _LOOK_S
            if self._is_heard:
                silent_s, limit_s = 0.0, SILENT_S if self._serves else START_S
            self._is_heard = False


def _why(status: int | None, serving: asyncio.Task[None]) -> str:
    if status is not None:
        return f"has ended (status {status})" if status >= 0 else f"has ended ({signal.Signals(-status).name})"
    if serving.done():
        error = serving.exception()
        if isinstance(error, AosError):
            return f"has sent an unusable message ({error})"
        return "has broken off the connection"
    return "does not answer"
