"""Preflight of whole missions on a fake fleet, in virtual time: asked vehicles, written fences, refused launches."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.preflight import checks
from aos_gcs.mission.preflight.overrides import BY_CONFIGURATION
from aos_gcs.planning.settings import Deadlines, PreflightSettings
from aos_gcs.ports import Geofence, Safeguard
from tests.fakes.fleet import ORIGIN
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

OVER_RELIEF = {checks.TERRAIN, checks.RETURN_CLIMB}
BY_HAND = {"auto_start": False, "deadlines": Deadlines(capture_s=5.0)}
REFRESH_S = 10.0
OFTEN = PreflightSettings(upload_fence=True, refresh_s=REFRESH_S)
SETS_RETURN = PreflightSettings(upload_fence=True, set_return_height=True)
OFF = Safeguard(False, "none (FS_GCS_ENABLE = 0)", "set FS_GCS_ENABLE to 1")


async def until_ready(flight: Flight) -> None:
    await flight.until(lambda: flight.mission.phase is Phase.READY)


async def test_a_good_fleet_shows_every_check_of_every_vehicle() -> None:
    flight = prepare(n=2, **BY_HAND)
    async with flying(flight) as run:
        await until_ready(flight)
        matrix = flight.view.snapshot().preflight
        assert [(check.vehicle_id, check.name) for check in matrix] == [
            (vehicle_id, name) for vehicle_id in (1, 2) for name in checks.ORDER if name not in OVER_RELIEF
        ]
        assert {check.status for check in matrix if check.name != checks.CLOCK} == {CheckStatus.PASS}
        assert flight.check(1, checks.CAMERA).text == (
            "96 x 96, red green blue thermal, 90° below the horizon, 0.0 m from the vehicle"
        )
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.parametrize("safety", [SafetyOverrides(), SafetyOverrides(separation_m=1.5)], ids=["left out", "written"])
async def test_launch_points_are_two_metres_apart_whether_the_separation_is_written_or_not(
    safety: SafetyOverrides,
) -> None:
    flight = prepare(n=2, safety=safety, **BY_HAND)
    first, second = flight.fleet.members.values()
    second.home_enu_m = second.start_enu_m = second.goal_enu_m = first.home_enu_m + np.array([1.8, 0.0, 0.0])
    async with flying(flight) as run:
        await flight.until(lambda: bool(flight.view.snapshot().preflight))
        assert flight.check(2, checks.LAUNCH_POINT).status is CheckStatus.FAIL
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_the_written_fence_is_the_one_that_the_mission_keeps() -> None:
    zone = ((20.0, 20.0), (24.0, 20.0), (22.0, 24.0))
    flight = prepare(n=2, safety=SafetyOverrides(no_go_enu_m=(zone,)), **BY_HAND)
    async with flying(flight) as run:
        await until_ready(flight)
        fences = [vehicle.fence for vehicle in flight.fleet.members.values()]
        await flight.commands.act(Action.ABORT, None)
        await run
    frame = LocalFrame(ORIGIN)
    for fence in fences:
        assert fence is not None
        for ring, ring_enu_m in zip(
            (fence.inclusion_deg, *fence.exclusions_deg),
            (flight.view.snapshot().fence_enu_m, zone),
            strict=True,
        ):
            corners = [frame.to_geodetic(np.array([*corner, 0.0])) for corner in ring_enu_m]
            assert ring == tuple((round(c.latitude_deg, 7), round(c.longitude_deg, 7)) for c in corners)
        assert fence.ceiling_above_home_m == 42.5


async def test_vehicles_are_not_asked_again_and_again() -> None:
    flight = prepare(n=2, preflight=OFTEN, **BY_HAND)
    async with flying(flight) as run:
        await until_ready(flight)
        vehicle = flight.fleet.members[1]
        before = (vehicle.inspections, vehicle.uploads, vehicle.images)
        await flight.clock.sleep(0.8 * REFRESH_S)
        assert (vehicle.inspections, vehicle.uploads, vehicle.images) == before
        assert before <= (4, 1, 1)
        await flight.clock.sleep(0.4 * REFRESH_S)
        assert vehicle.inspections == before[0] + 1
        await flight.clock.sleep(0.7 * REFRESH_S)
        await flight.commands.act(Action.START, None)
        await run
    assert flight.view.snapshot().elapsed_s > REFRESH_S
    assert vehicle.inspections == before[0] + 1, "who flies is left alone"


async def test_a_fence_is_not_written_unless_told_to() -> None:
    flight = prepare(n=2, preflight=PreflightSettings(), **BY_HAND)
    async with flying(flight) as run:
        await flight.clock.sleep(10.0)
        check = flight.check(1, checks.GEOFENCE)
        assert (check.status, check.text, check.overridable) == (CheckStatus.FAIL, "none", True)
        assert "allow this station to upload geofences" in check.remedy
        assert [vehicle.uploads for vehicle in flight.fleet.members.values()] == [0, 0]
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_what_is_off_refuses_the_launch_until_it_is_on_or_overridden() -> None:
    flight = prepare(n=2, **BY_HAND)
    flight.fleet.members[1].facts = {"link_loss": OFF}
    flight.fleet.members[2].facts = {"link_loss": OFF}
    async with flying(flight) as run:
        await flight.clock.sleep(10.0)
        assert flight.check(1, checks.LINK_LOSS).describe() == (
            "vehicle 1, link-loss failsafe: none (FS_GCS_ENABLE = 0); set FS_GCS_ENABLE to 1"
        )
        with pytest.raises(MissionError, match="preflight has not passed"):
            await flight.commands.act(Action.START, None)
        await flight.commands.override_check(2, checks.LINK_LOSS, "a pilot stands by", operator="Ada")
        await flight.clock.sleep(10.0)
        assert flight.mission.phase is Phase.PREFLIGHT, "the override is for one vehicle"
        flight.fleet.members[1].facts = {}
        await until_ready(flight)
        assert "1 failed checks overridden" in flight.view.snapshot().message
        assert any("overridden by Ada: a pilot stands by" in text for text in flight.texts())
        await flight.commands.override_check(2, checks.LINK_LOSS, None, operator="Ada")
        await flight.until(lambda: flight.mission.phase is Phase.PREFLIGHT)
        await flight.commands.act(Action.ABORT, None)
        await run
    overrides = [record for record in flight.recorder.actions if record.action is Action.OVERRIDE]
    assert [(record.check, record.reason, record.operator) for record in overrides] == [
        (checks.LINK_LOSS, "a pilot stands by", "Ada"),
        (checks.LINK_LOSS, None, "Ada"),
    ]


async def test_an_unattended_mission_overrides_what_its_configuration_names_and_nothing_else() -> None:
    standing = PreflightSettings(upload_fence=True, overrides={checks.LINK_LOSS: "in a net"})
    flight = prepare(n=2, preflight=standing)
    flight.fleet.members[1].facts = {"link_loss": OFF}
    flight.fleet.members[2].camera_works = False
    async with flying(flight) as run:
        assert await run is Outcome.FAILED
    assert "vehicle 2, camera: no frame" in flight.view.snapshot().message
    assert not any(vehicle.commands for vehicle in flight.fleet.members.values())
    (record,) = [record for record in flight.recorder.actions if record.action is Action.OVERRIDE]
    assert (record.vehicle_ids, record.check, record.operator) == ((1,), checks.LINK_LOSS, BY_CONFIGURATION)


async def test_a_fence_that_a_vehicle_denies_is_told_in_its_words() -> None:
    flight = prepare(n=2, **BY_HAND)
    flight.fleet.members[2].refuses = frozenset({Geofence})
    async with flying(flight) as run:
        await flight.clock.sleep(10.0)
        assert flight.check(2, checks.GEOFENCE).remedy.endswith("points: no space")
        assert flight.check(1, checks.GEOFENCE).status is CheckStatus.PASS
        flight.fleet.members[2].refuses = frozenset()
        await until_ready(flight)
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_a_fence_that_somebody_changes_is_noticed_and_replaced() -> None:
    flight = prepare(n=2, preflight=OFTEN, **BY_HAND)
    async with flying(flight) as run:
        await until_ready(flight)
        vehicle = flight.fleet.members[1]
        ours = vehicle.fence
        vehicle.fence = Geofence(((48.0, 14.0), (48.0, 14.1), (48.1, 14.1)))
        await flight.clock.sleep(REFRESH_S + 5.0)
        assert vehicle.fence == ours
        assert flight.mission.phase is Phase.READY
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_return_heights_are_those_of_the_layers_until_all_have_landed() -> None:
    flight = prepare(n=2, preflight=SETS_RETURN, **BY_HAND)
    first, second = flight.fleet.members.values()
    first.return_height_m = 60.0
    async with flying(flight) as run:
        await until_ready(flight)
        assert [first.return_height_m, second.return_height_m] == pytest.approx([35.0, 37.5], abs=0.1)
        assert flight.check(2, checks.RETURN_HEIGHT).text.startswith("37.5")
        assert [(record.vehicle_id, record.former, record.is_restored) for record in flight.recorder.settings] == [
            (1, {"RTL_ALT": 6000.0}, False),
            (2, {"RTL_ALT": 3000.0}, False),
        ]
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: len(flight.view.steps()) == 1)
        assert [first.return_height_m, second.return_height_m] == pytest.approx([35.0, 37.5], abs=0.1)
        await run
    assert [first.return_height_m, second.return_height_m] == [60.0, 30.0]
    assert sorted(record.vehicle_id for record in flight.recorder.settings if record.is_restored) == [1, 2]
    assert any(text.endswith("failsafe return height restored") for text in flight.texts())


async def test_the_height_before_is_on_record_before_another_one_is_written() -> None:
    flight = prepare(n=2, preflight=SETS_RETURN, **BY_HAND)
    heights_m: list[float] = []
    flight.recorder.on_flush = lambda: heights_m.append(flight.fleet.members[1].return_height_m)
    async with flying(flight) as run:
        await until_ready(flight)
        assert heights_m[0] == 30.0
        await flight.commands.act(Action.ABORT, None)
        await run
    assert flight.fleet.members[1].return_height_m == 30.0, "an aborted mission sets it back too"


async def test_return_heights_are_not_written_unless_told_to_but_refuse_the_launch() -> None:
    flight = prepare(n=2, **BY_HAND)
    flight.fleet.members[2].return_height_m = 60.0
    async with flying(flight) as run:
        await flight.clock.sleep(10.0)
        check = flight.check(2, checks.RETURN_HEIGHT)
        assert (check.status, check.text, check.overridable) == (CheckStatus.FAIL, "60 m", True)
        assert "allow this station to set return heights" in check.remedy
        assert flight.check(1, checks.RETURN_HEIGHT).status is CheckStatus.PASS
        assert flight.fleet.members[2].return_height_m == 60.0
        flight.fleet.members[2].return_height_m = 37.5
        await until_ready(flight)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert flight.recorder.settings == []


async def test_who_keeps_its_return_height_does_not_start_and_who_is_lost_is_named() -> None:
    flight = prepare(n=2, preflight=SETS_RETURN, **BY_HAND)
    first, second = flight.fleet.members.values()
    second.keeps_return_height = True
    async with flying(flight) as run:
        await flight.clock.sleep(10.0)
        check = flight.check(2, checks.RETURN_HEIGHT)
        assert (check.text, check.remedy) == ("30 m, change refused", "it keeps RTL_ALT")
        second.keeps_return_height = False
        await until_ready(flight)
        first.silent_since_s = flight.clock.now_s()
        await flight.clock.sleep(5.0)
        await flight.commands.act(Action.ABORT, None)
        await run
    assert second.return_height_m == 30.0
    assert "failsafe return height not restored (its link is lost). Set it by hand: RTL_ALT = 3000" in flight.texts()


async def test_a_vehicle_that_falls_silent_is_not_asked_but_fails() -> None:
    flight = prepare(n=2, **BY_HAND)
    flight.fleet.members[2].silent_since_s = flight.clock.now_s()
    async with flying(flight) as run:
        await flight.clock.sleep(8.0)
        assert flight.check(2, checks.LINK).status is CheckStatus.FAIL
        assert flight.check(2, checks.GEOFENCE).status is CheckStatus.FAIL
        assert flight.fleet.members[1].uploads == 1
        await flight.commands.act(Action.ABORT, None)
        await run


async def test_launch_points_behind_one_another_get_layers_from_the_front_up() -> None:
    flight = prepare(n=3, **BY_HAND)
    for vehicle_id, vehicle in flight.fleet.members.items():
        vehicle.home_enu_m = np.array([0.0, -25.0 + 6.0 * vehicle_id, float(vehicle.home_enu_m[2])])
        vehicle.__post_init__()
        vehicle.return_height_m = 20.0
    async with flying(flight) as run:
        await until_ready(flight)
        assert [vehicle.layer_height_m for vehicle in flight.view.snapshot().vehicles] == [40.0, 37.5, 35.0]
        assert flight.check(1, checks.DESCENT).status is CheckStatus.PASS
        await flight.commands.act(Action.ABORT, None)
        await run
