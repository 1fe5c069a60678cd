"""Conversions hand out the same objects again for what has not changed, and never old ones for what has."""

from __future__ import annotations

from dataclasses import dataclass, replace

from aos_gcs.api.convert.mission import MissionConverter, allowed_actions
from aos_gcs.api.convert.reuse import Reused, ReusedItems
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task, VehicleSnapshot
from aos_gcs.ports import LandedState, VehicleState
from tests.fakes.records import snapshot
from tests.fakes.scripted_ground import GROUND


@dataclass(frozen=True)
class Input:
    name: str


class Output:
    def __init__(self, value: Input) -> None:
        self.name = value.name


def test_an_equal_value_is_converted_once() -> None:
    convert = Reused(Output)
    first = convert(Input("a"))
    assert convert(Input("a")) is first
    assert convert(Input("b")).name == "b"
    assert convert(Input("a")).name == "a"


def test_only_changed_items_are_converted_again() -> None:
    convert = ReusedItems(Output)
    first = convert((Input("a"), Input("b"), Input("c")))
    second = convert((Input("a"), Input("x"), Input("c")))
    assert second[0] is first[0]
    assert second[1].name == "x"
    assert second[2] is first[2]


def test_lists_grow_shrink_and_come_back() -> None:
    convert = ReusedItems(Output)
    for names in ("", "ab", "abc", "b", "", "cab"):
        assert [one.name for one in convert(tuple(map(Input, names)))] == list(names)


def allowed(vehicle: VehicleSnapshot) -> list[Action]:
    return allowed_actions(replace(snapshot(), phase=Phase.SCAN, vehicles=(vehicle,)))


def test_joining_is_offered_when_a_vehicle_could_be_accepted() -> None:
    place = GeodeticPosition(48.0, 14.0, 300.0)
    state = VehicleState(5, landed=LandedState.ON_GROUND, ready_to_arm=True, home=place)
    ready = VehicleSnapshot(state, Task.IDLE, None, None, 0.2, None, None)
    assert Action.JOIN in allowed(ready)
    for changes in ({"home": None}, {"ready_to_arm": False}, {"landed": LandedState.IN_AIR}):
        assert Action.JOIN not in allowed(replace(ready, telemetry=replace(state, **changes)))
    assert Action.JOIN not in allowed(replace(ready, link_age_s=10.0))
    assert Action.JOIN not in allowed(replace(ready, task=Task.SWARM))


def test_segments_have_their_figures_in_per_cent() -> None:
    ground = MissionConverter(None).convert(replace(snapshot(), ground=GROUND)).ground
    assert ground is not None
    assert ground.success_percent == 41.0
    segment, unknown = ground.segments
    assert segment.model_dump() == {
        "name": "A 1",
        "hectares": 1.2,
        "seen_percent": 70.0,
        "detection_percent": 55.0,
        "probability_percent": 60.0,
        "success_percent": 33.0,
    }
    assert [unknown.detection_percent, unknown.probability_percent, unknown.success_percent] == [None] * 3


def test_places_that_are_left_for_later_are_told_with_their_probability() -> None:
    origin = GeodeticPosition(48.0, 14.0, 300.0)
    left = replace(snapshot(), left_for_later=(LeftPlace((4.0, 20.0), 0.12345),))
    (place,) = MissionConverter(origin).convert(left).left_for_later
    assert (place.position.east_m, place.position.north_m, place.person_confidence) == (4.0, 20.0, 0.123)
    assert place.position.latitude_deg is not None
    assert place.position.latitude_deg > origin.latitude_deg
