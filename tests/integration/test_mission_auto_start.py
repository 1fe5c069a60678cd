"""Automatic start, in virtual time: what cancels it, since people walk up to vehicles that have landed."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.config.file import parse_config
from aos_gcs.config.model import ServiceConfig
from aos_gcs.errors import MissionError
from aos_gcs.mission.command_order import OutdatedError
from aos_gcs.mission.model.actions import Action, Seen
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase
from aos_gcs.runtime.service import open_service
from aos_gcs.store.last_mission import unfinished_mission
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.program import unused_port


def hovering() -> Flight:
    """A mission with automatic start that finds its vehicles in the air."""
    flight = prepare(3)
    for index, vehicle in enumerate(flight.fleet.members.values()):
        vehicle.armed = True
        vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.home_enu_m + np.array([0.0, 30.0, 30.0 + 3.0 * index])
    return flight


async def stays_ready(flight: Flight) -> None:
    await flight.until(lambda: flight.mission.phase is Phase.READY)
    await flight.clock.sleep(60.0)
    assert flight.mission.phase is Phase.READY


@pytest.mark.virtual
@pytest.mark.parametrize("lander", ["operator", "somebody else"])
async def test_vehicles_that_were_found_in_the_air_are_not_launched_again_once_they_have_landed(lander: str) -> None:
    flight = hovering()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.snapshot().preflight) > 0)
        if lander == "operator":
            await flight.commands.act(Action.LAND, None, operator="Ada")
        else:
            for vehicle in flight.fleet.members.values():
                vehicle.start_enu_m = vehicle.goal_enu_m = vehicle.home_enu_m
                vehicle.armed = False
        await stays_ready(flight)
        assert sum("Automatic start cancelled" in text for text in flight.texts()) == 1
        await flight.commands.act(Action.START, None)
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.virtual
async def test_any_action_before_the_start_leaves_that_to_the_operator() -> None:
    flight = prepare(3)
    async with flying(flight) as run:
        with pytest.raises(MissionError, match="No vehicle is known to fly"):
            await flight.commands.act(Action.HOLD, None, operator="Ada")
        await stays_ready(flight)
        assert "Automatic start cancelled: Ada has acted. Launch by hand" in flight.texts()
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.virtual
async def test_an_action_by_outdated_data_leaves_the_automatic_start_on() -> None:
    flight = prepare(3)
    async with flying(flight) as run:
        snapshot = flight.view.snapshot()
        seen = Seen(snapshot.mission_id, snapshot.command_count, asyncio.get_running_loop().time() - 10.0)
        for command in (
            flight.commands.act(Action.ABORT, None, operator="Ada", seen=seen),
            flight.commands.override_check(1, "gps", "an open sky", operator="Ada", seen=seen),
        ):
            with pytest.raises(OutdatedError):
                await command
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        assert not any("Automatic start" in text for text in flight.texts())
        await flight.commands.act(Action.ABORT, None)
        await run


@pytest.mark.virtual
async def test_an_action_in_flight_says_nothing_of_the_start() -> None:
    flight = prepare(2)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert not any("Automatic start" in text for text in flight.texts())


def configuration(folder: Path, **mission: object) -> ServiceConfig:
    tables = {
        "link": {"urls": [f"udpin://127.0.0.1:{unused_port()}"]},
        "mission": {"area_enu_m": [[0, 0], [9, 0], [9, 9]], "auto_start": True, **mission},
        "api": {"enabled": False},
        "record": {"folder": folder},
    }
    return parse_config(tables, source="test")


@pytest.mark.parametrize(
    ("ends", "mission", "is_on"),
    [
        (True, {"vehicle_ids": [1, 2]}, True),
        (False, {"vehicle_ids": [1, 2]}, False),
        (False, {"vehicles": 2, "any_vehicles": True}, True),
    ],
    ids=["ended", "killed", "killed simulation"],
)
@pytest.mark.usefixtures("threaded_workers")
async def test_a_last_mission_that_was_killed_leaves_the_start_to_an_operator(
    tmp_path: Path, ends: bool, mission: dict[str, object], is_on: bool
) -> None:
    for name in ("1-ended", "2-last"):
        async with MissionRecorder.create(tmp_path, name, {}, notify=lambda _: None) as recorder:
            if ends or name == "1-ended":
                await recorder.record_outcome(OutcomeRecord(0.0, Outcome.FOUND, {}))
    assert unfinished_mission(tmp_path) == (None if ends else "2-last")
    async with open_service(configuration(tmp_path, **mission)) as service:
        assert service.mission.auto_start.is_on is is_on


def test_without_a_mission_and_with_one_that_cannot_be_read(tmp_path: Path) -> None:
    assert unfinished_mission(tmp_path / "missing") is None
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "mission.sqlite").write_bytes(b"no database")
    assert unfinished_mission(tmp_path) == "damaged"
