"""Main program of the interface's process: serves the dashboard of a mission that flies in another process.

It ends with that process. Until the mission is known it accepts nothing; the port is open all the time, since it
belongs to the flight's process, and clients wait for an answer meanwhile.
"""

from __future__ import annotations

import asyncio
import resource
import socket
import sys
from functools import partial
from typing import Final

from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.clock import LoopClock
from aos_gcs.runtime.dashboard.serving import serve_flight
from aos_gcs.runtime.dashboard.start import ApiStart
from aos_gcs.runtime.processes.follower import Alive, run_follower
from aos_gcs.runtime.processes.workers import VIEWS
from aos_gcs.runtime.recorded.handover import HandoverPrinter
from aos_gcs.runtime.recorded.operation import Operation
from aos_gcs.runtime.recorded.viewer import Viewer
from aos_gcs.runtime.wall.live import make_wall
from aos_gcs.runtime.wall.video_maker import REST_IN_FLIGHT, VideoMaker
from aos_gcs.workers.process import open_worker

_MEMORY_BYTES: Final = 2 * 2**30
_FILES: Final = 8192
"""File descriptors: connections of strangers are limited to fewer, those of operators are not."""


def main(arguments: list[str]) -> None:
    """Serve until the flight's process is gone.

    Args:
        arguments: file descriptors of the connection to it, the lifeline and the socket that listens.
    """
    control_fd, lifeline_fd, listener_fd = map(int, arguments)
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most if 0 <= most < _FILES else _FILES, most))
    with socket.socket(fileno=listener_fd) as listener:
        run_follower(control_fd, lifeline_fd, _MEMORY_BYTES, ApiStart.from_json, partial(_show, listener))


async def _show(listener: socket.socket, mirror: MissionMirror, start: ApiStart, alive: Alive) -> None:
    """Serve the dashboard until cancelled."""
    async with open_worker(VIEWS) as views:
        await mirror.greeted()
        settings = mirror.settings
        viewer = Viewer(start.mission_folder, settings.imaging, settings.autofocus.reach_m, views)
        operation = Operation(start.mission_folder, views)
        operation.keep(mirror.snapshot().mission_id, viewer)
        handovers = HandoverPrinter(lambda: start.mission_folder, LoopClock().utc_s)
        async with serve_flight(
            listener,
            mirror,
            start.api,
            start.secrets(),
            viewer=viewer,
            operation=operation,
            handovers=handovers,
            wall=make_wall(mirror, lambda: start.mission_folder, start.api),
            videos=VideoMaker(lambda: start.mission_folder, REST_IN_FLIGHT),
            folder=start.mission_folder,
        ):
            alive.begin_to_serve()
            await asyncio.Event().wait()


if __name__ == "__main__":
    main(sys.argv[1:])
