"""A scripted mission in a mission folder."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType

from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.ports import Severity
from aos_gcs.store.database import MissionDatabase
from tests.fakes.mission import ScriptedMission

LENGTH_S = 40
START_UTC_S = 1.7e9


class HandClock(LoopClock):
    """Stands still until it is moved."""

    def __init__(self) -> None:
        self.utc = START_UTC_S

    def utc_s(self) -> float:
        return self.utc


async def record(
    folder: Path, length_s: int = LENGTH_S, vehicles: int = 8, manifest: Mapping[str, object] = MappingProxyType({})
) -> list[Event]:
    """Record a scripted mission of the folder's name, one snapshot per second, and return its events."""
    clock = HandClock()
    mission = ScriptedMission(clock, vehicles)
    mission.mission_id = folder.name
    database = MissionDatabase(folder, manifest)
    with mission.stream.subscribe(100_000) as subscription:
        await mission.act(Action.START, None)
        for second in range(length_s):
            clock.utc += 1.0
            mission.advance(1.0)
            if second % 10 == 0:
                mission.notify(Severity.INFO, f"second {second}")
            pictures = [picture for kind in PictureKind if (picture := mission.picture(kind))]
            database.write([partial(MissionDatabase.add_picture, picture=picture) for picture in pictures])
        subscription.close()
        events = [event async for event in subscription]
    database.write([partial(MissionDatabase.add_event, event=event) for event in events])
    database.close()
    return events
