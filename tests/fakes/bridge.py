"""Both sides of the bridge in one process, on a pair of sockets."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from aos_gcs.bridge.host import MissionHost
from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.mission.control import MissionCommands, MissionView

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


async def connected() -> tuple[Streams, Streams]:
    """Return the two ends of a connection."""
    ours, theirs = socket.socketpair()
    return await asyncio.open_connection(sock=ours), await asyncio.open_connection(sock=theirs)


@asynccontextmanager
async def hosted(view: MissionView, commands: MissionCommands, **options: Any) -> AsyncIterator[MissionHost]:
    """Follow a mission on behalf of interfaces; options are those of the host."""
    host = MissionHost(view, commands, asyncio.get_running_loop().time, **options)
    following = asyncio.create_task(host.run())
    await asyncio.sleep(0.0)
    yield host
    following.cancel()


@asynccontextmanager
async def mirrored_by(host: MissionHost) -> AsyncIterator[MissionMirror]:
    """Show a mission by messages."""
    (reader, writer), far_end = await connected()
    mirror = MissionMirror(*far_end)
    serving, mirroring = asyncio.create_task(host.serve(reader, writer)), asyncio.create_task(mirror.run())
    await mirror.greeted()
    try:
        yield mirror
    finally:
        for end in (writer, far_end[1]):
            end.close()
        await asyncio.gather(serving, mirroring)


@asynccontextmanager
async def mirror_of(view: MissionView, commands: MissionCommands) -> AsyncIterator[MissionMirror]:
    """Show and command a mission by messages."""
    async with hosted(view, commands) as host, mirrored_by(host) as mirror:
        yield mirror
