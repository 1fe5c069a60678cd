"""Decisions on the findings of a survey."""

from __future__ import annotations

from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.examination.state import SurveyPlace, SurveyState, restored
from aos_gcs.examination.survey_mission import SurveyMission
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import FindingChange, FindingStatus, TargetEstimate
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder

PLACE = SurveyPlace("s", GeodeticPosition(48.3, 14.3, 310.0), ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0)), 2.5)
CONFIRMED = FindingChange(status=FindingStatus.CONFIRMED)


def target(track_id: int, east_m: float, kind: FindingKind = FindingKind.PERSON) -> TargetEstimate:
    return TargetEstimate((east_m, 0.0, 2.5), 0.4, 5, track_id=track_id, seen_at_s=float(track_id), kind=kind)


@pytest.fixture
async def mission(tmp_path: Path) -> AsyncIterator[SurveyMission]:
    async with MissionRecorder.create(tmp_path, "s", {}, notify=lambda _: None) as recorder:
        mission = SurveyMission(SurveyState(PLACE.snapshot()), recorder, LoopClock())
        mission.observe([target(1, 0.0), target(2, 6.0)], 1)
        await mission.update(step=1)
        yield mission


async def test_a_decision_that_cannot_be_kept_is_refused(
    mission: SurveyMission, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("aos_gcs.store.database.MissionDatabase.add_event", full)
        with pytest.raises(MissionError, match=r"not kept: .*No space left on device; free some space"):
            await mission.change_finding(1, CONFIRMED, operator="Ada")
    assert mission.snapshot().findings[0].status is FindingStatus.NEW
    await mission.change_finding(1, CONFIRMED, operator="Ada")
    assert mission.snapshot().findings[0].status is FindingStatus.CONFIRMED


async def test_an_empty_change_leaves_no_trace(mission: SurveyMission) -> None:
    before = mission.snapshot()
    assert await mission.change_finding(1, FindingChange(), operator="Ada") == before.findings[0]
    assert mission.snapshot() == before


async def test_what_another_window_sees_again_keeps_its_number_and_its_decision(mission: SurveyMission) -> None:
    await mission.change_finding(2, FindingChange(status=FindingStatus.REJECTED), operator="Ada")
    new = mission.observe([target(3, 0.4), target(4, 6.3), target(5, 30.0)], 2)
    assert [finding.finding_id for finding in new] == [3]
    await mission.update()
    statuses = [finding.status for finding in mission.snapshot().findings]
    assert statuses == [FindingStatus.NEW, FindingStatus.REJECTED, FindingStatus.NEW]
    assert mission.persons == 2


async def test_reasons_and_significance_are_those_of_the_window_that_is_shown(mission: SurveyMission) -> None:
    for track_id, significance in ((3, 7.0), (4, 12.0)):
        seen = replace(target(track_id, 0.2), reasons=(f"window {track_id}",), significance=significance)
        mission.observe([seen], track_id)
        await mission.update()
        finding, other = mission.snapshot().findings
        assert (finding.reasons, finding.significance, finding.step) == (
            (f"window {track_id}",),
            significance,
            track_id,
        )
        assert (other.reasons, other.significance) == ((), None)


async def test_a_place_marked_by_hand_lies_on_the_ground(mission: SurveyMission) -> None:
    finding = await mission.add_finding((8.0, 1.0, 0.0), "tent", operator="Ada")
    assert (finding.position_enu_m, finding.step, finding.operator) == ((8.0, 1.0, 2.5), 1, "Ada")


async def test_a_record_restores_what_was_known(tmp_path: Path) -> None:
    async with MissionRecorder.create(tmp_path, "s", {}, notify=lambda _: None) as recorder:
        mission = SurveyMission(SurveyState(PLACE.snapshot()), recorder, LoopClock())
        mission.observe([target(1, 0.0)], 1)
        await mission.change_finding(1, CONFIRMED, operator="Ada")
        known = mission.snapshot().findings
    for _ in range(2):
        with MissionReader(tmp_path / "s") as reader:
            state = restored(reader)
        assert state.findings == known
        async with MissionRecorder.reopen(tmp_path / "s", 0, notify=lambda _: None) as recorder:
            again = SurveyMission(state, recorder, LoopClock())
            await again.change_finding(1, FindingChange(comment=f"after {state.event_count}"), operator="Bob")
            known = again.snapshot().findings
    assert known[0].comment.startswith("after ")
    assert known[0].status is FindingStatus.CONFIRMED
