"""Setting back what a mission whose program was killed has left changed on its vehicles."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ServiceConfig
from aos_gcs.errors import CommandError, RecordingError
from aos_gcs.mission.fleet.landing.return_heights import PURPOSE
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.ports import Clock, DriverContext, Fleet, Notice
from aos_gcs.runtime.drivers import load_driver
from aos_gcs.store.return_settings import note_restored, unrestored_settings

_POLL_S: Final = 0.2
_COMMAND_S: Final = 15.0
_FRESH_S: Final = 3.0


@dataclass(frozen=True, slots=True)
class Restoration:
    """Settings of one vehicle, and whether they were set back."""

    vehicle_id: int
    former: Mapping[str, float]
    """Values before the mission, by the autopilot's own names."""
    problem: str = ""
    """Why they are not set back; empty if they are."""


async def restore_return_settings(config: ServiceConfig, wait_s: float) -> tuple[Restoration, ...]:
    """Set the failsafe return settings back that killed missions have left, by their records.

    Args:
        config: links of the vehicles, and the folder of the records.
        wait_s: time for which vehicles that are not heard are waited for.

    Raises:
        ConfigurationError: a setting cannot be used.
        LinkError: a link cannot be opened, as while another program uses it.
    """
    missions = config.record.folder
    unrestored = await asyncio.to_thread(unrestored_settings, missions)
    if not unrestored:
        return ()
    clock = LoopClock()
    context = DriverContext(
        clock=clock,
        is_healthy=lambda: True,
        notify=_ignore,
        system_id=config.link.system_id,
        options=config.link.options,
    )
    async with load_driver(config.link.driver)(config.link.urls, context) as fleet:
        return await restore_all(fleet, clock, missions, unrestored, wait_s)


async def restore_all(
    fleet: Fleet, clock: Clock, missions: Path, unrestored: Mapping[int, Mapping[str, float]], wait_s: float
) -> tuple[Restoration, ...]:
    """Set settings back on all vehicles of a fleet at the same time, and note it in the records below ``missions``."""
    deadline_s = clock.now_s() + wait_s
    return tuple(
        await asyncio.gather(
            *(_restore(fleet, clock, missions, Restoration(*item), deadline_s) for item in sorted(unrestored.items()))
        )
    )


async def _restore(fleet: Fleet, clock: Clock, missions: Path, wanted: Restoration, heard_by_s: float) -> Restoration:
    vehicle_id, former = wanted.vehicle_id, wanted.former
    while not _is_heard(fleet, vehicle_id, clock.now_s()):
        if clock.now_s() >= heard_by_s:
            return Restoration(vehicle_id, former, "it is not heard")
        await clock.sleep(_POLL_S)
    try:
        await fleet.vehicles()[vehicle_id].restore_return(former, clock.now_s() + _COMMAND_S)
        record = SettingsRecord(clock.utc_s(), vehicle_id, PURPOSE, former, is_restored=True)
        await asyncio.to_thread(note_restored, missions, record)
    except (CommandError, RecordingError) as error:
        return Restoration(vehicle_id, former, str(error))
    return wanted


def _is_heard(fleet: Fleet, vehicle_id: int, now_s: float) -> bool:
    vehicle = fleet.vehicles().get(vehicle_id)
    heard_at_s = None if vehicle is None else vehicle.state.heard_at_s
    return heard_at_s is not None and now_s - heard_at_s <= _FRESH_S


def _ignore(_notice: Notice) -> None:
    """Ignore what vehicles report: no mission is flown."""
