"""Return settings that a mission has changed and, its program killed, not restored."""

from __future__ import annotations

from pathlib import Path

import pytest

from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.planning.settings import PreflightSettings
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.store.return_settings import unrestored_settings
from tests.fakes.mission_flight import flying, prepare

SETS_RETURN = PreflightSettings(upload_fence=True, set_return_height=True)


async def record(missions: Path, name: str, *settings: tuple[int, float, bool]) -> None:
    """Record a mission: settings of vehicles as id, former RTL_ALT, and whether that was restored."""
    async with MissionRecorder.create(missions, name, {}, notify=lambda _: None) as recorder:
        for vehicle_id, former, is_restored in settings:
            await recorder.record_settings(
                SettingsRecord(0.0, vehicle_id, "return height", {"RTL_ALT": former}, is_restored)
            )


async def test_settings_before_the_first_change_are_those_to_restore(tmp_path: Path) -> None:
    assert unrestored_settings(tmp_path / "missing") == {}
    await record(tmp_path, "1", (1, 3000.0, False), (1, 3000.0, True), (2, 3000.0, False))
    await record(tmp_path, "2", (2, 3506.0, False), (3, 1500.0, False))
    await record(tmp_path, "3", (3, 1500.0, True))
    (tmp_path / "4").mkdir()
    (tmp_path / "4" / "mission.sqlite").write_bytes(b"no database")
    assert unrestored_settings(tmp_path) == {2: {"RTL_ALT": 3000.0}}


@pytest.mark.looptime
@pytest.mark.parametrize("left_m", [35.06, 35.0])
async def test_what_a_killed_mission_has_left_is_not_taken_for_the_vehicles_own(left_m: float) -> None:
    flight = prepare(preflight=SETS_RETURN, unrestored={1: {"RTL_ALT": 3000.0}, 2: {"RTL_RETURN_ALT": 30.0}})
    first, second = flight.fleet.members[1], flight.fleet.members[2]
    first.return_height_m, second.return_height_m = left_m, 42.0
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        assert first.return_height_m == pytest.approx(35.0, abs=0.1)
        await run
    assert (first.return_height_m, second.return_height_m) == (30.0, 42.0)
    assert any("an earlier mission left its failsafe return height changed" in text for text in flight.texts())
    assert {record.vehicle_id for record in flight.recorder.settings if record.is_restored} >= {1, 2}
