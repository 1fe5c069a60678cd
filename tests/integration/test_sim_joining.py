"""Vehicles that are switched on in mid-mission, with simulated autopilots under the real driver, in virtual time."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import PreflightSettings
from tests.fakes.air import Air
from tests.fakes.air_flight import flying_over

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]

PREFLIGHT = PreflightSettings(set_return_height=True, overrides={"geofence": "nothing flies near it"})
JOINS, MUST_NOT = 4, 5


async def test_a_replacement_joins_and_one_that_must_not_stays_on_the_ground(monkeypatch: pytest.MonkeyPatch) -> None:
    air = Air()
    async with flying_over(monkeypatch, air, late_vehicles=2, preflight=PREFLIGHT) as flight:
        await flight.until_step(1)
        await flight.mission.commands.act(Action.PAUSE, None)
        empty = flight.swarm.vehicle(MUST_NOT).autopilot.battery
        empty.consumed_mah = 0.7 * empty.capacity_mah
        air.cut.clear()
        await flight.until(lambda: flight.can_be_asked(JOINS) and flight.can_be_asked(MUST_NOT))
        joined, refused = await flight.mission.commands.act(Action.JOIN, (JOINS, MUST_NOT))
        assert (joined.accepted, joined.text) == (True, "takes off and flies to the swarm")
        assert not refused.accepted
        assert "battery" in refused.text
        await flight.until(lambda: flight.task(JOINS) is Task.SWARM)
        layers_m = {v.telemetry.vehicle_id: v.layer_height_m for v in flight.mission.view.snapshot().vehicles}
        assert layers_m[JOINS] == max(layers_m[number] or 0.0 for number in (1, 2, 3)) + 2.5
        assert flight.swarm.vehicle(JOINS).autopilot.parameters["RTL_ALT"] == pytest.approx(
            100.0 * layers_m[JOINS], abs=1
        )
        await flight.mission.commands.act(Action.RESUME, None)
        assert await flight.run is Outcome.FOUND
        assert JOINS in flight.mission.view.steps()[-1].fitness
        assert {flight.task(number) for number in (1, 2, 3, JOINS)} == {Task.LANDED}
        assert flight.task(MUST_NOT) is Task.IDLE
        assert flight.swarm.kinematics(MUST_NOT).position_enu_m[2] == pytest.approx(0.0, abs=0.1)
        flight.assert_nobody_was_endangered()
