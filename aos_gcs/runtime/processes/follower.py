"""Main program of a process that follows a mission which flies in another one, and ends with that one."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Awaitable, Callable
from typing import Final, NoReturn, Protocol, TypeVar

from aos_gcs.background_log import background_log
from aos_gcs.bridge.messages import MAX_REQUEST_BYTES, read_message
from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.workers.lifeline import end_with_parent, step_back

ALIVE_S: Final = 0.5
"""Interval in which the process says that it is alive."""


class Start(Protocol):
    """First message to such a process."""

    @property
    def log_level(self) -> int:
        """Level of the log lines that are written."""
        ...


StartT = TypeVar("StartT", bound=Start)


class Alive:
    """Tells the flight's process that the loop runs, and whether this one does its work."""

    def __init__(self, mirror: MissionMirror) -> None:
        self._mirror = mirror
        self.serves = False

    async def run(self) -> NoReturn:
        """Tell until cancelled."""
        while True:
            self._mirror.say_alive(self.serves)
            await asyncio.sleep(ALIVE_S)

    def begin_to_serve(self) -> None:
        """Tell at once that this process does its work."""
        self.serves = True
        self._mirror.say_alive(serves=True)


def run_follower(
    control_fd: int,
    lifeline_fd: int,
    memory_bytes: int,
    read_start: Callable[[bytes], StartT],
    work: Callable[[MissionMirror, StartT, Alive], Awaitable[None]],
) -> None:
    """Follow a mission until the flight's process is gone.

    Args:
        control_fd: file descriptor of the connection to it.
        lifeline_fd: file descriptor of the lifeline.
        memory_bytes: limit of this process's memory.
        read_start: reads the first message.
        work: what is done until it is cancelled; its mission is not known yet.
    """
    end_with_parent(lifeline_fd)
    step_back(memory_bytes)
    asyncio.run(_follow(socket.socket(fileno=control_fd), read_start, work))


async def _follow(
    control: socket.socket,
    read_start: Callable[[bytes], StartT],
    work: Callable[[MissionMirror, StartT, Alive], Awaitable[None]],
) -> None:
    reader, writer = await asyncio.open_connection(sock=control)
    payload = await read_message(reader, MAX_REQUEST_BYTES)
    if payload is None:
        return
    start = read_start(payload)
    logging.basicConfig(level=start.log_level, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    mirror = MissionMirror(reader, writer)
    alive = Alive(mirror)
    with background_log():
        mirroring, telling = asyncio.create_task(mirror.run()), asyncio.create_task(alive.run())
        working = asyncio.ensure_future(work(mirror, start, alive))
        await asyncio.wait({mirroring, working}, return_when=asyncio.FIRST_COMPLETED)
        for task in (telling, working):
            task.cancel()
        await asyncio.wait({telling, working})
        mirror.close()
        for task in (working, mirroring):
            if task.done() and not task.cancelled():
                task.result()
