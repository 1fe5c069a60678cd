"""Turns in flight beside the boundaries: where vehicles fly on while they brake."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED, SafetyLimits
from aos_gcs.airspace.stopping import DECELERATION_MPS2
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from tests.fakes.waypoints import request

HEIGHT_M = 25.0
MARGIN_M = 3.0
Place = tuple[float, float]


def limits(zone: tuple[Place, ...], margin_m: float = MARGIN_M) -> SafetyLimits:
    square = ((-50.0, -50.0), (50.0, -50.0), (50.0, 90.0), (-50.0, 90.0))
    return replace(
        UNLIMITED,
        fence_enu_m=square,
        floor_m=8.0,
        ceiling_m=40.0,
        no_go_enu_m=(zone,),
        margin_m=margin_m,
        no_go_margin_m=margin_m,
    )


ZONE = ((-3.0, 56.0), (4.0, 56.0), (4.0, 59.0), (-3.0, 59.0))
LIMITS = limits(ZONE)


def vet(
    start_m: Place,
    velocity_mps: Place,
    end_m: Place,
    asked: SafetyLimits = LIMITS,
    former_end_m: Place | None = None,
) -> WaypointRecord:
    """Return what becomes of the waypoint of a vehicle that flies at a velocity, to a former waypoint."""
    start, velocity = np.array([*start_m, HEIGHT_M]), np.array([*velocity_mps, 0.0])
    stop = start + np.linalg.norm(velocity) / (2.0 * DECELERATION_MPS2) * velocity
    vehicle = request(1, (*start_m, HEIGHT_M), (*end_m, HEIGHT_M))
    vehicle = replace(
        vehicle,
        stop_enu_m=stop if velocity.any() else None,
        waypoint_enu_m=None if former_end_m is None else np.array([*former_end_m, HEIGHT_M]),
    )
    (record,) = vet_waypoints([vehicle], [], asked)
    return record


AHEAD_OF_ITS_STOP = ((9.1, 43.0), (-0.6, 10.0), (4.2, 53.0), ((-3.1, 56.0), (4.4, 56.0), (4.4, 58.7), (-3.1, 58.7)))
BEHIND_A_CORNER = ((10.1, 41.0), (0.2, 8.8), (6.3, 43.4), ((1.3, 46.4), (6.9, 46.4), (6.9, 50.7), (1.3, 50.7)))


@pytest.mark.parametrize(("start_m", "velocity_mps", "end_m", "zone"), [AHEAD_OF_ITS_STOP, BEHIND_A_CORNER])
def test_a_turn_past_a_zone_waits_until_the_vehicle_is_slow_enough(
    start_m: Place, velocity_mps: Place, end_m: Place, zone: tuple[Place, ...]
) -> None:
    """Both were flown 2.7 and 1.3 m into the margin by the campaign, seeds 910259 and 910313."""
    asked = limits(zone)
    record = vet(start_m, velocity_mps, end_m, asked)
    assert (record.verdict, record.sent_enu_m) == (WaypointVerdict.HELD, None)
    assert record.reason == "held: it is too fast to turn there clear of no-go zone 1"
    assert record.is_unfit, "nothing bars its path: ground ahead is not left out for it"
    assert vet(start_m, (0.0, 0.0), end_m, asked).verdict is WaypointVerdict.SENT


def test_turns_beside_nothing_are_not_delayed() -> None:
    for end_m in ((9.0, -40.0), (-40.0, 0.0), (20.0, 20.0)):
        assert vet((9.0, 0.0), (0.0, 10.0), end_m).verdict is WaypointVerdict.SENT


def test_straight_flight_along_a_margin_goes_on_whatever_its_velocity_wavers() -> None:
    beside_m = 4.0 + MARGIN_M
    for drift_mps in (-0.2, 0.0, 0.2):
        assert vet((beside_m, 40.0), (drift_mps, 9.0), (beside_m, 80.0)).verdict is WaypointVerdict.SENT
    assert vet((beside_m, 40.0), (0.0, 9.0), (beside_m, 80.0)).verdict is WaypointVerdict.SENT


def test_a_vehicle_that_cannot_keep_the_margin_any_more_may_turn_away() -> None:
    towards_m, velocity_mps = (0.5, 48.0), (0.0, 8.0)
    assert vet(towards_m, velocity_mps, (0.5, 20.0)).verdict is WaypointVerdict.SENT
    assert vet(towards_m, velocity_mps, (30.0, 40.0)).verdict is WaypointVerdict.SENT


def test_a_vehicle_that_brakes_in_front_of_a_zone_is_not_sent_to_a_nearer_place_beside_its_line() -> None:
    """Flown 0.9 m into the margin by the campaign, seed 911151: it braked in the turn for less than straight on."""
    asked = limits(((-5.7, 65.2), (-1.0, 65.2), (-1.0, 70.0), (-5.7, 70.0)), margin_m=2.5)
    start_m, velocity_mps, former_end_m = (0.46, 55.4), (-1.14, 6.48), (-0.82, 62.7)
    record = vet(start_m, velocity_mps, (-2.1, 61.79), asked, former_end_m)
    assert record.reason == "flies on to its former waypoint: it is too fast to turn there clear of no-go zone 1"
    assert record.sent_enu_m == pytest.approx((*former_end_m, HEIGHT_M), abs=0.05)
    assert record.is_unfit
    far = vet(start_m, velocity_mps, (-2.1, 61.79), asked, former_end_m=(8.0, 75.0))
    assert far.verdict is WaypointVerdict.HELD, "it would fly on for long"
    assert vet(start_m, velocity_mps, former_end_m, asked, former_end_m).verdict is WaypointVerdict.SENT, "no turn"
    assert vet(start_m, (-0.3, 1.5), (-2.1, 61.79), asked, former_end_m).verdict is WaypointVerdict.SENT, "slow"


def test_a_zone_within_the_turn_is_met_also_where_no_side_of_the_turn_comes_near() -> None:
    small = limits(((20.0, 20.0), (21.0, 20.0), (21.0, 21.0), (20.0, 21.0)), margin_m=1.0)
    record = vet((0.0, 0.0), (0.0, 14.0), (45.0, 5.0), small)
    assert record.verdict is WaypointVerdict.HELD


def test_the_inside_of_a_geofence_counts_as_the_outside_of_a_zone() -> None:
    notched = replace(
        LIMITS,
        no_go_enu_m=(),
        fence_enu_m=((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (12.0, 50.0), (10.0, 20.0), (8.0, 50.0)),
    )
    assert vet((30.0, 8.0), (-10.0, 0.0), (16.0, 24.0), notched).reason.endswith("turn there clear of the geofence")


def test_without_a_margin_a_turn_keeps_out_of_the_zone_itself() -> None:
    bare = limits(ZONE, margin_m=0.0)
    assert vet((8.0, 50.0), (-1.0, 8.0), (7.0, 53.0), bare).verdict is WaypointVerdict.SENT
    assert vet((8.0, 50.0), (-1.0, 8.0), (0.0, 54.0), bare).verdict is WaypointVerdict.HELD
