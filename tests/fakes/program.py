"""The program as its users start it: a process of its own, with its output in files."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aos_gcs.runtime.simulated.unused_ports import unused_ports
from tests.timing import scaled_s

POLL_S = 0.1


@dataclass
class Program:
    """A running ``aos-gcs``."""

    process: asyncio.subprocess.Process
    output_file: Path
    log_file: Path
    missions: Path
    """Folder in which the program records."""

    @property
    def output(self) -> str:
        return self.output_file.read_text(encoding="utf-8")

    @property
    def log(self) -> str:
        return self.log_file.read_text(encoding="utf-8")

    @property
    def mission_folder(self) -> Path:
        (folder,) = (path for path in self.missions.iterdir() if path.is_dir())
        return folder

    @property
    def operator_url(self) -> str:
        """The dashboard's address for operators, once it is logged."""
        found = re.search(r"Dashboard for operators: (\S+)", self.log)
        assert found is not None, self.log
        return found.group(1)

    def result(self) -> dict[str, Any]:
        """Return the one JSON object on standard output."""
        result: dict[str, Any] = json.loads(self.output)
        return result

    async def until(self, condition: Callable[[], bool], timeout_s: float) -> None:
        """Wait until a condition holds; fail with the log when the program ends or the scaled time runs out before."""
        with suppress(TimeoutError):
            async with asyncio.timeout(scaled_s(timeout_s)):
                while not condition() and self.process.returncode is None:  # noqa: ASYNC110 - nothing announces it
                    await asyncio.sleep(POLL_S)
        assert condition(), f"exit code {self.process.returncode}, log:\n{self.log[-3000:]}"

    async def until_logged(self, text: str, timeout_s: float) -> None:
        """Wait for a text in the log."""
        await self.until(lambda: text in self.log, timeout_s)

    async def ended(self, timeout_s: float) -> int:
        """Wait for the end and return the exit code."""
        await self.until(lambda: self.process.returncode is not None, timeout_s)
        assert self.process.returncode is not None
        return self.process.returncode

    def stop(self, signal_number: signal.Signals) -> None:
        """Send a signal to the program alone."""
        self.process.send_signal(signal_number)

    async def children(self, words: str = "") -> list[int]:
        """Return the ids of the processes that it has started, with these words in their command lines."""
        listing = await asyncio.create_subprocess_exec(
            "ps", "-A", "-ww", "-o", "pid=,ppid=,args=", stdout=asyncio.subprocess.PIPE
        )
        output, _ = await listing.communicate()
        rows = (line.split(maxsplit=2) for line in output.decode().splitlines())
        return [int(pid) for pid, parent, line in rows if int(parent) == self.process.pid and words in line]

    async def child(self, words: str, timeout_s: float) -> int:
        """Wait until exactly one process that it has started has these words in its command line; return its id."""
        async with asyncio.timeout(scaled_s(timeout_s)):
            while len(found := await self.children(words)) != 1:  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(POLL_S)
        return found[0]


_UNUSED_PORTS = {kind: unused_ports(kind) for kind in (socket.SOCK_DGRAM, socket.SOCK_STREAM)}


def unused_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    """Return a port that nobody has open, of UDP unless it is to be one of TCP; each is returned once."""
    return next(_UNUSED_PORTS[kind])


@asynccontextmanager
async def running(folder: Path, *arguments: str) -> AsyncIterator[Program]:
    """Start ``aos-gcs`` with its files in ``folder``; it and what it started end with the context.

    Missions belong into ``folder / "missions"``; a demo is told so.
    """
    if "demo" in arguments:
        arguments = (*arguments, "--folder", str(folder / "missions"))
    await asyncio.to_thread(folder.mkdir, exist_ok=True)
    output_file, log_file = folder / "output.txt", folder / "log.txt"
    # Whoever starts the tests in the background has them ignore Ctrl-C, and so what they start.
    ours = signal.signal(signal.SIGINT, signal.default_int_handler)
    with output_file.open("wb") as output, log_file.open("wb") as log:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "aos_gcs", *arguments),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=output,
            stderr=log,
            env={**os.environ, "NO_COLOR": "1"},
        )
    signal.signal(signal.SIGINT, ours)
    program = Program(process, output_file, log_file, folder / "missions")
    try:
        yield program
    finally:
        if process.returncode is None:
            # Both may end by themselves meanwhile.
            for pid in [process.pid, *await program.children()]:
                kill(pid)
        await process.wait()


def kill(pid: int) -> None:
    """Kill a process that may have ended already."""
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


async def gone(pid: int, limit_s: float = 10.0) -> None:
    """Wait until a process has ended."""
    async with asyncio.timeout(scaled_s(limit_s)):
        while await is_running(pid):  # noqa: ASYNC110 - it is not ours, so nothing announces it
            await asyncio.sleep(POLL_S)


async def is_running(pid: int) -> bool:
    """Return whether a process exists that has not ended."""
    listing = await asyncio.create_subprocess_exec("ps", "-o", "stat=", "-p", str(pid), stdout=asyncio.subprocess.PIPE)
    state, _ = await listing.communicate()
    return bool(state.strip()) and not state.startswith(b"Z")
