"""Plans that operators apply to a mission before it starts."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import PlanRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.phases import PHASE_NAMES
from aos_gcs.planning.plan import plan_of
from tests.fakes.mission_flight import Flight, flying, prepare, settings

pytestmark = pytest.mark.virtual

AREA_ENU_M = settings(2).area_enu_m


async def until_phase(flight: Flight, phase: Phase) -> None:
    await flight.until(lambda: flight.mission.phase is phase)


async def test_a_mission_without_area_waits_for_a_plan_and_flies_it() -> None:
    flight = prepare(2, area_enu_m=(), auto_start=False)
    async with flying(flight) as run:
        await until_phase(flight, Phase.PREFLIGHT)
        await asyncio.sleep(30.0)
        assert "there is no search area" in flight.view.snapshot().message

        plan = replace(plan_of(flight.commands.settings), area_enu_m=AREA_ENU_M, lowest_layer_m=30.0, spacing_m=4.5)
        await flight.commands.apply_plan(plan, operator="Ada")
        await until_phase(flight, Phase.READY)
        snapshot = flight.view.snapshot()
        assert snapshot.area_enu_m == AREA_ENU_M
        assert [vehicle.layer_height_m for vehicle in snapshot.vehicles] == [30.0, 32.5]

        await flight.commands.act(Action.START, None)
        with pytest.raises(MissionError, match="has started"):
            await flight.commands.apply_plan(plan)
        await flight.commands.act(Action.ABORT, None)
        await run
    (record,) = [event.data for event in flight.recorder.events if isinstance(event.data, PlanRecord)]
    assert record == PlanRecord(plan, "Ada")


async def test_a_ready_mission_starts_anew_with_another_plan() -> None:
    flight = prepare(2, auto_start=False)
    async with flying(flight):
        await until_phase(flight, Phase.READY)
        await flight.commands.apply_plan(replace(plan_of(flight.commands.settings), strategy="aos-pso"))
        assert flight.view.snapshot().strategy == "aos-pso"
        await flight.until(lambda: flight.texts().count(PHASE_NAMES[Phase.READY]) == 2)
        assert PHASE_NAMES[Phase.CONNECT] in flight.texts()
        await flight.commands.act(Action.ABORT, None)


async def test_nobody_starts_out_of_a_no_go_zone() -> None:
    about_one = ((-5.0, -3.0), (0.0, -3.0), (0.0, 3.0), (-5.0, 3.0))
    flight = prepare(2, auto_start=False)
    async with flying(flight):
        await until_phase(flight, Phase.READY)
        plan = plan_of(flight.commands.settings)
        await flight.commands.apply_plan(replace(plan, no_go_enu_m=(about_one,)))
        await flight.until(lambda: "inside of no-go zone 1" in flight.view.snapshot().message)
        await flight.commands.apply_plan(plan)
        await until_phase(flight, Phase.READY)
        await flight.commands.act(Action.ABORT, None)


async def test_a_plan_that_cannot_be_flown_changes_nothing() -> None:
    flight = prepare(2, auto_start=False)
    async with flying(flight):
        await until_phase(flight, Phase.READY)
        before = flight.commands.settings
        with pytest.raises(MissionError, match="too close"):
            await flight.commands.apply_plan(replace(plan_of(before), layer_spacing_m=0.5))
        assert flight.commands.settings is before
        assert flight.mission.phase is Phase.READY
        await flight.commands.act(Action.ABORT, None)
