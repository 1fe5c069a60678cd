"""Flights of split swarms on the fake fleet: some vehicles look closely while the others scan on along the leg."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from aos_gcs.mission.model.decisions import Group
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.planning.search_settings import LookOrder, SearchSettings
from aos_gcs.planning.settings import DetectionSettings, FlightSettings, PreflightSettings
from tests.fakes.mission_flight import EXACT, Flight, prepare

PERSON = (3.0, 40.0)
AREA = ((-15.0, 10.0), (15.0, 10.0), (15.0, 120.0), (-15.0, 120.0))
LONG_LOOK = DetectionSettings(threshold_m2=0.3, found_min_count=2, hold_steps=12)
CLOSE_LAYERS = FlightSettings(layer_spacing_m=2.0)
"""Layers from which all eight see the person large enough; there are no gusts."""
OVERRIDDEN = PreflightSettings(True, overrides=dict.fromkeys(("home altitude", "altitude accuracy"), "no gusts"))
SPLIT = SearchSettings(split=True, looks=LookOrder.FIRST)
"""Looks come as soon as something is in view."""
WAITS = "The vehicles that scan on stop and wait for the close look: "


def split_flight(
    n: int = 8, target: tuple[float, float] = PERSON, *, search: SearchSettings | None = None, **changes: object
) -> Flight:
    defaults = {"area_enu_m": AREA, "camera_delay_s": 0.6, "errors": EXACT, "detection": LONG_LOOK}
    changes = defaults | {"flight": CLOSE_LAYERS, "preflight": OVERRIDDEN} | changes
    return prepare(n, target, search=search or SPLIT, **changes)


def steps_of(flight: Flight, group: Group) -> list[StepRecord]:
    decisions = flight.recorder.decisions
    return [flight.recorder.steps[step] for step in sorted(decisions) if decisions[step].group is group]


def vehicles_of(flight: Flight, group: Group) -> set[int]:
    decisions = flight.recorder.decisions.values()
    return {place.vehicle_id for one in decisions if one.group is group for place in one.situation.swarm}


def reached_m(flight: Flight) -> float:
    return flight.mission.sortie.search.decider.progress.along_m


def is_scanned_on(flight: Flight) -> bool:
    return len(steps_of(flight, Group.SCAN)) >= 8


def waits(flight: Flight) -> list[str]:
    return [text.removeprefix(WAITS) for text in flight.texts() if text.startswith(WAITS)]


def is_catching_up(flight: Flight) -> bool:
    split = flight.mission.sortie.search.decider.split
    return split is not None and split.is_catching_up


def norths_m(flight: Flight, vehicle_ids: set[int]) -> list[float]:
    return [float(flight.fleet.members[number].position_enu_m()[1]) for number in sorted(vehicle_ids)]


async def stand_still(flight: Flight, vehicle_ids: Iterable[int], for_s: float) -> None:
    """Check that vehicles stay where they are, all in the same time."""
    members = {number: flight.fleet.members[number] for number in vehicle_ids}
    before_m = {number: vehicle.position_enu_m() for number, vehicle in members.items()}
    await flight.clock.sleep(for_s)
    for number, vehicle in members.items():
        assert vehicle.position_enu_m() == pytest.approx(before_m[number], abs=0.01), f"vehicle {number}"
