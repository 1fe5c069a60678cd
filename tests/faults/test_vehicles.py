"""Vehicles and cameras that fail in mid-mission, with simulated autopilots under the real driver, in virtual time."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import LateFrameError, TornFrameError
from aos_drivers.frames.files.fetching import Download, ImageFetcher
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines
from aos_sim.swarm import SimulatedSwarm
from tests.fakes.air import FIRST_PORT, GCS, Address, Air
from tests.fakes.air_flight import WarmSpot, flying_over

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]

FAILSAFE = {"FS_GCS_ENABLE": 1.0, "FS_GCS_TIMEOUT": 5.0, "RTL_ALT": 0.0}
"""Return at the height that a vehicle has when its link is lost, or 15 m at least as delivered."""
FREEZE_S = 7.0
"""Longer than the failsafe waits."""


def rewriting(change: Callable[[mavlink.MAVLink_message], bool]) -> Callable[[bytes, Address, Address], bytes | None]:
    """Return a middleman that hands each message of vehicle 2 to ``change`` and drops what it answers False to."""
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True

    def pass_on(data: bytes, sender: Address, receiver: Address) -> bytes | None:
        if FIRST_PORT + 1 not in (sender[1], receiver[1]):
            return data
        kept = b""
        for message in parser.parse_buffer(data) or []:
            if change(message):
                packer = mavlink.MAVLink(None, message.get_srcSystem(), message.get_srcComponent())
                packer.seq = message.get_seq()
                kept += message.pack(packer)
        return kept or None

    return pass_on


# --- one vehicle ----------------------------------------------------------------------------------------------------


async def test_who_ignores_commands_is_named_and_the_others_come_home(monkeypatch: pytest.MonkeyPatch) -> None:
    air = Air()
    hasty = Deadlines(preflight_s=120.0, transfer_s=40.0, move_s=15.0, land_s=90.0)
    async with flying_over(monkeypatch, air, deadlines=hasty) as flight:
        await flight.until_step(2)
        air.on_datagram = rewriting(lambda message: not message.get_type().startswith("COMMAND_"))
        await flight.run
        flight.assert_nobody_was_endangered()
        assert [flight.task(1), flight.task(3)] == [Task.LANDED, Task.LANDED]
        assert "has not reported that it landed: check it on site" in flight.texts()
        assert any(text.startswith("goto: ") for text in flight.texts())


@pytest.mark.parametrize("in_flight", [False, True])
async def test_a_stranger_with_a_vehicles_id_is_told_of_and_gets_no_command(
    monkeypatch: pytest.MonkeyPatch, in_flight: bool
) -> None:
    air = Air()
    async with flying_over(monkeypatch, air) as flight:
        if in_flight:
            await flight.until_step(1)
        options = replace(flight.swarm.options, vehicles=1, first_system_id=2, seed=99)
        async with SimulatedSwarm(options, WarmSpot()) as strangers:
            if in_flight:
                await flight.until(lambda: any("another sender" in text for text in flight.texts()))
                await flight.until_step(3)
                results = await flight.mission.commands.act(Action.RETURN, None)
                assert all(result.accepted for result in results)
            await flight.run
            if in_flight:
                assert flight.swarm.report().landed == 3
            assert not strangers.vehicle(2).autopilot.flight.armed
        # Told to fly nowhere; reads and streams do not move it.
        commands = [
            message
            for data in air.sent_to.get(3, [])
            for message in mavlink.MAVLink(None).parse_buffer(data) or []
            if message.get_type() == "COMMAND_INT" or getattr(message, "command", 0) in _MOVING
        ]
        assert commands == []
        assert flight.swarm.report().min_separation_m >= 1.5


_MOVING = frozenset(
    {
        mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
        mavlink.MAV_CMD_NAV_TAKEOFF,
        mavlink.MAV_CMD_DO_SET_MODE,
        mavlink.MAV_CMD_DO_REPOSITION,
    }
)


@pytest.mark.parametrize("jump_s", [3600.0, -3600.0])
async def test_a_clock_that_jumps_changes_nothing(monkeypatch: pytest.MonkeyPatch, jump_s: float) -> None:
    async with flying_over(monkeypatch, Air()) as flight:
        await flight.until_step(2)
        now = flight.swarm.now
        flight.swarm.now = replace(now, start_utc_us=now.start_utc_us + round(jump_s * 1e6))
        assert await flight.run is Outcome.FOUND
        assert flight.swarm.report().landed == 3
        flight.assert_nobody_was_endangered()


async def test_a_glitch_of_the_position_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    air = Air()
    async with flying_over(monkeypatch, air) as flight:
        await flight.until_step(2)
        until_s = flight.clock.now_s() + 4.0

        def shift(message: mavlink.MAVLink_message) -> bool:
            if message.get_type() == "GLOBAL_POSITION_INT" and flight.clock.now_s() < until_s:
                message.lat += round(30.0 / 6_371_000.0 * math.degrees(1.0) * 1e7)
            return True

        air.on_datagram = rewriting(shift)
        await flight.run
        assert flight.swarm.report().landed == 3
        flight.assert_nobody_was_endangered()


async def test_a_low_battery_is_led_home_between_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    async with flying_over(monkeypatch, Air()) as flight:
        await flight.until_step(2)
        battery = flight.swarm.vehicle(3).autopilot.battery
        battery.consumed_mah = 0.78 * battery.capacity_mah
        assert await flight.run is Outcome.FOUND
        flight.assert_nobody_was_endangered()
        assert any("returns on its own: battery at" in text for text in flight.texts())
        assert flight.swarm.report().landed == 3


# --- the ground station ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_vehicles_of_a_killed_service_come_home_by_their_own_failsafe(
    monkeypatch: pytest.MonkeyPatch, autopilot: str
) -> None:
    parameters = FAILSAFE if autopilot == "arducopter" else {"NAV_DLL_ACT": 2.0}
    air = Air()
    async with flying_over(monkeypatch, air, autopilot=autopilot, parameters=parameters) as flight:
        await flight.until_step(2)
        air.on_datagram = lambda data, sender, _receiver: None if sender == GCS else data
        await flight.until(lambda: flight.swarm.report().landed == 3)
        flight.assert_nobody_was_endangered()
        flight.run.cancel()


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_a_restarted_station_leads_the_vehicles_home_in_their_layers(
    monkeypatch: pytest.MonkeyPatch, autopilot: str
) -> None:
    async with flying_over(monkeypatch, Air(), autopilot=autopilot) as flight:
        await flight.until_step(2)
        layers_m = [vehicle.layer_height_m for vehicle in flight.mission.view.snapshot().vehicles]
        again = await flight.kill_and_restart()
        run = asyncio.create_task(again.run())
        await flight.until(lambda: again.phase is Phase.TAKEOFF)
        await flight.clock.sleep(5.0)
        assert [vehicle.task for vehicle in again.view.snapshot().vehicles] == [Task.HELD] * 3
        assert [vehicle.layer_height_m for vehicle in again.view.snapshot().vehicles] == layers_m
        await again.commands.act(Action.RETURN, None)
        await run
        assert flight.swarm.report().landed == 3
        flight.assert_nobody_was_endangered()


async def test_after_a_freeze_of_the_loop_the_mission_ends_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """A frozen service is a silent one for the vehicles; for the service all that came meanwhile arrives at once."""
    air = Air()
    async with flying_over(monkeypatch, air, parameters=FAILSAFE) as flight:
        await flight.until_step(2)
        waiting: list[tuple[bytes, Address, Address]] = []
        spoken: list[bytes] = []

        def receive_nothing(data: bytes, sender: Address, receiver: Address) -> bytes | None:
            if sender == GCS:
                spoken.append(data)
                return data
            waiting.append((data, sender, receiver))
            return None

        flight.station.freeze()
        air.on_datagram = receive_nothing
        steps = len(flight.mission.view.steps())
        await flight.clock.sleep(FREEZE_S)
        assert (spoken, len(flight.mission.view.steps())) == ([], steps), "the station stands still"
        flight.station.thaw()
        air.on_datagram = None
        for datagram in waiting:
            air.carry(*datagram)
        await flight.run
        flight.assert_nobody_was_endangered()
        assert flight.swarm.report().landed == 3
        assert any("left the swarm: its" in text for text in flight.texts())


async def test_a_vehicle_whose_link_is_lost_and_found_comes_home(monkeypatch: pytest.MonkeyPatch) -> None:
    air = Air()
    async with flying_over(monkeypatch, air, parameters=FAILSAFE) as flight:
        await flight.until_step(2)
        air.cut.add(0)
        await flight.until(lambda: flight.task(1) is Task.LOST)
        await flight.until(lambda: flight.mission.phase is Phase.LAND)
        air.cut.clear()
        await flight.run
        assert flight.swarm.report().landed == 3
        flight.assert_nobody_was_endangered()


# --- cameras --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "reason"),
    [("nothing", "in time"), ("late", "in time"), ("torn", "whole"), ("half", "")],
)
async def test_a_step_goes_on_without_the_frame_of_a_camera_that_fails(
    monkeypatch: pytest.MonkeyPatch, fault: str, reason: str
) -> None:
    async with flying_over(monkeypatch, Air()) as flight:
        deliver = ImageFetcher.download

        async def fail(fetcher: ImageFetcher, url: str, host: str, deadline_s: float) -> Download:
            whole = await deliver(fetcher, url, host, deadline_s)
            # A camera that fails before the launch is refused by preflight.
            if "/2/" not in url or flight.mission.view.snapshot().step == 0:
                return whole
            match fault:
                case "nothing":
                    await flight.clock.sleep(max(0.0, deadline_s - flight.clock.now_s()))
                    raise LateFrameError(f"{url} did not arrive in time")
                case "late":
                    await flight.clock.sleep(5.0)
                    return whole
                case "torn":
                    raise TornFrameError(f"{url} cannot be fetched whole")
            return Download(whole.data[: len(whole.data) // 2], None)

        monkeypatch.setattr(ImageFetcher, "download", fail)
        assert await flight.run is Outcome.FOUND
        flight.assert_nobody_was_endangered()
        missing = {vehicle_id for step in flight.mission.view.steps() for vehicle_id in step.missing}
        assert missing == (set() if fault == "late" else {2})
        for step in flight.mission.view.steps():
            assert all(reason in text for text in step.missing.values())
