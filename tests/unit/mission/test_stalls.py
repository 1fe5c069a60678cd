"""Scans that count as stuck, and where their line goes on."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.airspace.detours import Detours
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.polygon import Boundary
from aos_gcs.airspace.traffic import WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.scan.progress import Advance, ScanProgress, time_on_legs_s
from aos_gcs.mission.search.scan.stalls import STALLED_STEPS, StallWatch, place_ahead_m
from aos_gcs.planning.legs import ScanLeg
from tests.fakes.records import step_record

LEAST_GAIN_M = 0.5
SPACING_M = 4.0
NORTHWARD = ScanLeg((0.0, 0.0), (0.0, 1.0), 40.0)
FENCE = Boundary(
    np.array([[-50.0, -50.0], [50.0, -50.0], [50.0, 90.0], [-50.0, 90.0]]), "the geofence", keeps_in=True, margin_m=1.0
)


def zone(*vertices_m: tuple[float, float]) -> Boundary:
    return Boundary(np.array(vertices_m), "a zone", keeps_in=False, margin_m=1.0)


def ahead_m(*zones: Boundary, vehicles: int = 4, leg: ScanLeg = NORTHWARD) -> float | None:
    detours = Detours([FENCE, *zones], 0.5)

    def is_free(places_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        return detours.reached(np.array(leg.start_enu_m), places_m)

    return place_ahead_m(leg, vehicles, SPACING_M, is_free)


def test_standing_still_counts_as_stuck_only_while_something_bars_the_way() -> None:
    watch = StallWatch(LEAST_GAIN_M)
    assert not any(watch.is_stuck(3.0, barred=False) for _ in range(2 * STALLED_STEPS))
    stuck = [watch.is_stuck(3.0, barred=True) for _ in range(STALLED_STEPS)]
    assert stuck == [False] * (STALLED_STEPS - 1) + [True]


@pytest.mark.parametrize("gain_m", [LEAST_GAIN_M, 2.0])
def test_ground_gained_while_barred_is_progress(gain_m: float) -> None:
    watch = StallWatch(LEAST_GAIN_M)
    assert not any(watch.is_stuck(step * gain_m, barred=True) for step in range(5 * STALLED_STEPS))


def test_hovering_to_and_fro_is_no_progress() -> None:
    watch = StallWatch(LEAST_GAIN_M)
    assert any(watch.is_stuck(0.2 * (-1) ** step, barred=True) for step in range(STALLED_STEPS + 1))


def test_a_line_that_was_formed_anew_starts_from_where_it_stands() -> None:
    watch = StallWatch(LEAST_GAIN_M)
    assert any(watch.is_stuck(20.0, barred=True) for _ in range(STALLED_STEPS + 1))
    watch.restart()
    assert not any(watch.is_stuck(5.0 + 2.0 * step, barred=True) for step in range(STALLED_STEPS))


def test_the_line_goes_on_at_the_first_place_where_all_of_it_is_free() -> None:
    across = zone((-20.0, 2.0), (20.0, 2.0), (20.0, 14.0), (-20.0, 14.0))
    assert ahead_m(across) == pytest.approx(16.0)
    before_one = zone((5.0, 2.0), (7.0, 2.0), (7.0, 22.0), (5.0, 22.0))
    assert ahead_m(before_one) == pytest.approx(24.0)


def test_where_the_whole_line_never_fits_most_of_it_goes_on() -> None:
    before_one_to_the_end = zone((5.0, 2.0), (20.0, 2.0), (20.0, 60.0), (5.0, 60.0))
    across_first = zone((-20.0, 2.0), (5.0, 2.0), (5.0, 10.0), (-20.0, 10.0))
    assert ahead_m(before_one_to_the_end) == pytest.approx(SPACING_M)
    assert ahead_m(before_one_to_the_end, across_first) == pytest.approx(12.0)


def test_there_is_no_place_in_a_zone_behind_which_the_leg_ends() -> None:
    to_the_end = zone((-20.0, 2.0), (20.0, 2.0), (20.0, 60.0), (-20.0, 60.0))
    assert ahead_m(to_the_end) is None


def test_a_place_without_a_way_to_it_is_none() -> None:
    from_fence_to_fence = zone((-60.0, 2.0), (60.0, 2.0), (60.0, 10.0), (-60.0, 10.0))
    assert ahead_m(from_fence_to_fence) is None


def test_a_single_vehicle_is_no_line() -> None:
    all_but_one = zone((-4.0, 2.0), (20.0, 2.0), (20.0, 60.0), (-4.0, 60.0))
    assert ahead_m(all_but_one) is None


def test_the_last_spacing_of_a_leg_has_no_place_ahead() -> None:
    assert ahead_m(leg=NORTHWARD.after(37.0)) is None
    assert ahead_m(leg=NORTHWARD.after(50.0)) is None


def test_vehicles_that_are_held_for_their_own_state_do_not_bar_a_scan() -> None:
    progress = ScanProgress(LEAST_GAIN_M)
    progress.plan([NORTHWARD])
    here_m = np.array([0.0, 10.0])
    old_link = WaypointRecord(1, (0.0, 12.0, 35.0), None, WaypointVerdict.HELD, "held: no message for 3.1 s", True)
    for _ in range(3 * STALLED_STEPS):
        progress.note_waypoints([old_link])
        assert progress.advance(here_m) is Advance.ON_LEG
    wall = replace(old_link, reason="held: no-go zone 1", is_unfit=False)
    found = []
    for _ in range(STALLED_STEPS + 1):
        progress.note_waypoints([old_link, wall])
        found.append(progress.advance(here_m))
    assert found[-1] is Advance.STUCK


def test_close_looks_do_not_count_as_time_on_the_legs() -> None:
    phases = [Phase.SCAN, Phase.SCAN, Phase.CONVERGE, Phase.FOUND, Phase.SCAN]
    times_s = [2.0, 5.0, 60.0, 90.0, 96.0]
    steps = [
        replace(step_record(index), phase=phase, elapsed_s=time_s)
        for index, (phase, time_s) in enumerate(zip(phases, times_s, strict=True), start=1)
    ]
    assert time_on_legs_s(steps) == 3.0 + 6.0
    assert time_on_legs_s(steps[:1]) == time_on_legs_s([]) == 0.0


def test_the_time_left_on_the_legs_goes_by_the_pace_of_this_mission() -> None:
    progress = ScanProgress(LEAST_GAIN_M)
    assert progress.time_left_s(10.0) is None
    length_m = NORTHWARD.length_m
    legs = [NORTHWARD] * 4
    progress.plan(legs)
    progress.advance(np.array([0.0, 2.0]))
    assert progress.time_left_s(5.0) is None, "the pace is not known yet"
    progress.advance(np.array([0.0, length_m / 2.0]))
    assert progress.time_left_s(60.0) == pytest.approx(60.0 * 3.5 / 0.5)
    progress.begin_next_leg()
    assert progress.time_left_s(100.0) == pytest.approx(100.0 * 3.0 / 1.0)
    taken_up = ScanProgress(LEAST_GAIN_M)
    taken_up.take_up(legs, 2)
    taken_up.advance(np.array([0.0, length_m / 2.0]))
    assert taken_up.time_left_s(60.0) == pytest.approx(60.0 * 1.5 / 0.5)
    for _ in range(2):
        taken_up.begin_next_leg()
    assert taken_up.time_left_s(300.0) == 0.0


def test_vetting_tells_an_unfit_vehicle_from_a_barred_path() -> None:
    limits = SafetyLimits(
        fence_enu_m=((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)), floor_m=20.0, ceiling_m=60.0
    )
    request = WaypointRequest(
        vehicle_id=1,
        position_enu_m=np.array([0.0, 0.0, 35.0]),
        requested_enu_m=np.array([80.0, 0.0, 35.0]),
        link_age_s=0.1,
        position_age_s=0.1,
        battery_fraction=0.9,
    )
    (barred,) = vet_waypoints([request], [], limits)
    (unfit,) = vet_waypoints([replace(request, link_age_s=4.0)], [], limits)
    assert (barred.is_barred, unfit.is_barred) == (True, False)
