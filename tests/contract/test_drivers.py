"""What drivers do beyond the Vehicle port: their links, and what they tell of autopilots."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import CommandRefusedError, CommandTimeoutError
from aos_gcs.ports import Arm, FlightMode, FormerLinks, Goto, Hold, Land, ProvenLink, ReturnToLaunch, Severity, Vehicle
from aos_sim.camera.component import CameraComponent
from tests.contract.vehicle_bench import MAVSDK, each_driver, fence_of, mute_vehicles, open_driver, pairs
from tests.fakes.air_flight import IMAGE_SIZE_PX


@each_driver
async def test_heartbeats_stop_with_the_health_of_the_service(implementation: str) -> None:
    async with (
        open_driver(implementation, "arducopter", vehicles=1) as bench,
        mute_vehicles(bench.clock, bench.port, range(50, 51)) as mute,
    ):
        await bench.until(lambda: mute.heard.count("HEARTBEAT") >= 2)
        bench.health.is_good = False
        await bench.clock.sleep(3.0)
        mute.heard.clear()
        await bench.clock.sleep(10.0)
        assert "HEARTBEAT" not in mute.heard
        bench.health.is_good = True
        await bench.until(lambda: "HEARTBEAT" in mute.heard)


@each_driver
async def test_a_second_sender_with_the_id_of_a_vehicle_in_flight_is_ignored(implementation: str) -> None:
    async with open_driver(implementation, "arducopter", vehicles=1) as bench:
        await bench.all_ready()
        vehicle = await bench.fly(1)
        async with mute_vehicles(bench.clock, bench.port, range(1, 2)) as stranger:
            await bench.until(lambda: any("another sender" in notice.text for notice in bench.notices))
            states = []
            for _ in range(10):
                await bench.clock.sleep(0.5)
                states.append(vehicle.state)
            assert all(state.armed and not state.is_ambiguous for state in states)
            assert {state.mode for state in states} == {FlightMode.GUIDED}
            await vehicle.execute(Hold(), bench.after(30.0))
            await vehicle.execute(Land(), bench.after(30.0))
        assert "COMMAND_INT" not in stranger.heard
        (proof,) = vehicle.state.proven
        assert proof.board_id
        assert proof.since_boot_s


@each_driver
async def test_a_vehicle_of_a_former_flight_is_not_taken_for_whoever_uses_its_id_elsewhere(implementation: str) -> None:
    former = FormerLinks(0.0, {50: (ProvenLink("0 127.0.0.9 9", "ab", 60.0),), 51: (ProvenLink("damaged"),)})
    async with (
        open_driver(implementation, "arducopter", vehicles=1, former=former) as bench,
        mute_vehicles(bench.clock, bench.port, range(50, 52)) as mute,
    ):
        await bench.until(lambda: {1, 51} <= set(bench.fleet.vehicles()))
        assert 50 not in bench.fleet.vehicles()
        told = [notice.text for notice in bench.notices if notice.vehicle_id == 50]
        assert len(told) == 1
        assert "it flew at 127.0.0.9:9 before this station was restarted" in told[0]
        # It answers no question for its board, and nothing is heard at the former address.
        await bench.until(lambda: 50 in bench.fleet.vehicles())
        assert "HEARTBEAT" in mute.heard
        assert bench.vehicle(1).state.proven == ()


@each_driver
async def test_silent_vehicles_delay_no_other(implementation: str) -> None:
    async with (
        open_driver(implementation, "arducopter", vehicles=1) as bench,
        mute_vehicles(bench.clock, bench.port, range(50, 70)),
    ):
        await bench.until(lambda: len(bench.fleet.vehicles()) == 21)
        await bench.until(lambda: bool(bench.vehicle(1).state.ready_to_arm))
        waiting = [
            asyncio.create_task(bench.vehicle(number).execute(Arm(), bench.after(600.0))) for number in range(50, 70)
        ]
        await bench.clock.sleep(1.0)
        await bench.fly(1)
        assert bench.motion(1).position_enu_m[2] == pytest.approx(10.0, abs=1.2)
        assert not any(task.done() for task in waiting)
        for task in waiting:
            task.cancel()
        await asyncio.wait(waiting)


@each_driver
async def test_failsafes_that_are_off_are_told_with_their_remedy(implementation: str) -> None:
    async with open_driver(implementation, "arducopter", vehicles=1, factory_settings=True) as bench:
        await bench.all_ready()
        facts = await bench.vehicle(1).inspect(bench.after(100.0))
        assert (facts.link_loss.is_on, facts.low_battery.is_on, facts.at_fence.is_on) == (False, False, False)
        assert facts.link_loss.remedy == "set FS_GCS_ENABLE to 1 (return)"
        assert facts.return_height_m == 15.0


@each_driver
async def test_rally_points_and_exceptions_from_the_failsafe_are_found(implementation: str) -> None:
    async with open_driver(implementation, "px4", vehicles=1) as bench:
        await bench.all_ready()
        good = await bench.vehicle(1).inspect(bench.after(100.0))
        assert (good.link_loss.is_on, good.return_place.is_on, good.other_failsafes.is_on) == (True, True, True)
        autopilot = bench.swarm.vehicle(1).autopilot
        autopilot.fence_service.rally_points = 1
        autopilot.parameters["COM_DLL_EXCEPT"] = 2
        bad = await bench.vehicle(1).inspect(bench.after(100.0))
        assert (bad.return_place.is_on, bad.return_place.text) == (False, "a rally point")
        assert (bad.link_loss.is_on, bad.link_loss.remedy) == (False, "set COM_DLL_EXCEPT to 0")


@each_driver
async def test_link_and_clock_are_measured(implementation: str) -> None:
    async with open_driver(implementation, "arducopter", vehicles=2) as bench:
        opened_s = bench.clock.now_s()
        await bench.all_ready()
        await bench.until(lambda: all(_has_clock(vehicle) for vehicle in bench.fleet.vehicles().values()))
        # A starved machine answers late, but no later than now; in virtual time nothing delays an answer.
        longest_s = bench.clock.now_s() - opened_s if implementation == MAVSDK else 1.0
        for vehicle in bench.fleet.vehicles().values():
            link, loss = vehicle.state.link, vehicle.state.packet_loss_fraction
            assert link is not None
            assert link.address.startswith("127.0.0.1:")
            assert link.living_addresses == 1
            assert link.round_trip_s is not None
            assert 0.0 < link.round_trip_s < longest_s
            assert loss is not None
            assert loss < 0.05, "nothing is lost on the way"


def _has_clock(vehicle: Vehicle) -> bool:
    return vehicle.state.link is not None and vehicle.state.link.clock_offset_s is not None


@each_driver
async def test_the_link_is_logged_and_an_uneventful_flight_alarms_nobody(implementation: str, tmp_path: Path) -> None:
    async with open_driver(implementation, "arducopter", vehicles=1, log_folder=tmp_path) as bench:
        await bench.all_ready()
        vehicle = await bench.fly(1)
        capture = await vehicle.capture(bench.after(60.0))
        assert (capture.image_index, capture.image.shape[:2]) == (0, (IMAGE_SIZE_PX, IMAGE_SIZE_PX))
        assert capture.camera.horizontal_fov_rad == pytest.approx(bench.swarm.options.fov_rad, abs=1e-6)
        await vehicle.execute(Land(), bench.after(30.0))
        await bench.until(lambda: not vehicle.state.armed)
        assert bench.swarm.report().landed == 1
        assert [notice for notice in bench.notices if notice.severity is Severity.CRITICAL] == []
    assert (tmp_path / "mavlink.tlog").stat().st_size > 10_000


@pairs(("mavsdk", "arducopter"), ("mavsdk", "px4"), fake=False)
async def test_a_goto_that_is_not_confirmed_yet_is_superseded(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = await bench.fly(1)
        climbing = asyncio.create_task(vehicle.execute(Goto(bench.frame.to_geodetic((0, 0, 60)), 1e-3), bench.after(1)))
        await asyncio.sleep(0)
        await vehicle.execute(Hold(), bench.after(30.0))
        with pytest.raises(CommandRefusedError, match="superseded by Hold"):
            await climbing


@pairs(("mavsdk", "px4"), fake=False)
async def test_an_autopilot_keeps_to_its_fence_and_returns_at_its_return_height(
    implementation: str, autopilot: str
) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = bench.vehicle(1)
        await vehicle.upload_fence(fence_of(bench), bench.after(100.0))
        await vehicle.set_return_height(17.5, bench.after(100.0))
        facts = await vehicle.inspect(bench.after(100.0))
        assert facts.firmware == {"arducopter": "4.7.0 dev", "px4": "1.16.0"}[autopilot]
        await bench.fly(1)
        outside = vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 80.0, 10.0)), 5.0), bench.expiring(8.0))
        with pytest.raises(CommandRefusedError if autopilot == "arducopter" else CommandTimeoutError):
            await outside
        assert bench.motion(1).position_enu_m[1] < 5.0
        await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 30.0, 10.0)), 5.0), bench.after(30.0))
        await bench.until(lambda: bench.motion(1).position_enu_m[1] > 8.0)
        await vehicle.execute(ReturnToLaunch(), bench.after(30.0))
        highest_m = 0.0
        while vehicle.state.armed:
            highest_m = max(highest_m, bench.motion(1).position_enu_m[2])
            await bench.clock.sleep(0.5)
        assert highest_m == pytest.approx(17.5, abs=0.5)


@each_driver
async def test_a_camera_that_takes_images_for_somebody_else_serves_all_the_same(implementation: str) -> None:
    async with open_driver(implementation, "arducopter", vehicles=1) as bench:
        await bench.all_ready()
        camera = bench.swarm.vehicles[0].camera
        assert isinstance(camera, CameraComponent)
        first = await bench.vehicle(1).capture(bench.after(60.0))
        start = mavlink.MAVLink_command_long_message(1, 100, mavlink.MAV_CMD_IMAGE_START_CAPTURE, 0, 0, 3.0, *[0] * 5)
        camera.handle(start, bench.swarm.now)
        taken = [await bench.vehicle(1).capture(bench.after(60.0)) for _ in range(3)]
        async with bench.vehicle(1).interval(2.0, bench.after(30.0)) as images:
            taken.append(await images.next(bench.after(60.0)))
        indices = [capture.image_index - first.image_index for capture in taken]
        # In real time, a busy machine may let an image pass between two that are asked for.
        assert indices == (sorted({*indices} - {0}) if implementation == MAVSDK else [1, 2, 3, 4])
        await bench.until(lambda: not camera.takes_interval)
