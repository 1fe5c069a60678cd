"""What clients are told of a real coordinator: that it lives, and who has acknowledged what it says."""

from __future__ import annotations

import asyncio

import pytest

from aos_gcs.api.events.hub import EventHub
from aos_gcs.errors import MissionError
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.ports import Severity
from tests.fakes.mission_flight import flying, prepare

pytestmark = pytest.mark.virtual


async def test_a_mission_that_hangs_ages_although_its_server_lives(monkeypatch: pytest.MonkeyPatch) -> None:
    flight = prepare()
    hub = EventHub(flight.view)
    async with flying(flight) as run, asyncio.TaskGroup() as group:
        serving = group.create_task(hub.run())
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await asyncio.sleep(2.0)
        assert hub.mission_age_s() <= 0.3

        async def hang(duration_s: float) -> None:  # noqa: ARG001 - of the clock
            await asyncio.Event().wait()

        monkeypatch.setattr(flight.clock, "sleep", hang)
        await asyncio.sleep(4.0)
        assert 3.5 <= hub.mission_age_s() <= 4.5
        assert hub.hello().mission_age_s == hub.mission_age_s()
        flight.journal.notice(Severity.WARNING, "a driver lives longer than its mission")
        await asyncio.sleep(0.0)
        assert hub.mission_age_s() >= 3.5, "a notice is no sign of life of the mission itself"
        monkeypatch.undo()  # it has to be able to send its vehicles home
        serving.cancel()
        run.cancel()


async def test_acknowledgements_are_the_same_for_all_and_on_record() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        flight.journal.notice(Severity.WARNING, "wind", 2)
        await flight.commands.acknowledge([flight.journal.notice_count], operator="Ada")
        await flight.commands.acknowledge([flight.journal.notice_count], operator="Bob")
        with pytest.raises(MissionError, match="no notice 999 in this mission"):
            await flight.commands.acknowledge([999], operator="Ada")
        await run
    (given,) = flight.view.snapshot().acknowledgements
    told = [event.data for event in flight.recorder.events if isinstance(event.data, NoticeRecord)]
    notices = {notice.notice_id: notice.text for notice in told}
    assert (given.operator, notices[given.notice_id]) == ("Ada", "wind")
    assert sorted(notices) == list(range(1, flight.journal.notice_count + 1)), "numbered without gaps"
    recorded = [event.data for event in flight.recorder.events if isinstance(event.data, MissionSnapshot)]
    assert recorded[-1].acknowledgements == (given,)
