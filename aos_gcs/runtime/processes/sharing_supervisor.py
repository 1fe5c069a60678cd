"""Live sharing in a process of its own: the flight never waits for the systems of others."""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final

from aos_gcs.bridge.host import MissionHost
from aos_gcs.bridge.messages import SHARING_REQUESTS
from aos_gcs.bridge.quiet_view import QuietView
from aos_gcs.clock import machine_utc_s
from aos_gcs.mission.control import MissionCommands, MissionView
from aos_gcs.mission.model.sharing import ChannelStatus
from aos_gcs.mission.proposals import Proposals
from aos_gcs.ports import Notice
from aos_gcs.runtime.processes.sharing_process import SharingStart
from aos_gcs.runtime.processes.supervisor import Program, Supervisor
from aos_gcs.sharing.service import make_channels
from aos_gcs.sharing.settings import SharingSettings
from aos_gcs.sharing.watch import ProposalWatch, SharingWatch

_MODULE: Final = "aos_gcs.runtime.processes.sharing_process"
_STATE_S: Final = 0.45
"""Shortest time between two states that the process is told: findings are shared within half a second."""


class SharingSupervisor:
    """Live sharing's process.

    Args:
        settings: systems to share with.
        notify: takes notices for operators.
    """

    def __init__(self, settings: SharingSettings, notify: Callable[[Notice], None]) -> None:
        start = SharingStart(settings).to_json()
        self._notify = notify
        self._supervisor = Supervisor(Program("Live sharing", _MODULE, start), notify)

    @asynccontextmanager
    async def following(
        self,
        view: MissionView,
        commands: MissionCommands,
        show: Callable[[tuple[ChannelStatus, ...]], None],
        proposals: Proposals,
    ) -> AsyncIterator[None]:
        """Hand a mission over for as long as the context is entered.

        Args:
            view: mission to share.
            commands: has the settings of the mission; the process commands nothing.
            show: takes the states of the channels, about once a second.
            proposals: takes what others propose.

        Raises:
            LinkError: the process cannot be started.
        """
        now_s = asyncio.get_running_loop().time
        watch = SharingWatch(self._notify, now_s)
        incoming = ProposalWatch(proposals, self._notify, now_s)

        def take(statuses: tuple[ChannelStatus, ...]) -> None:
            watch.look(statuses)
            proposals.expire(machine_utc_s())
            show(statuses)

        host = MissionHost(
            QuietView(view, _STATE_S, now_s),
            commands,
            now_s,
            SHARING_REQUESTS,
            on_sharing=take,
            on_proposals=incoming.take,
        )
        async with self._supervisor.following(host):
            yield

    async def close(self) -> None:
        """End the process."""
        await self._supervisor.close()


@asynccontextmanager
async def open_sharing_process(
    settings: SharingSettings, notify: Callable[[Notice], None]
) -> AsyncIterator[SharingSupervisor | None]:
    """Start live sharing's process for as long as the context is entered, unless nothing is shared.

    Raises:
        ConfigurationError: a file that it needs cannot be used.
    """
    if not settings.any:
        yield None
        return
    make_channels(settings, os.environ, asyncio.get_running_loop().time, machine_utc_s)  # Refuses what cannot work.
    supervisor = SharingSupervisor(settings, notify)
    try:
        yield supervisor
    finally:
        await supervisor.close()
