"""Safety of waypoints: each reason by example."""

from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.errors import ConfigurationError
from tests.fakes.waypoints import request

SQUARE = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))
NOTCHED = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (0.0, -10.0), (-50.0, 50.0))
LIMITS = SafetyLimits(fence_enu_m=SQUARE, floor_m=20.0, ceiling_m=60.0, margin_m=5.0, separation_m=2.0)


def vet_one(vehicle: WaypointRequest, *obstacles: Obstacle, limits: SafetyLimits = LIMITS) -> WaypointRecord:
    (record,) = vet_waypoints([vehicle], obstacles, limits)
    return record


def test_an_admissible_waypoint_is_sent_as_it_is() -> None:
    record = vet_one(request(4, (0.0, 0.0, 35.0), (3.0, 4.0, 35.5)))
    assert record == WaypointRecord(4, (3.0, 4.0, 35.5), (3.0, 4.0, 35.5), WaypointVerdict.SENT, "")


def test_fences_may_be_lists_and_arrays() -> None:
    vertices_m = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]]
    for fence_enu_m in (vertices_m, np.array(vertices_m)):
        (fence,) = replace(LIMITS, fence_enu_m=fence_enu_m).boundaries()
        np.testing.assert_array_equal(fence.vertices_m, vertices_m)


def test_limits_that_differ_in_a_margin_have_boundaries_of_their_own_and_nobody_changes_them() -> None:
    zoned = replace(LIMITS, no_go_enu_m=(((10.0, 0.0), (20.0, 0.0), (20.0, 9.0)),))
    fence, zone = zoned.boundaries()
    assert (fence.margin_m, zone.margin_m, zone.name) == (5.0, 5.0, "no-go zone 1")
    assert [one.margin_m for one in replace(zoned, no_go_margin_m=2.5).boundaries()] == [5.0, 2.5]
    assert [one.margin_m for one in replace(zoned, margin_m=3.0).boundaries()] == [3.0, 3.0]
    for boundary in (fence, zone):
        with pytest.raises(ValueError, match="read-only"):
            boundary.vertices_m[0] = 0.0


def test_staying_in_place_is_always_admissible() -> None:
    record = vet_one(request(1, (0.0, 0.0, 35.0), (0.0, 0.0, 35.0)), Obstacle(2, np.array([0.5, 0.0, 35.0])))
    assert record.verdict is WaypointVerdict.SENT


@pytest.mark.parametrize("battery_fraction", [0.1, 0.8], ids=["held", "sent elsewhere"])
def test_a_vehicle_under_way_occupies_the_rest_of_its_path_until_it_is_sent_elsewhere(battery_fraction: float) -> None:
    under_way = replace(
        request(1, (0.0, 0.0, 35.0), (-20.0, 0.0, 35.0), battery_fraction=battery_fraction),
        waypoint_enu_m=np.array([20.0, 0.0, 35.0]),
    )
    crossing = request(2, (15.0, -15.0, 35.0), (15.0, 15.0, 35.0))
    first, second = vet_waypoints([under_way, crossing], [], LIMITS)
    if battery_fraction < LIMITS.min_battery_fraction:
        assert first.verdict is WaypointVerdict.HELD
        assert second.verdict is WaypointVerdict.SHORTENED
        assert second.sent_enu_m == pytest.approx((15.0, -2.0, 35.0), abs=1e-5)
    else:
        assert [first.verdict, second.verdict] == [WaypointVerdict.SENT] * 2


def test_a_vehicle_that_is_vetted_later_occupies_the_rest_of_its_path_too() -> None:
    crossing = request(1, (15.0, -15.0, 35.0), (15.0, 15.0, 35.0))
    under_way = replace(
        request(2, (0.0, 0.0, 35.0), (20.0, 0.0, 35.0), link_age_s=9.0), waypoint_enu_m=np.array([20.0, 0.0, 35.0])
    )
    first, second = vet_waypoints([crossing, under_way], [], LIMITS)
    assert [first.verdict, second.verdict] == [WaypointVerdict.SHORTENED, WaypointVerdict.HELD]
    assert "it would pass vehicle 2" in first.reason


def test_the_braking_distance_is_occupied_whatever_a_vehicle_is_told() -> None:
    braking = replace(request(1, (0.0, 0.0, 35.0), (-20.0, 0.0, 35.0)), stop_enu_m=np.array([20.0, 0.0, 35.0]))
    crossing = request(2, (15.0, -15.0, 35.0), (15.0, 15.0, 35.0))
    assert vet_waypoints([braking, crossing], [], LIMITS)[1].verdict is WaypointVerdict.SHORTENED
    held = Obstacle(1, np.array([0.0, 0.0, 35.0]), stop_enu_m=np.array([20.0, 0.0, 35.0]))
    assert vet_one(crossing, held).verdict is WaypointVerdict.SHORTENED


def test_the_fence_shortens_with_its_margin() -> None:
    record = vet_one(request(1, (40.0, 0.0, 35.0), (60.0, 0.0, 35.0)))
    assert record.verdict is WaypointVerdict.SHORTENED
    assert record.sent_enu_m == pytest.approx((45.0, 0.0, 35.0), abs=1e-5)
    assert record.reason == "shortened to 5.0 of 20.0 m: the geofence, with a margin of 5.0 m"


def test_a_segment_across_a_notch_of_the_fence_stops_before_it() -> None:
    limits = SafetyLimits(fence_enu_m=NOTCHED, floor_m=20.0, ceiling_m=60.0)
    record = vet_one(request(1, (-40.0, 10.0, 35.0), (40.0, 10.0, 35.0)), limits=limits)
    assert record.verdict is WaypointVerdict.SHORTENED
    assert record.sent_enu_m is not None
    # The notch's left side runs from (-50, 50) to (0, -10): at north 10 it is at east -50/3.
    assert record.sent_enu_m[0] == pytest.approx(-50.0 / 3.0, abs=1e-4)


def test_within_the_margin_only_segments_inwards_are_sent() -> None:
    start = (48.0, 0.0, 35.0)
    assert vet_one(request(1, start, (40.0, 0.0, 35.0))).verdict is WaypointVerdict.SENT
    assert vet_one(request(1, start, (49.0, 0.0, 35.0))).verdict is WaypointVerdict.HELD


def test_outside_the_fence_only_a_straight_segment_back_is_sent() -> None:
    start = (55.0, 0.0, 35.0)
    assert vet_one(request(1, start, (40.0, 0.0, 35.0))).verdict is WaypointVerdict.SENT
    record = vet_one(request(1, start, (53.0, 0.0, 35.0)))
    assert (record.verdict, record.sent_enu_m) == (WaypointVerdict.HELD, None)
    assert "outside the geofence" in record.reason


ZONED = replace(LIMITS, no_go_enu_m=(((10.0, -10.0), (20.0, -10.0), (20.0, 10.0), (10.0, 10.0)),))


def test_no_target_lies_in_a_no_go_zone_and_no_segment_crosses_it() -> None:
    for end in ((15.0, 0.0, 35.0), (30.0, 0.0, 35.0)):
        record = vet_one(request(1, (0.0, 0.0, 35.0), end), limits=ZONED)
        assert record.verdict is WaypointVerdict.SHORTENED
        assert record.sent_enu_m == pytest.approx((5.0, 0.0, 35.0), abs=1e-5)
        assert record.reason.endswith("no-go zone 1, with a margin of 5.0 m")
    assert vet_one(request(1, (0.0, 20.0, 35.0), (30.0, 20.0, 35.0)), limits=ZONED).verdict is WaypointVerdict.SENT


def test_inside_a_no_go_zone_only_a_straight_segment_out_is_sent() -> None:
    start = (15.0, 0.0, 35.0)
    assert vet_one(request(1, start, (30.0, 0.0, 35.0)), limits=ZONED).verdict is WaypointVerdict.SENT
    record = vet_one(request(1, start, (16.0, 0.0, 35.0)), limits=ZONED)
    assert record.reason == "held: it is inside no-go zone 1 and would not fly straight out of it"


def test_floor_and_ceiling_clip_the_segment() -> None:
    low = vet_one(request(1, (0.0, 0.0, 30.0), (20.0, 0.0, 10.0)))
    assert low.sent_enu_m == pytest.approx((10.0, 0.0, 20.0), abs=1e-5)
    assert "floor at 20.0 m" in low.reason
    high = vet_one(request(1, (0.0, 0.0, 50.0), (0.0, 0.0, 70.0)))
    assert high.sent_enu_m == pytest.approx((0.0, 0.0, 60.0), abs=1e-5)
    assert "ceiling at 60.0 m" in high.reason


def test_below_the_floor_only_climbing_is_sent() -> None:
    assert vet_one(request(1, (0.0, 0.0, 10.0), (0.0, 0.0, 15.0))).verdict is WaypointVerdict.SENT
    assert vet_one(request(1, (0.0, 0.0, 10.0), (0.0, 0.0, 9.0))).verdict is WaypointVerdict.HELD


@pytest.mark.parametrize(
    ("vehicle", "reason"),
    [
        (request(1, (0, 0, 35), (5, 0, 35), link_age_s=3.1), "held: no message for 3.1 s, limit 3.0 s"),
        (request(1, (0, 0, 35), (5, 0, 35), link_age_s=None), "held: it has never been heard"),
        (request(1, (0, 0, 35), (5, 0, 35), position_age_s=4.0), "held: no position for 4.0 s, limit 3.0 s"),
        (request(1, (0, 0, 35), (5, 0, 35), position_age_s=None), "held: it has never reported a position"),
        (request(1, (0, 0, 35), (5, 0, 35), battery_fraction=0.19), "held: battery at 19%, limit 20%"),
        (request(1, (0, 0, 35), (np.nan, 0, 35)), "held: the requested position is not finite"),
    ],
)
def test_who_must_not_move_is_held(vehicle: WaypointRequest, reason: str) -> None:
    record = vet_one(vehicle)
    assert (record.verdict, record.sent_enu_m, record.reason) == (WaypointVerdict.HELD, None, reason)


def test_a_vehicle_that_flies_home_is_not_kept_up_by_its_battery() -> None:
    assert (
        vet_one(request(1, (0.0, 0.0, 35.0), (5.0, 0.0, 35.0), battery_fraction=None)).verdict is WaypointVerdict.SENT
    )


def test_the_energy_to_fly_there_and_home_must_be_left() -> None:
    limits = SafetyLimits(fence_enu_m=SQUARE, floor_m=20.0, ceiling_m=60.0, battery_per_m=0.01)
    home = (-40.0, 0.0, 35.0)
    segment = ((0.0, 0.0, 35.0), (5.0, 0.0, 35.0))
    # 5 m there and 45 m home cost 0.5, and 0.2 must be left.
    assert (
        vet_one(request(1, *segment, battery_fraction=0.71, home=home), limits=limits).verdict is WaypointVerdict.SENT
    )
    record = vet_one(request(1, *segment, battery_fraction=0.69, home=home), limits=limits)
    assert record.reason == "held: battery at 69%, but 70% are needed to go there and return home"
    assert "home is unknown" in vet_one(request(1, *segment), limits=limits).reason


def test_a_hovering_vehicle_on_the_segment_shortens_it() -> None:
    record = vet_one(request(1, (0.0, 0.0, 35.0), (10.0, 0.0, 35.0)), Obstacle(7, np.array([10.0, 0.0, 36.0])))
    assert record.verdict is WaypointVerdict.SHORTENED
    assert record.sent_enu_m == pytest.approx((10.0 - np.sqrt(3.0), 0.0, 35.0), abs=1e-5)
    assert record.reason == "shortened to 8.3 of 10.0 m: it would pass vehicle 7 at 1.0 m, limit 2.0 m"


def test_a_vertical_layer_between_is_enough() -> None:
    record = vet_one(request(1, (0.0, 0.0, 35.0), (10.0, 0.0, 35.0)), Obstacle(7, np.array([5.0, 0.0, 37.0])))
    assert record.verdict is WaypointVerdict.SENT


@pytest.mark.parametrize(("height_m", "top_m", "free"), [(60.0, None, False), (10.0, None, True), (10.0, 50.0, False)])
def test_a_landing_or_climbing_vehicle_takes_its_column(height_m: float, top_m: float | None, free: bool) -> None:
    obstacle = Obstacle(7, np.array([5.0, 0.0, height_m]), column=True, top_m=top_m)
    record = vet_one(request(1, (0.0, 0.0, 35.0), (10.0, 0.0, 35.0)), obstacle)
    assert (record.verdict is WaypointVerdict.SENT) == free
    if not free:
        assert record.sent_enu_m == pytest.approx((3.0, 0.0, 35.0), abs=1e-5)


@pytest.mark.parametrize(
    ("end", "free"),
    [((0.0, 20.0, 35.0), True), ((20.0, 0.0, 35.0), False), ((20.0, 20.0, 35.0), True), ((20.0, 20.0, 39.0), False)],
)
def test_a_vehicle_that_returns_on_its_own_occupies_its_path_and_the_column_at_its_end(
    end: tuple[float, float, float], free: bool
) -> None:
    obstacle = Obstacle(7, np.array([10.0, 30.0, 39.0]), column=True, home_enu_m=np.array([10.0, 0.0, 0.0]))
    record = vet_one(request(1, (0.0, 0.0, 35.0), end), obstacle)
    assert (record.verdict is WaypointVerdict.SENT) == free


def test_of_two_crossing_segments_the_later_id_yields() -> None:
    first, second = vet_waypoints(
        [request(1, (0.0, -10.0, 35.0), (0.0, 10.0, 35.0)), request(2, (-10.0, 0.0, 35.0), (10.0, 0.0, 35.0))],
        [],
        LIMITS,
    )
    assert first.verdict is WaypointVerdict.SENT
    assert second.sent_enu_m == pytest.approx((-2.0, 0.0, 35.0), abs=1e-5)


def test_an_earlier_segment_keeps_off_where_a_later_vehicle_may_be_held() -> None:
    first, second = vet_waypoints(
        [
            request(1, (0.0, 0.0, 35.0), (8.0, 0.0, 35.0)),
            request(2, (5.0, 0.0, 35.0), (13.0, 0.0, 35.0), link_age_s=9.0),
        ],
        [],
        LIMITS,
    )
    assert first.sent_enu_m == pytest.approx((3.0, 0.0, 35.0), abs=1e-5)
    assert second.verdict is WaypointVerdict.HELD


def test_vehicles_that_are_too_close_may_only_part() -> None:
    parting = vet_waypoints(
        [request(1, (0.0, 0.0, 35.0), (-4.0, 0.0, 35.0)), request(2, (1.0, 0.0, 35.0), (5.0, 0.0, 35.0))], [], LIMITS
    )
    assert [record.verdict for record in parting] == [WaypointVerdict.SENT, WaypointVerdict.SENT]
    closing = vet_waypoints(
        [request(1, (0.0, 0.0, 35.0), (0.5, 0.0, 35.0)), request(2, (1.0, 0.0, 35.0), (-4.0, 0.0, 35.0))], [], LIMITS
    )
    assert [record.verdict for record in closing] == [WaypointVerdict.HELD, WaypointVerdict.HELD]
    for way_m in (5.0, 9.0):
        together = vet_waypoints(
            [request(1, (0.0, 0.0, 35.0), (0.0, 5.0, 35.0)), request(2, (1.0, 0.0, 35.0), (1.0, way_m, 35.0))],
            [],
            LIMITS,
        )
        assert [record.verdict for record in together] == [WaypointVerdict.SENT, WaypointVerdict.HELD]


def test_a_segment_too_short_for_a_length_is_none() -> None:
    segment = request(1, (0.0, 0.0, 35.0), (0.0, 1e-200, 35.0))
    assert vet_one(segment, Obstacle(2, np.array([1.0, 0.0, 35.0]))).verdict is WaypointVerdict.SENT


def test_ids_must_differ_and_positions_be_known() -> None:
    vehicle = request(1, (0.0, 0.0, 35.0), (1.0, 0.0, 35.0))
    with pytest.raises(ValueError, match="once"):
        vet_waypoints([vehicle], [Obstacle(1, np.zeros(3))], LIMITS)
    with pytest.raises(ValueError, match="finite"):
        vet_waypoints([vehicle], [Obstacle(2, np.full(3, np.nan))], LIMITS)
    assert vet_waypoints([], [], LIMITS) == ()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"fence_enu_m": SQUARE[:2]}, "fence_enu_m"),
        ({"fence_enu_m": (SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3])}, "fence_enu_m must not cross"),
        ({"floor_m": 60.0}, "floor_m .* must be below ceiling_m"),
        ({"margin_m": -1.0}, "margin_m"),
        ({"separation_m": 0.0}, "separation_m"),
        ({"hold_vertical_m": 1.2}, "hold_vertical_m .* must lie within separation_m"),
        ({"max_link_age_s": float("nan")}, "max_link_age_s"),
        ({"min_battery_fraction": 1.0}, "min_battery_fraction"),
        ({"battery_per_m": 0.0}, "battery_per_m"),
        ({"no_go_enu_m": (SQUARE, SQUARE[:2])}, r"no_go_enu_m\[1\] must have three or more points"),
    ],
)
def test_limits_that_make_no_sense_are_refused(change: dict[str, object], text: str) -> None:
    values: dict[str, object] = {"fence_enu_m": SQUARE, "floor_m": 20.0, "ceiling_m": 60.0}
    with pytest.raises(ConfigurationError, match=text):
        SafetyLimits(**{**values, **change})  # type: ignore[arg-type]
