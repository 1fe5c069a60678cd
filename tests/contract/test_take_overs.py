"""Pilots, other stations and failsafes: what the drivers do when a simulated vehicle no longer follows them."""

from __future__ import annotations

import asyncio
import math
import re

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import CommandRefusedError
from aos_gcs.ports import Arm, Command, Goto, Hold, Land, ReturnToLaunch, Vehicle
from aos_sim.vehicle.arducopter import CopterMode
from aos_sim.vehicle.px4_modes import Px4Mode
from tests.contract.vehicle_bench import DriverBench, open_driver, pairs

each_pair = pairs(("mavsdk", "px4"), fake=False)
PILOT_MODES = {"arducopter": (CopterMode.LOITER, CopterMode.POSHOLD), "px4": (Px4Mode.POSITION,)}
OUR_MODES = {"arducopter": CopterMode.GUIDED, "px4": Px4Mode.HOLD}
"""Modes in which vehicles fly to our waypoints."""
FOLLOWS_S = 8.0
"""Longer than any command waits before it is repeated."""


def select_mode(bench: DriverBench, mode: int) -> None:
    """Have a pilot, or another station, change the mode of vehicle 1."""
    bench.swarm.vehicle(1).autopilot.select_mode(mode)


def reposition(bench: DriverBench, place_enu_m: tuple[float, float, float]) -> None:
    """Have another station send vehicle 1 somewhere."""
    place = bench.frame.to_geodetic(place_enu_m)
    autopilot = bench.swarm.vehicle(1).autopilot
    message = mavlink.MAVLink_command_int_message(
        1,
        1,
        mavlink.MAV_FRAME_GLOBAL_INT,
        mavlink.MAV_CMD_DO_REPOSITION,
        0,
        0,
        -1.0,
        1.0,
        0.0,
        math.nan,
        round(place.latitude_deg * 1e7),
        round(place.longitude_deg * 1e7),
        place.altitude_amsl_m,
    )
    message._header = mavlink.MAVLink_header(message.get_msgId(), srcSystem=255, srcComponent=190)
    autopilot.handle(message, bench.swarm.kinematics(1), autopilot.now)


async def flown_by_us(bench: DriverBench) -> Vehicle:
    await bench.all_ready()
    vehicle = await bench.fly(1)
    await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 30.0, 10.0)), 5.0), bench.after(30.0))
    return vehicle


@each_pair
async def test_what_we_command_ourselves_is_no_take_over(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        for command in (
            Hold(),
            Goto(bench.frame.to_geodetic((0.0, 10.0, 12.0)), 5.0),
            Goto(bench.frame.to_geodetic((5.0, 10.0, 12.0)), 5.0),
            ReturnToLaunch(),
            Hold(),
            Land(),
        ):
            await vehicle.execute(command, bench.after(30.0))
            await bench.clock.sleep(5.0)
            assert vehicle.state.taken_over == ""
        await bench.until(lambda: not vehicle.state.armed, 240.0)
        assert vehicle.state.taken_over == ""


@each_pair
async def test_a_pilots_mode_is_a_take_over_and_nothing_is_repeated(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        for mode in PILOT_MODES[autopilot]:
            # A target that the vehicle refuses to show keeps the command waiting, and being sent again.
            far = bench.frame.to_geodetic((0.0, 900.0, 10.0))
            going = asyncio.ensure_future(vehicle.execute(Goto(far, 5.0), bench.after(60.0)))
            await bench.clock.sleep(0.5)
            select_mode(bench, mode)
            with pytest.raises(CommandRefusedError):
                await going
            await bench.until(lambda: bool(vehicle.state.taken_over))
            await bench.clock.sleep(FOLLOWS_S)
            assert bench.swarm.vehicle(1).autopilot.custom_mode() == mode
            with pytest.raises(CommandRefusedError, match="taken over: its mode changed to"):
                await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0), bench.after(30.0))
            assert vehicle.state.taken_over
            vehicle.reclaim()
            assert vehicle.state.taken_over == "", "at once, before the next packet"
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0), bench.after(30.0))
            assert vehicle.state.taken_over == ""


@each_pair
@pytest.mark.parametrize(("flown_by", "holds"), [(Goto, False), (ReturnToLaunch, False), (ReturnToLaunch, True)])
async def test_a_waypoint_does_not_overrule_a_pilot_whom_no_heartbeat_has_shown_yet(
    implementation: str, autopilot: str, flown_by: type[Command], holds: bool
) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        if flown_by is ReturnToLaunch:
            await vehicle.execute(ReturnToLaunch(), bench.after(30.0))
        await bench.clock.sleep(3.0)
        # Just after a heartbeat: one of before the change that is still on its way cannot be told from an answer.
        heard_at_s = vehicle.state.armed_at_s
        await bench.until(lambda: vehicle.state.armed_at_s != heard_at_s)
        mode = OUR_MODES[autopilot] if holds else PILOT_MODES[autopilot][0]
        select_mode(bench, mode)
        assert vehicle.state.taken_over == ""
        with pytest.raises(CommandRefusedError):
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0), bench.after(30.0))
        await bench.clock.sleep(FOLLOWS_S)
        assert bench.swarm.vehicle(1).autopilot.custom_mode() == mode
        assert vehicle.state.taken_over


@pairs(fake=False)
async def test_who_has_landed_a_vehicle_stays_known_until_its_motors_run_again(
    implementation: str, autopilot: str
) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        (mode, *_) = PILOT_MODES[autopilot]
        for chosen in (mode, bench.swarm.vehicle(1).autopilot.land_mode()):
            select_mode(bench, chosen)
            await bench.clock.sleep(5.0)
        await bench.until(lambda: not vehicle.state.armed, 240.0)
        assert (vehicle.state.taken_over, vehicle.state.has_pilot) == ("", True)
        await vehicle.execute(Arm(), bench.after(120.0))
        assert not vehicle.state.has_pilot


@each_pair
async def test_a_target_of_another_station_is_a_take_over(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        await bench.clock.sleep(3.0)
        reposition(bench, (20.0, 30.0, 10.0))
        await bench.until(lambda: bool(vehicle.state.taken_over))
        assert re.search("target of another station|command of station 255", vehicle.state.taken_over)
        with pytest.raises(CommandRefusedError, match="Resume it first"):
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0), bench.after(30.0))
        vehicle.reclaim()
        await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0), bench.after(30.0))


@each_pair
async def test_a_stop_by_another_station_is_a_take_over(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        if autopilot == "arducopter":
            select_mode(bench, CopterMode.BRAKE)
        else:
            reposition(bench, bench.motion(1).position_enu_m)
        await bench.until(lambda: bool(vehicle.state.taken_over))


@each_pair
async def test_in_a_failsafe_only_return_and_land_are_sent(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        battery = bench.swarm.vehicle(1).autopilot.battery
        battery.consumed_mah = 0.93 * battery.capacity_mah
        await bench.until(lambda: vehicle.state.failsafe == "critical")
        for command in (Goto(bench.frame.to_geodetic((0.0, 90.0, 10.0)), 5.0), Hold()):
            with pytest.raises(CommandRefusedError, match=r"failsafe \(critical\): only return and land"):
                await vehicle.execute(command, bench.after(30.0))
        await bench.until(lambda: vehicle.state.mode.value == "return")
        await vehicle.execute(Land(), bench.after(30.0))


@pairs(fake=False)
async def test_a_goto_that_waits_is_given_up_when_a_failsafe_begins(implementation: str, autopilot: str) -> None:
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        battery = bench.swarm.vehicle(1).autopilot.battery
        await bench.clock.sleep(3.0)
        outside = bench.frame.to_geodetic((0.0, 900.0, 10.0))
        going = asyncio.ensure_future(vehicle.execute(Goto(outside, 5.0), bench.after(60.0)))
        await bench.clock.sleep(1.0)  # between two repetitions
        battery.consumed_mah = 0.93 * battery.capacity_mah
        with pytest.raises(CommandRefusedError):
            await going
        await bench.until(lambda: vehicle.state.mode.value == "return")


@pairs(fake=False)
async def test_who_answers_another_station_is_taken_over_before_the_next_waypoint(
    implementation: str, autopilot: str
) -> None:
    """The next waypoint of a sweep came half a second after another station had stopped the vehicle."""
    async with open_driver(implementation, autopilot, vehicles=1) as bench:
        vehicle = await flown_by_us(bench)
        await bench.clock.sleep(3.0)
        reposition(bench, (20.0, 30.0, 10.0))
        await bench.clock.sleep(0.4)
        with pytest.raises(CommandRefusedError, match="Resume it first"):
            await vehicle.execute(Goto(bench.frame.to_geodetic((0.0, 5.0, 10.0)), 5.0), bench.after(30.0))
