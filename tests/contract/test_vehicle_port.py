"""Behaviour that the Vehicle port promises: of the drivers, with simulated vehicles, and of the tests' own vehicles."""

from __future__ import annotations

import asyncio
import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from aos_gcs.errors import CaptureError, CommandRefusedError, CommandTimeoutError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.ports import (
    Arm,
    Disarm,
    FlightMode,
    Goto,
    Hold,
    Land,
    LandedState,
    ReturnToLaunch,
    Takeoff,
)
from tests.contract.vehicle_bench import each_implementation, fence_of, open_bench, pairs

SILENCE_S = 6.0
"""Longer than a vehicle may be silent and still be sent anything."""
TIME_RESOLUTION_S = 0.1


@pairs()
async def test_three_vehicles_fly_take_images_and_come_home(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot) as bench:
        await bench.all_ready()
        vehicles = await asyncio.gather(*[bench.fly(number, 10.0 + number) for number in (1, 2, 3)])
        for number, vehicle in enumerate(vehicles, 1):
            assert vehicle.state.armed
            assert bench.motion(number).position_enu_m[2] == pytest.approx(10.0 + number, abs=1.2)

        targets = [bench.frame.to_geodetic((12.0 * number, 15.0, 10.0 + number)) for number in (1, 2, 3)]
        await asyncio.gather(
            *[
                vehicle.execute(Goto(target, 5.0), bench.after(30.0))
                for vehicle, target in zip(vehicles, targets, strict=True)
            ]
        )
        await bench.until(
            lambda: all(
                math.dist(bench.motion(number).position_enu_m, (12.0 * number, 15.0, 10.0 + number)) < 1.0
                for number in (1, 2, 3)
            )
        )

        captures = await asyncio.gather(*[vehicle.capture(bench.after(60.0)) for vehicle in vehicles])
        for number, capture in enumerate(captures, 1):
            assert capture.vehicle_id == number
            assert capture.image.shape == (capture.camera.height_px, capture.camera.width_px, 4)
            assert capture.bands == ("red", "green", "blue", "thermal")
            assert -50 < float(np.median(capture.image[..., 3])) < 60
            place_enu_m = bench.frame.to_enu(capture.position)
            assert math.dist(place_enu_m, (12.0 * number, 15.0, 10.0 + number)) < 1.5
            assert capture.R_cam2enu[:, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-6)
        assert (await vehicles[0].capture(bench.after(60.0))).image_index == captures[0].image_index + 1

        await vehicles[0].execute(Hold(), bench.after(30.0))
        assert vehicles[0].state.mode is FlightMode.HOLD
        await vehicles[0].execute(Land(), bench.after(30.0))
        await asyncio.gather(*[vehicle.execute(ReturnToLaunch(), bench.after(30.0)) for vehicle in vehicles[1:]])
        assert [vehicle.state.mode for vehicle in vehicles] == [FlightMode.LAND, FlightMode.RETURN, FlightMode.RETURN]
        await bench.until(lambda: not any(vehicle.state.armed for vehicle in vehicles), 240.0)
        await bench.until(lambda: all(vehicle.state.landed is LandedState.ON_GROUND for vehicle in vehicles))


@pairs(("mavsdk", "arducopter"))
async def test_a_camera_takes_images_by_itself_until_it_is_stopped(implementation: str, autopilot: str) -> None:
    period_s = 2.0
    async with open_bench(implementation, autopilot, vehicles=2) as bench:
        await bench.all_ready()
        vehicle, other = bench.vehicle(1), bench.vehicle(2)
        single = await vehicle.capture(bench.after(60.0))
        async with vehicle.interval(period_s, bench.after(30.0)) as images:
            taken = [await images.next(bench.after(60.0)) for _ in range(5)]
            with pytest.raises(CaptureError, match="already taking"):
                await vehicle.capture(bench.after(5.0))
        assert len({capture.image_index for capture in taken}) == len(taken)
        assert min(capture.image_index for capture in taken) > single.image_index
        times_utc_s = sorted(capture.utc_s for capture in taken)
        assert min(later - sooner for sooner, later in pairwise(times_utc_s)) > 0.9 * period_s
        assert {capture.vehicle_id for capture in taken} == {1}
        assert all(capture.image.shape[2] == len(capture.bands) for capture in taken)

        last = await vehicle.capture(bench.after(60.0))
        await bench.clock.sleep(3.0 * period_s)
        following = await vehicle.capture(bench.after(60.0))
        assert following.image_index == last.image_index + 1, "it was stopped"
        alone = await other.capture(bench.after(60.0))
        assert alone.image_index in {0, 1}, "it was started alone"


@pairs(("mavsdk", "px4"))
async def test_hold_stops_a_vehicle_on_its_way(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = await bench.fly(1)
        await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 150.0, 10.0)), 8.0), bench.after(30.0))
        await bench.until(lambda: bench.motion(1).velocity_enu_mps[1] > 6.0)
        await vehicle.execute(Hold(), bench.after(30.0))
        await bench.until(lambda: math.hypot(*bench.motion(1).velocity_enu_mps) < 0.2)
        stopped_at_m = bench.motion(1).position_enu_m
        await bench.clock.sleep(5.0)
        assert math.dist(bench.motion(1).position_enu_m, stopped_at_m) < 1.0
        assert stopped_at_m[1] < 100.0


@pairs()
async def test_a_goto_turns_the_vehicle_to_its_heading(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = await bench.fly(1)
        for heading_rad in (math.pi, 0.0):
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0, heading_rad), bench.after(30.0))
            await bench.until(lambda wanted=heading_rad: _off_rad(vehicle.state.heading_rad, wanted) < 0.1)
        with pytest.raises(CommandRefusedError, match="heading"):
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0, math.nan), bench.after(5.0))


def _off_rad(heading_rad: float | None, wanted_rad: float) -> float:
    return math.inf if heading_rad is None else abs(math.remainder(heading_rad - wanted_rad, math.tau))


@each_implementation
async def test_a_command_reaches_its_vehicle_and_no_other(implementation: str) -> None:
    async with open_bench(implementation) as bench:
        await bench.all_ready()
        await bench.fly(2)
        heights_m = [bench.motion(number).position_enu_m[2] for number in (1, 2, 3)]
        assert heights_m == pytest.approx([0.0, 10.0, 0.0], abs=1.2)
        assert [bench.vehicle(number).state.armed for number in (1, 2, 3)] == [False, True, False]


@pairs(("mavsdk", "arducopter"), ("mavsdk", "px4"))
async def test_what_must_not_be_done_is_refused_in_words(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        grounded = bench.vehicle(1)
        home = grounded.state.home
        assert home is not None
        with pytest.raises(CommandRefusedError, match="take off first"):
            await grounded.execute(Goto(home, 5.0), bench.after(5.0))
        flying = await bench.fly(1)
        with pytest.raises(CommandRefusedError, match="land it"):
            await flying.execute(Disarm(), bench.after(5.0))
        with pytest.raises(CommandRefusedError, match="not finite"):
            await flying.execute(Goto(GeodeticPosition(48.3, 14.3, math.nan), 5.0), bench.after(5.0))


@pairs()
async def test_a_climb_can_be_held_and_continued(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = bench.vehicle(1)
        await vehicle.execute(Arm(), bench.after(60.0))
        climbing = asyncio.create_task(vehicle.execute(Takeoff(30.0), bench.after(180.0)))
        await bench.until(lambda: bench.motion(1).position_enu_m[2] > 10.0)
        await vehicle.execute(Hold(), bench.after(30.0))
        with pytest.raises(CommandRefusedError, match="superseded by Hold"):
            await climbing
        await bench.until(lambda: math.hypot(*bench.motion(1).velocity_enu_mps) < 0.2)
        held_enu_m = bench.motion(1).position_enu_m
        assert 9.0 < held_enu_m[2] < 25.0
        await bench.clock.sleep(5.0)
        assert math.dist(bench.motion(1).position_enu_m, held_enu_m) < 1.0
        await vehicle.execute(Goto(bench.frame.to_geodetic((*held_enu_m[:2], 30.0)), 5.0), bench.after(30.0))
        await bench.until(lambda: math.dist(bench.motion(1).position_enu_m, (*held_enu_m[:2], 30.0)) < 1.0)


@pairs()
async def test_a_hold_before_the_lift_off_is_safe_and_can_be_repeated(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot, vehicles=1) as bench:
        await bench.all_ready()
        vehicle = bench.vehicle(1)
        await vehicle.execute(Arm(), bench.after(60.0))
        climbing = asyncio.create_task(vehicle.execute(Takeoff(20.0), bench.after(180.0)))
        await asyncio.sleep(0)
        await vehicle.execute(Hold(), bench.after(30.0))
        with pytest.raises(CommandRefusedError, match="superseded by Hold"):
            await climbing
        assert bench.motion(1).position_enu_m[2] < 8.0
        assert abs(bench.motion(1).velocity_enu_mps[2]) < 1.0
        await bench.clock.sleep(2.0)
        if vehicle.state.landed is LandedState.ON_GROUND:
            await vehicle.execute(Takeoff(20.0), bench.after(180.0))
        else:
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 0.0, 20.0)), 5.0), bench.after(30.0))
        await bench.until(lambda: bench.motion(1).position_enu_m[2] > 19.0)


@pairs(("mavsdk", "px4"))
async def test_a_fence_is_uploaded_read_back_and_kept(implementation: str, autopilot: str) -> None:
    async with open_bench(implementation, autopilot, vehicles=2) as bench:
        await bench.all_ready()
        vehicle, other = bench.vehicle(1), bench.vehicle(2)
        facts = await vehicle.inspect(bench.after(100.0))
        assert facts.fence is None
        assert facts.firmware
        assert len(facts.board_id) > 4
        assert vehicle.state.board_id == facts.board_id
        assert facts.link_loss.is_on
        assert facts.link_loss.text.startswith("return after")
        assert facts.low_battery.is_on
        assert facts.return_height_m == 30.0

        fence = fence_of(bench)
        await vehicle.upload_fence(fence, bench.after(100.0))
        facts, others = await asyncio.gather(*[one.inspect(bench.after(100.0)) for one in (vehicle, other)])
        assert facts.fence is not None
        assert facts.fence.is_same_as(fence)
        assert facts.at_fence.is_on
        assert others.fence is None, "a fence is for one vehicle"
        assert others.board_id != facts.board_id

        with pytest.raises(CommandRefusedError, match=r"refuses a geofence of 153 points: no space"):
            await vehicle.upload_fence(fence_of(bench, corners=150), bench.after(100.0))
        assert (await vehicle.inspect(bench.after(100.0))).fence == facts.fence


@pairs(("mavsdk", "px4"))
async def test_a_return_height_is_set_on_the_ground_kept_in_the_air_and_set_back(
    implementation: str, autopilot: str
) -> None:
    async with open_bench(implementation, autopilot, vehicles=2) as bench:
        await bench.all_ready()
        vehicle, other = bench.vehicle(1), bench.vehicle(2)
        before = await vehicle.inspect(bench.after(100.0))
        await vehicle.set_return_height(17.5, bench.after(100.0))
        facts, others = await asyncio.gather(*[one.inspect(bench.after(100.0)) for one in (vehicle, other)])
        assert facts.return_height_m == 17.5
        assert others.return_height_m == before.return_height_m, "a height is for one vehicle"

        for height_m in (0.0, math.nan):
            with pytest.raises(CommandRefusedError, match="is impossible"):
                await vehicle.set_return_height(height_m, bench.after(100.0))
        with pytest.raises(CommandRefusedError, match="FENCE_ENABLE is not a return setting of vehicle"):
            await vehicle.restore_return({"FENCE_ENABLE": 0.0}, bench.after(100.0))

        await bench.fly(1)
        with pytest.raises(CommandRefusedError, match="vehicle 1 is armed: its return settings"):
            await vehicle.set_return_height(25.0, bench.after(100.0))
        with pytest.raises(CommandRefusedError, match="vehicle 1 is armed: its return settings"):
            await vehicle.restore_return(before.return_settings, bench.after(100.0))
        await vehicle.execute(Land(), bench.after(30.0))
        await bench.until(lambda: not vehicle.state.armed)
        await vehicle.restore_return(before.return_settings, bench.after(100.0))
        assert (await vehicle.inspect(bench.after(100.0))).return_height_m == before.return_height_m


@each_implementation
async def test_a_vehicle_that_does_not_answer_is_waited_for_until_the_deadline(implementation: str) -> None:
    async with open_bench(implementation, vehicles=1) as bench, bench.unanswering() as mute:
        for command in (Arm(), Hold(), ReturnToLaunch(), Land()):
            deadline_s = bench.expiring(0.5)
            with pytest.raises(CommandTimeoutError, match="check link and vehicle"):
                await mute.vehicle.execute(command, deadline_s)
            assert bench.clock.now_s() >= deadline_s - TIME_RESOLUTION_S
        fence = fence_of(bench)
        for call in (
            mute.vehicle.inspect,
            partial(mute.vehicle.upload_fence, fence),
            partial(mute.vehicle.set_return_height, 25.0),
        ):
            deadline_s = bench.expiring(2.0)
            with pytest.raises(CommandTimeoutError, match="check link and vehicle"):
                await call(deadline_s)
            assert bench.clock.now_s() >= deadline_s - TIME_RESOLUTION_S
        with pytest.raises(CaptureError):
            await mute.vehicle.capture(bench.expiring(2.0))
        with pytest.raises(CaptureError):
            async with mute.vehicle.interval(1.0, bench.expiring(2.0)):
                pass


@each_implementation
async def test_only_hold_return_and_land_are_sent_to_a_vehicle_that_has_fallen_silent(implementation: str) -> None:
    async with open_bench(implementation, vehicles=1) as bench, bench.unanswering() as mute:
        mute.fall_silent()
        heard_at_s = mute.vehicle.state.heard_at_s
        assert heard_at_s is not None
        await bench.until(lambda: bench.clock.now_s() > heard_at_s + SILENCE_S)
        for command in (Arm(), Takeoff(10.0), Goto(bench.frame.to_geodetic((0.0, 10.0, 10.0)), 5.0)):
            with pytest.raises(CommandRefusedError, match="has been silent for"):
                await mute.vehicle.execute(command, bench.after(30.0))
        for command in (Hold(), ReturnToLaunch(), Land()):
            with pytest.raises(CommandTimeoutError):
                await mute.vehicle.execute(command, bench.expiring(0.5))
        assert mute.vehicle.state.heard_at_s == heard_at_s
