"""Return settings that a mission has changed and, its program killed, not restored."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.planning.settings import PreflightSettings
from aos_gcs.runtime.restoring import Restoration, restore_all
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.store.return_settings import unrestored_settings
from tests.fakes.command_line import exit_status
from tests.fakes.fleet import FakeFleet
from tests.fakes.mission_flight import flying, prepare
from tests.fakes.program import unused_port

SETS_RETURN = PreflightSettings(upload_fence=True, set_return_height=True)

CONFIGURATION = """
[link]
urls = ["udpin://127.0.0.1:{port}"]

[mission]
vehicle_ids = [1, 2]
area_enu_m = [[-10.0, 30.0], [10.0, 30.0], [10.0, 75.0], [-10.0, 75.0]]

[record]
folder = "{folder}"
"""


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


@pytest.mark.virtual
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


async def test_the_command_sets_back_what_killed_missions_have_left(tmp_path: Path) -> None:
    await record(tmp_path, "1", (1, 3000.0, False), (2, 2500.0, False), (3, 2000.0, False), (4, 1500.0, False))
    await record(tmp_path, "2", (1, 3506.0, False))
    clock = LoopClock()
    fleet = FakeFleet(clock, 3, None)
    fleet.members[2].keeps_return_height = True
    fleet.members[3].started_s, fleet.members[3].silent_since_s = clock.now_s() - 20.0, clock.now_s() - 10.0
    for member in fleet.members.values():
        member.return_height_m = 35.06
    restored = await restore_all(fleet, clock, tmp_path, unrestored_settings(tmp_path), wait_s=0.0)
    assert restored == (
        Restoration(1, {"RTL_ALT": 3000.0}),
        Restoration(2, {"RTL_ALT": 2500.0}, "it keeps RTL_ALT"),
        Restoration(3, {"RTL_ALT": 2000.0}, "it is not heard"),
        Restoration(4, {"RTL_ALT": 1500.0}, "it is not heard"),
    )
    assert [member.return_height_m for member in fleet.members.values()] == [30.0, 35.06, 35.06]
    assert sorted(unrestored_settings(tmp_path)) == [2, 3, 4], "the record says that the first one has its own again"


def test_the_command_says_what_is_to_be_set_by_hand(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mission.toml"
    text = CONFIGURATION.format(port=unused_port(), folder=(tmp_path / "missions").as_posix())
    file.write_text(text, encoding="utf-8")
    assert command(file) == 0
    assert "No mission has left" in capsys.readouterr().out
    asyncio.run(record(tmp_path / "missions", "1", (1, 3000.0, False)))
    assert command(file) == 1
    assert "Vehicle 1: not restored: it is not heard. Set by hand: RTL_ALT = 3000" in capsys.readouterr().out


def command(file: Path) -> object:
    return exit_status(["restore", str(file), "--wait", "1"])
