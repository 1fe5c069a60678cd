"""Choice of the vehicles heard that fly the mission, in virtual time: those chosen, and no other is ever armed."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.api.convert.mission import allowed_actions
from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.mission.preflight import checks
from aos_gcs.planning.settings import Deadlines, PreflightSettings
from aos_gcs.ports import Arm, Safeguard
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

BY_HAND = {"auto_start": False, "deadlines": Deadlines(capture_s=5.0)}


def commanded(flight: Flight) -> set[int]:
    return {vehicle_id for vehicle_id, vehicle in flight.fleet.members.items() if vehicle.commands}


def layers_m(flight: Flight) -> list[float | None]:
    return [vehicle.layer_height_m for vehicle in flight.view.snapshot().vehicles]


@pytest.mark.parametrize(
    ("named", "flown"),
    [({"vehicle_ids": (1, 3, 5)}, {1, 3, 5}), ({"any_vehicles": True}, {1, 2, 3})],
    ids=["named", "counted"],
)
async def test_a_spare_vehicle_is_neither_armed_nor_given_a_layer(named: dict[str, object], flown: set[int]) -> None:
    flight = prepare(5, vehicles=3, safety=SafetyOverrides(ceiling_m=41.0), **named)
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 1)
        assert [height_m for height_m in layers_m(flight) if height_m is not None] == [35.0, 37.5, 40.0]
        assert {v.telemetry.vehicle_id for v in flight.view.snapshot().vehicles if v.takes_part} == flown
        await flight.commands.act(Action.RETURN, None)
        await run
    assert commanded(flight) == flown
    assert flight.view.snapshot().message == "Mission over: 3 of 3 vehicles landed."


async def test_without_names_nothing_starts_until_an_operator_has_chosen() -> None:
    preflight = PreflightSettings(upload_fence=True, set_return_height=True)
    flight = prepare(5, vehicles=3, any_vehicles=False, preflight=preflight, **BY_HAND)
    async with flying(flight) as run:
        await flight.until(lambda: bool(flight.view.snapshot().preflight))
        await flight.clock.sleep(10.0)
        check = flight.check(checks.MISSION, checks.VEHICLES)
        assert (check.status, check.text) == (CheckStatus.FAIL, "3 planned, heard: 1, 2, 3, 4, 5")
        assert layers_m(flight) == [35.0, 37.5, 40.0, None, None]  # proposed, and nothing is written
        assert flight.check(1, checks.DESCENT).status is not CheckStatus.FAIL
        assert [vehicle.uploads for vehicle in flight.fleet.members.values()] == [0] * 5
        assert [vehicle.return_height_m for vehicle in flight.fleet.members.values()] == [30.0] * 5
        with pytest.raises(MissionError, match="preflight has not passed"):
            await flight.commands.act(Action.START, None)
        with pytest.raises(MissionError, match="at least one vehicle"):
            await flight.commands.act(Action.CHOOSE, ())
        with pytest.raises(MissionError, match="No vehicle 9"):
            await flight.commands.act(Action.CHOOSE, (2, 9))
        assert Action.CHOOSE in allowed_actions(flight.view.snapshot())
        await flight.commands.act(Action.CHOOSE, (5, 2, 4), operator="Ada")
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        assert [vehicle.uploads for vehicle in flight.fleet.members.values()] == [0, 1, 0, 1, 1]
        assert [height_m is None for height_m in layers_m(flight)] == [True, False, True, False, False]
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        with pytest.raises(MissionError, match="the mission has started"):
            await flight.commands.act(Action.CHOOSE, (1, 2))
        await flight.commands.act(Action.ABORT, None)
        await run
    assert commanded(flight) == {2, 4, 5}
    assert "Ada: vehicles 2, 4, 5 fly the mission" in flight.texts()


async def test_settings_read_just_before_the_confirmation_are_not_read_again_before_they_are_changed() -> None:
    preflight = PreflightSettings(upload_fence=True, set_return_height=True)
    flight = prepare(3, vehicles=3, any_vehicles=False, preflight=preflight, **BY_HAND)
    vehicles = list(flight.fleet.members.values())
    async with flying(flight) as run:
        await flight.clock.sleep(12.0)
        before = [vehicle.inspections for vehicle in vehicles]
        assert min(before) > 1, "the settings of proposed vehicles are read again and again"
        await flight.commands.act(Action.CHOOSE, (1, 2, 3))
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        assert [vehicle.uploads for vehicle in vehicles] == [1, 1, 1]
        assert [vehicle.inspections for vehicle in vehicles] == [number + 1 for number in before], "read back once"
        vehicles[0].facts["link_loss"] = Safeguard(False, "none", "set FS_GCS_ENABLE to 1")
        await flight.until(lambda: flight.mission.phase is Phase.PREFLIGHT)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_more_vehicles_than_fit_below_the_ceiling_do_not_launch() -> None:
    flight = prepare(5, vehicles=3, safety=SafetyOverrides(ceiling_m=41.0), **BY_HAND)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        await flight.commands.act(Action.CHOOSE, (1, 2, 3, 4))
        await flight.until(lambda: layers_m(flight)[3] == 42.5)
        await flight.clock.sleep(10.0)
        assert flight.mission.phase is Phase.PREFLIGHT
        check = flight.check(4, checks.ALTITUDE_LAYER)
        assert (check.status, check.text) == (CheckStatus.FAIL, "42.5 m, outside of 30 to 41 m")
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_named_vehicle_that_is_not_heard_ends_the_mission_on_the_ground() -> None:
    flight = prepare(3, vehicles=2, vehicle_ids=(2, 7))
    async with flying(flight) as run:
        assert await run is Outcome.FAILED
    assert "Missing: 7." in flight.view.snapshot().message
    assert commanded(flight) == set()


async def test_a_passer_by_far_away_blocks_no_launch_and_one_above_a_launch_point_only_that_climb() -> None:
    flight = prepare(4, vehicles=3, **BY_HAND)
    passer_by = flight.fleet.members[4]
    passer_by.armed = True
    passer_by.start_enu_m = passer_by.goal_enu_m = np.array([900.0, 0.0, 36.0])
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        passer_by.start_enu_m = passer_by.goal_enu_m = flight.fleet.members[1].home_enu_m + np.array([0.0, 0.0, 20.0])
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: flight.mission.phase is Phase.TAKEOFF)
        assert flight.task(1) is Task.IDLE
        assert any("stays on the ground: it cannot climb to its layer" in text for text in flight.texts())
        await flight.commands.act(Action.LAND, None)
        await run
    assert commanded(flight) == {2, 3}


async def test_a_passer_by_in_a_layer_blocks_until_it_is_no_longer_heard() -> None:
    flight = prepare(4, vehicles=3, **BY_HAND)
    passer_by = flight.fleet.members[4]
    passer_by.armed = True
    passer_by.start_enu_m = passer_by.goal_enu_m = np.array([0.0, 40.0, 36.0])
    async with flying(flight) as run:
        await flight.clock.sleep(10.0)
        assert flight.check(1, checks.ALTITUDE_LAYER).remedy == (
            "vehicle 4 has it or flies in it: land that vehicle first"
        )
        passer_by.silent_since_s = flight.clock.now_s()
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        check = flight.check(1, checks.ALTITUDE_LAYER)
        assert check.status is CheckStatus.WARN
        assert "vehicle 4 flew in it when last heard" in check.remedy
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_vehicles_armed_before_a_hold_take_off_after_it() -> None:
    flight = prepare(4, **BY_HAND)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.READY)
        flight.fleet.members[4].refuses = frozenset({Arm})
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: all(flight.fleet.members[number].armed for number in (1, 2, 3)))
        assert flight.mission.phase is Phase.ARM
        await flight.commands.act(Action.HOLD, None)
        await flight.clock.sleep(2.0)
        flight.fleet.members[4].refuses = frozenset()
        await flight.commands.act(Action.RESUME, None)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        assert [flight.task(number) for number in (1, 2, 3, 4)] == [Task.SWARM] * 4
        await flight.commands.act(Action.ABORT, None)
        await run
