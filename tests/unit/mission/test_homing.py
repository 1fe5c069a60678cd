"""Landing is over when the vehicles say so."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import LandedState, VehicleState
from tests.fakes.fleet import FakeVehicle
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.looptime


@dataclass
class LateReporter(FakeVehicle):
    """Says that it stands on the ground only a while after its motors have stopped."""

    delay_s: float = 2.0
    stopped_at_s: float | None = None

    @property
    def state(self) -> VehicleState:
        state = super().state
        if not self.commands or state.armed:
            return state
        if self.stopped_at_s is None:
            self.stopped_at_s = self.clock.now_s()
        late = self.clock.now_s() < self.stopped_at_s + self.delay_s
        return replace(state, landed=LandedState.LANDING) if late else state


def replace_last_vehicle(flight: Flight, delay_s: float) -> None:
    vehicle = flight.fleet.members[4]
    flight.fleet.members[4] = LateReporter(
        vehicle.vehicle_id, vehicle.clock, vehicle.home_enu_m, vehicle.target_enu_m, delay_s=delay_s
    )


async def test_a_late_report_of_the_ground_is_waited_for() -> None:
    flight = prepare()
    replace_last_vehicle(flight, delay_s=2.0)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert [vehicle.task for vehicle in flight.view.snapshot().vehicles] == [Task.LANDED] * 4
    assert flight.recorder.outcome is not None
    assert flight.recorder.outcome.summary["landed"] == 4


async def test_a_report_that_never_comes_is_told_and_ends_nothing_but_the_wait() -> None:
    flight = prepare()
    replace_last_vehicle(flight, delay_s=1e6)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert [vehicle.task for vehicle in flight.view.snapshot().vehicles] == [*[Task.LANDED] * 3, Task.LANDING]
    assert "has not reported that it landed: check it on site" in flight.texts()
    assert "3 of 4 vehicles landed" in flight.view.snapshot().message


async def test_vehicles_that_landed_elsewhere_are_named_with_their_distance() -> None:
    flight = prepare()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 3)
        await flight.commands.act(Action.LAND, (2,))
        await flight.commands.act(Action.RETURN, (1, 3, 4))
        await run
    away = [text for text in flight.texts() if text.endswith("m from its launch point")]
    assert len(away) == 1
    assert flight.view.snapshot().message.startswith("Mission over: 4 of 4 vehicles landed, vehicle 2 ")
