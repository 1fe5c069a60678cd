"""Notices and their acknowledgements in a record, and in one that is older than both."""

from __future__ import annotations

import sqlite3
from functools import partial
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.events import Event, NoticeRecord
from aos_gcs.ports import Severity
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay
from aos_gcs.store.schema import DATABASE_NAME
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock


async def record_acknowledged(folder: Path) -> None:
    """Record three notices, a second apart; the second is acknowledged with the third."""
    clock = HandClock()
    mission = ScriptedMission(clock, 2)
    events: list[Event] = []
    with mission.stream.subscribe() as subscription:
        for number in range(1, 4):
            clock.utc += 1.0
            mission.notify(Severity.WARNING, f"notice {number}")
            if number == 3:
                await mission.acknowledge([2], operator="Ada")
            mission.advance(1.0)
        subscription.close()
        events = [event async for event in subscription]
    database = MissionDatabase(folder, {})
    database.write([partial(MissionDatabase.add_event, event=event) for event in events])
    database.close()


def numbers(replay: MissionReplay) -> list[int]:
    return [event.data.notice_id for event in replay._past() if isinstance(event.data, NoticeRecord)]


async def test_a_replay_shows_who_had_acknowledged_what_by_then(tmp_path: Path) -> None:
    await record_acknowledged(tmp_path / "m")
    with MissionReader(tmp_path / "m") as reader:
        replay = MissionReplay(reader, LoopClock())
        assert replay.snapshot().acknowledgements == ()
        replay.seek(time_s=2.0)
        (given,) = replay.snapshot().acknowledgements
        assert (given.notice_id, given.operator) == (2, "Ada")
        assert numbers(replay) == [1, 2, 3]


async def test_notices_of_older_records_are_numbered_in_their_order(tmp_path: Path) -> None:
    await record_acknowledged(tmp_path / "m")
    with sqlite3.connect(tmp_path / "m" / DATABASE_NAME) as database:
        database.execute("UPDATE events SET data = json_remove(data, '$.notice_id', '$.acknowledgements')")
    with MissionReader(tmp_path / "m") as reader:
        replay = MissionReplay(reader, LoopClock())
        replay.seek(time_s=2.0)
        assert replay.snapshot().acknowledgements == ()
        assert numbers(replay) == [1, 2, 3]
