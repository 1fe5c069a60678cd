"""The service: driver, coordinator, record and dashboard's process of one mission, put together and run."""

from __future__ import annotations

import asyncio
import platform
import shutil
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, nullcontext
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from aos_gcs.clock import LoopClock, machine_utc_s
from aos_gcs.config.model import ServiceConfig
from aos_gcs.config.settings import mission_settings, sharing_settings
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.next_sortie import NextSortie
from aos_gcs.mission.search.ground.mapping import GroundPlace
from aos_gcs.ports import DriverContext
from aos_gcs.process import settle_garbage
from aos_gcs.runtime.dashboard.start import ApiStart
from aos_gcs.runtime.dashboard.supervisor import open_api_process
from aos_gcs.runtime.drivers import load_driver
from aos_gcs.runtime.encryption import with_certificate
from aos_gcs.runtime.processes.sharing_supervisor import SharingSupervisor, open_sharing_process
from aos_gcs.runtime.processes.workers import ANALYSIS, DECODING, GROUND
from aos_gcs.runtime.sign_in import operator_secrets
from aos_gcs.store.last_mission import former_flight, last_proposals, unfinished_mission
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.store.return_settings import unrestored_settings
from aos_gcs.store.schema import GROUND_NAME
from aos_gcs.workers.process import open_worker

_ANSWER_S = 0.5
"""Real seconds for the answer to the operator who asks for a new sortie: the dashboard's process ends after them."""


_NEEDED_IN_FLIGHT = ("scipy.ndimage", "scipy.optimize", "scipy.sparse.csgraph", "scipy.spatial", "scipy.special")
"""Parts of SciPy that are imported before anything flies: it would import them when a step first computes with them."""


@dataclass(frozen=True, slots=True)
class Service:
    """One mission with its links, its record and its dashboard open."""

    mission: Coordinator
    folder: Path
    """Folder in which the mission is recorded."""
    clock: LoopClock
    _journal: Journal
    _recorder: MissionRecorder

    async def run(self) -> MissionSnapshot:
        """Run the mission to its end and return its last state; all of it is recorded by then."""
        async with self._journal.recorded(self._recorder):
            await self.mission.run()
        return self.mission.view.snapshot()

    async def stay(self, *, until_landed: bool = False) -> NextSortie | None:
        """Keep the dashboard up, and the heartbeat; record how operators judge the findings, and what still flies.

        Args:
            until_landed: return when no vehicle heard flies any more; else it goes on until cancelled.

        Returns:
            What the sortie that an operator has asked for begins with, for ``open_service``; None if nobody has.
        """
        async with self._journal.recorded(self._recorder):
            following = await self.mission.stay(until_landed=until_landed)
        if following is not None:
            await asyncio.sleep(_ANSWER_S)
        return following


@asynccontextmanager
async def open_service(config: ServiceConfig, following: NextSortie | None = None) -> AsyncIterator[Service]:
    """Open everything a mission needs, for as long as the context is entered; ``run`` then runs it.

    Args:
        config: configuration of the service.
        following: what the former sortie of the operation has left; None for the first one.

    Raises:
        ConfigurationError: a setting cannot be used; nothing was opened or written.
        LinkError: a link or the dashboard's port cannot be opened; nothing is left behind.
    """
    for name in _NEEDED_IN_FLIGHT:
        import_module(name)
    settings = mission_settings(config) if following is None else following.settings
    receivers = sharing_settings(config)
    open_driver = load_driver(config.link.driver)
    secrets = operator_secrets(config.api, config.record.folder)
    clock = LoopClock(config.clock_speed)
    journal = Journal(clock)
    loop_monitor = LoopMonitor()
    started = datetime.now(UTC)
    mission_id = f"{started:%Y%m%d-%H%M%S-%f}-{config.swarm.strategy}"
    folder = config.record.folder / mission_id
    unfinished = None if settings.any_vehicles else unfinished_mission(config.record.folder)
    former = former_flight(config.record.folder, clock.utc_s())
    unrestored = unrestored_settings(config.record.folder)
    proposals = last_proposals(config.record.folder) if receivers.has_proposals else ()
    start = ApiStart(
        with_certificate(config.api, config.record.folder, started), secrets.code, config.record.folder, folder
    )
    opened = False
    try:
        async with (
            open_api_process(start, journal.take) as api,
            open_sharing_process(receivers, journal.take) as sharing,
            open_worker(ANALYSIS) as imaging,
            open_worker(DECODING) as decoding,
            open_worker(GROUND) as mapping,
            MissionRecorder.create(
                config.record.folder, mission_id, _manifest(config, started, following), notify=journal.take
            ) as recorder,
        ):
            context = DriverContext(
                clock=clock,
                is_healthy=loop_monitor.is_healthy,
                notify=journal.take,
                log_folder=recorder.log_folder,
                system_id=config.link.system_id,
                options=config.link.options,
                decoding=decoding,
                former=None if former is None else former.links,
            )
            # Before the links: once they are open the mission runs, and with it the heartbeat.
            await asyncio.gather(imaging.ready(), decoding.ready())
            settle_garbage()
            async with open_driver(config.link.urls, context) as fleet:
                mission = Coordinator(
                    mission_id,
                    settings,
                    fleet=fleet,
                    clock=clock,
                    journal=journal,
                    recorder=recorder,
                    loop_monitor=loop_monitor,
                    max_command_age_s=config.api.max_command_age_s,
                    imaging=imaging,
                    former=former,
                    unrestored=unrestored,
                    following=following,
                    ground=GroundPlace(
                        mapping,
                        _ground_of(config, mission_id),
                        carried=None if following is None else _ground_before(config, following),
                        interrupted=None if former is None else _ground_of(config, former.last.mission_id),
                    ),
                )
                mission.view.proposals.restore(proposals, machine_utc_s())
                if unfinished is not None:
                    mission.auto_start.cancel(f"the last mission, {unfinished}, did not end: vehicles may still fly")
                async with (
                    nullcontext() if api is None else api.showing(mission.view, mission.commands),
                    nullcontext() if sharing is None else _handed_over(sharing, mission),
                ):
                    opened = True
                    yield Service(mission, folder, clock, journal, recorder)
    finally:
        if not opened:
            shutil.rmtree(folder, ignore_errors=True)


def _handed_over(sharing: SharingSupervisor, mission: Coordinator) -> AbstractAsyncContextManager[None]:
    view = mission.view
    return sharing.following(view, mission.commands, view.show_sharing, view.proposals)


def _ground_of(config: ServiceConfig, mission_id: str) -> Path:
    """Return the folder of a mission's map of the searched ground."""
    return config.record.folder / mission_id / GROUND_NAME


def _ground_before(config: ServiceConfig, following: NextSortie) -> Path:
    """Return the folder of the map that a sortie goes on with."""
    return _ground_of(config, following.former_id) if following.folder is None else following.folder / GROUND_NAME


def _manifest(config: ServiceConfig, started: datetime, following: NextSortie | None) -> dict[str, object]:
    operation = {} if following is None else {"operation": following.operation, "sortie": following.number}
    return operation | {
        "started_utc": started.isoformat(),
        "aos_gcs": version("aos-gcs"),
        "python": platform.python_version(),
        "configuration": config.model_dump(mode="json"),
    }
