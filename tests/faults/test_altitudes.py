"""Altitudes that err, with simulated autopilots under the real driver, in virtual time."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings, PreflightSettings
from aos_sim.errors.model import ErrorModel
from aos_sim.errors.position import PositionErrors
from tests.fakes.air import Air
from tests.fakes.air_flight import flying_over

pytestmark = [pytest.mark.looptime, pytest.mark.slow, pytest.mark.timeout(900)]

METRES = ErrorModel(
    position=PositionErrors(
        fix_type=mavlink.GPS_FIX_TYPE_3D_FIX,
        bias_m=(0.2, 2.0),
        drift_m=(0.1, 0.05),
        barometer_m=0.2,
        reported_m=(0.3, 2.0),
    )
)
"""Altitudes of satellites without corrections, each vehicle's wrong by a constant."""
OVERRIDDEN = PreflightSettings(
    overrides={
        "geofence": "nothing flies near it",
        "home altitude": "the meadow is level",
        "altitude accuracy": "a test of the datum",
    }
)


async def test_layers_of_two_metres_are_refused_where_altitudes_err_by_two(monkeypatch: pytest.MonkeyPatch) -> None:
    deadlines = Deadlines(preflight_s=20.0, capture_s=8.0)
    async with flying_over(monkeypatch, Air(), vehicles=6, errors=METRES, deadlines=deadlines) as flight:
        blocking: set[str] = set()
        while not flight.run.done():
            blocking |= {check.name for check in flight.mission.view.snapshot().preflight if check.blocks}
            await flight.clock.sleep(0.5)
    assert {"home altitude", "altitude accuracy"} <= blocking
    assert flight.run.result() is Outcome.FAILED
    assert not any(vehicle.autopilot.flight.armed for vehicle in flight.swarm.vehicles)


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_constant_errors_are_taken_out_on_the_ground(monkeypatch: pytest.MonkeyPatch, autopilot: str) -> None:
    air = Air()
    async with flying_over(
        monkeypatch, air, vehicles=6, autopilot=autopilot, errors=METRES, preflight=OVERRIDDEN
    ) as flight:
        await flight.run
        flight.assert_nobody_was_endangered()
    assert flight.run.result() in {Outcome.FOUND, Outcome.NOT_FOUND}


@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_a_height_that_runs_away_is_found_and_its_vehicle_leaves(
    monkeypatch: pytest.MonkeyPatch, autopilot: str
) -> None:
    options = {"flight": FlightSettings(layer_spacing_m=3.0), "autopilot": autopilot, "auto_return": False}
    async with flying_over(monkeypatch, Air(), vehicles=4, **options) as flight:
        await flight.until_step(1)
        flight.swarm.errors.climb_mps[1] = 0.05
        await flight.until(lambda: flight.task(2) is not Task.SWARM)
        assert flight.swarm.errors.estimate_enu_m[1, 2] < 1.5
        await flight.until(lambda: flight.task(2) is Task.LANDED)
        await flight.mission.commands.act(Action.RETURN, None)
        await flight.run
        flight.assert_nobody_was_endangered()
        assert any("wrong altitude: it flies" in text for text in flight.texts())
