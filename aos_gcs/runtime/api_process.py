"""Main program of the interface's process: serves the dashboard of a mission that flies in another process.

It ends with that process. Until the mission is known it accepts nothing; the port is open all the time, since it
belongs to the flight's process, and clients wait for an answer meanwhile.
"""

from __future__ import annotations

import asyncio
import logging
import resource
import socket
import sys
from typing import Final, NoReturn

from aos_gcs.background_log import background_log
from aos_gcs.bridge.messages import MAX_REQUEST_BYTES, read_message
from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.clock import LoopClock
from aos_gcs.runtime.api_start import ALIVE_S, ApiStart
from aos_gcs.runtime.dashboard import serve_flight
from aos_gcs.runtime.handover import HandoverPrinter
from aos_gcs.runtime.viewer import Viewer
from aos_gcs.runtime.workers import VIEWS
from aos_gcs.workers.lifeline import end_with_parent, step_back
from aos_gcs.workers.process import open_worker

_MEMORY_BYTES: Final = 2 * 2**30
_FILES: Final = 8192
"""File descriptors: connections of strangers are limited to fewer, those of operators are not."""


class _Alive:
    """Tells the flight's process that the loop runs, and whether clients are served."""

    def __init__(self, mirror: MissionMirror) -> None:
        self._mirror = mirror
        self.serves = False

    async def run(self) -> NoReturn:
        """Tell until cancelled."""
        while True:
            self._mirror.say_alive(self.serves)
            await asyncio.sleep(ALIVE_S)

    def begin_to_serve(self) -> None:
        """Tell at once that clients are served."""
        self.serves = True
        self._mirror.say_alive(serves=True)


def main(arguments: list[str]) -> None:
    """Serve until the flight's process is gone.

    Args:
        arguments: file descriptors of the connection to it, the lifeline and the socket that listens.
    """
    control_fd, lifeline_fd, listener_fd = map(int, arguments)
    end_with_parent(lifeline_fd)
    step_back(_MEMORY_BYTES)
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most if 0 <= most < _FILES else _FILES, most))
    with socket.socket(fileno=listener_fd) as listener:
        asyncio.run(_serve(socket.socket(fileno=control_fd), listener))


async def _serve(control: socket.socket, listener: socket.socket) -> None:
    reader, writer = await asyncio.open_connection(sock=control)
    payload = await read_message(reader, MAX_REQUEST_BYTES)
    if payload is None:
        return
    start = ApiStart.from_json(payload)
    logging.basicConfig(level=start.log_level, format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    mirror = MissionMirror(reader, writer)
    alive = _Alive(mirror)
    with background_log():
        mirroring, telling = asyncio.create_task(mirror.run()), asyncio.create_task(alive.run())
        showing = asyncio.create_task(_show(mirror, start, listener, alive))
        await asyncio.wait({mirroring, showing}, return_when=asyncio.FIRST_COMPLETED)
        for task in (telling, showing):
            task.cancel()
        await asyncio.wait({telling, showing})
        mirror.close()
        for task in (showing, mirroring):
            if task.done() and not task.cancelled():
                task.result()


async def _show(mirror: MissionMirror, start: ApiStart, listener: socket.socket, alive: _Alive) -> None:
    """Serve the dashboard until cancelled."""
    async with open_worker(VIEWS) as views:
        await mirror.greeted()
        settings = mirror.settings
        viewer = Viewer(start.mission_folder, settings.imaging, settings.autofocus.reach_m, views)
        handovers = HandoverPrinter(start.mission_folder, LoopClock().utc_s)
        async with serve_flight(listener, mirror, start.api, start.secrets(), viewer=viewer, handovers=handovers):
            alive.begin_to_serve()
            await asyncio.Event().wait()


if __name__ == "__main__":
    main(sys.argv[1:])
