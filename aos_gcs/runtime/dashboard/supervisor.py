"""The dashboard in a process of its own."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final

from aos_gcs.api.basemap_file import check_basemap
from aos_gcs.api.listener import ServerAddress, listen
from aos_gcs.bridge.host import MissionHost
from aos_gcs.mission.control import MissionCommands, MissionView
from aos_gcs.ports import Notice
from aos_gcs.runtime.dashboard.start import ApiStart
from aos_gcs.runtime.encryption import tls_files
from aos_gcs.runtime.processes.supervisor import Program, Supervisor
from aos_gcs.runtime.sign_in import announce

_MODULE: Final = "aos_gcs.runtime.dashboard.process"


class ApiSupervisor:
    """The dashboard's process, and the port on which it serves clients.

    Args:
        start: what the process is told.
        listener: socket that listens for clients; it stays open while the process is replaced.
        notify: takes notices for operators.
        module: main program of the process.
    """

    def __init__(
        self, start: ApiStart, listener: socket.socket, notify: Callable[[Notice], None], module: str = _MODULE
    ) -> None:
        self._start = start
        self._listener = listener
        self._supervisor = Supervisor(Program("The dashboard", module, start.to_json()), notify, [listener])

    @asynccontextmanager
    async def showing(self, view: MissionView, commands: MissionCommands) -> AsyncIterator[None]:
        """Show a mission for as long as the context is entered, which waits until clients are served.

        Raises:
            LinkError: the process cannot be started.
        """
        host = MissionHost(view, commands, asyncio.get_running_loop().time)
        async with self._supervisor.following(host):
            announce(self.address, self._start.api, self._start.code)
            yield

    @property
    def address(self) -> ServerAddress:
        """Address on which clients are served."""
        api = self._start.api
        return ServerAddress(api.host, self._listener.getsockname()[1], tls_files(api) is not None)

    async def close(self) -> None:
        """End the process."""
        await self._supervisor.close()


@asynccontextmanager
async def open_api_process(
    start: ApiStart, notify: Callable[[Notice], None], module: str = _MODULE
) -> AsyncIterator[ApiSupervisor | None]:
    """Start the interface's process for as long as the context is entered, unless it is switched off.

    Args:
        start: what the process is told.
        notify: takes notices for operators.
        module: main program of the process.

    Raises:
        LinkError: its port cannot be opened.
        ConfigurationError: its base map cannot be shown.
    """
    if not start.api.enabled:
        yield None
        return
    if start.api.basemap is not None:
        check_basemap(start.api.basemap)
    with listen(start.api.host, start.api.port) as listener:
        supervisor = ApiSupervisor(start, listener, notify, module)
        try:
            yield supervisor
        finally:
            await supervisor.close()
