"""Fronts, speeds and laggards of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.plans import TrafficSituation
from aos_gcs.airspace.stopping import StoppingDistance
from aos_gcs.airspace.traffic import WaypointRequest
from aos_gcs.airspace.waypoints import WaypointRecord, WaypointVerdict, as_enu_point
from aos_gcs.mission.model.decisions import Situation, SwarmPlace
from aos_gcs.mission.search.scan.progress import Advance, ScanProgress
from aos_gcs.mission.search.scan.sweep import HORIZON_M, LEFT_BEHIND_M, STUCK_S, Sweep, Vet
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.settings import FlightSettings
from aos_gcs.ports import Severity

LEG = ScanLeg((0.0, 10.0), (0.0, 1.0), 400.0)
EAST_M = (-4.2, 0.0, 4.2)
FULL_MPS = 5.0
BRAKING_M = StoppingDistance(FULL_MPS).total_m


@dataclass
class Heard:
    """Journal that keeps its notices."""

    notices: list[tuple[int | None, str]] = field(default_factory=list)

    def elapsed_s(self) -> float:
        return 0.0

    def notice(self, severity: Severity, text: str, vehicle_id: int | None = None) -> None:
        assert severity is Severity.WARNING
        self.notices.append((vehicle_id, text))


def make_sweep(journal: Heard | None = None, **flight: float) -> Sweep:
    return Sweep(FlightSettings(**flight), 2.0, 4.2, journal or Heard())


def situation(along_m: Sequence[float], now_s: float = 0.0) -> Situation:
    """Vehicles 1, 2, … from west to east, so far along the leg."""
    positions = [np.array([east_m, 10.0 + north_m, 35.0]) for east_m, north_m in zip(EAST_M, along_m, strict=False)]
    requests = [
        WaypointRequest(
            vehicle_id=number,
            position_enu_m=position,
            requested_enu_m=position,
            link_age_s=0.0,
            position_age_s=0.0,
            battery_fraction=None,
        )
        for number, position in enumerate(positions, start=1)
    ]
    swarm = tuple(SwarmPlace(one.vehicle_id, as_enu_point(one.position_enu_m), 35.0) for one in requests)
    return Situation(now_s, swarm, TrafficSituation(limits=UNLIMITED, arrival_radius_m=0.5, movable=tuple(requests)))


def vetting(barred_from_m: Callable[[], float] = lambda: np.inf) -> Vet:
    """Admit every place up to some distance along the leg."""

    def vet(places_enu_m: NDArray[np.float64]) -> tuple[WaypointRecord, ...]:
        records = []
        for number, (east_m, north_m) in enumerate(places_enu_m, start=1):
            place = (float(east_m), float(north_m), 35.0)
            is_free = north_m - 10.0 <= barred_from_m()
            verdict = WaypointVerdict.SENT if is_free else WaypointVerdict.SHORTENED
            records.append(WaypointRecord(number, place, place, verdict, "" if is_free else "a zone"))
        return tuple(records)

    return vet


def front_m(waypoints: Sequence[WaypointRecord]) -> float:
    (north_m,) = {one.sent_enu_m[1] for one in waypoints if one.sent_enu_m is not None}
    return north_m - 10.0


def speeds_mps(waypoints: Sequence[WaypointRecord]) -> list[float | None]:
    return [one.speed_mps for one in waypoints]


def test_the_front_moves_on_before_anybody_brakes_for_it_and_ends_with_the_leg() -> None:
    sweep, fronts = make_sweep(), []
    for along_m in np.arange(0.0, LEG.length_m, 2.5).tolist():
        waypoints = sweep.fly_on(LEG, along_m, situation([along_m] * 3, along_m / FULL_MPS), vetting())
        fronts.append(front_m(waypoints))
        assert HORIZON_M >= fronts[-1] - along_m > 0.0
        assert fronts[-1] - along_m > BRAKING_M or fronts[-1] == LEG.length_m + 0.5
        assert speeds_mps(waypoints) == [FULL_MPS] * 3
    assert fronts[-1] == LEG.length_m + 0.5
    # Each front is a command to every vehicle.
    assert len(set(fronts)) < 15


def test_each_vehicle_keeps_its_place_in_the_line() -> None:
    waypoints = make_sweep().fly_on(LEG, 0.0, situation([0.0] * 3), vetting())
    assert [one.sent_enu_m[0] for one in waypoints if one.sent_enu_m] == pytest.approx(EAST_M)


def test_the_search_speed_is_never_above_the_cruise_speed() -> None:
    waypoints = make_sweep(cruise_speed_mps=3.0).fly_on(LEG, 0.0, situation([0.0] * 3), vetting())
    assert speeds_mps(waypoints) == [3.0] * 3


def test_it_sweeps_up_to_what_bars_the_way_and_no_further() -> None:
    sweep = make_sweep()
    assert front_m(sweep.fly_on(LEG, 0.0, situation([0.0] * 3), vetting(lambda: 60.0))) == 50.0
    near = sweep.fly_on(LEG, 30.0, situation([30.0] * 3), vetting(lambda: 60.0))
    assert 50.0 <= front_m(near) <= 60.0
    sweep.end()
    # Less than a stopping distance is left to sweep: the search stops for each frame there.
    assert sweep.fly_on(LEG, 55.0, situation([55.0] * 3), vetting(lambda: 60.0)) == ()
    assert not sweep.is_under_way


def test_a_front_that_is_barred_later_is_drawn_back_or_ends_the_sweep() -> None:
    sweep, barred_from_m = make_sweep(), [np.inf]
    vet = vetting(lambda: barred_from_m[0])
    sweep.fly_on(LEG, 0.0, situation([0.0] * 3), vet)
    barred_from_m[0] = 40.0
    assert front_m(sweep.fly_on(LEG, 5.0, situation([5.0] * 3), vet)) <= 40.0
    barred_from_m[0] = 10.0
    assert sweep.fly_on(LEG, 5.0, situation([5.0] * 3), vet) == ()


def test_who_is_ahead_flies_slower_until_the_line_is_straight_again() -> None:
    sweep = make_sweep()
    assert speeds_mps(sweep.fly_on(LEG, 0.0, situation([5.0, 0.0, 5.0]), vetting())) == [2.5, 5.0, 2.5]
    assert speeds_mps(sweep.fly_on(LEG, 0.0, situation([6.0, 3.0, 6.0]), vetting())) == [2.5, 5.0, 2.5]
    assert speeds_mps(sweep.fly_on(LEG, 0.0, situation([7.0, 6.5, 7.0]), vetting())) == [5.0] * 3


def test_who_is_far_behind_is_named_once_and_no_longer_waited_for() -> None:
    journal = Heard()
    sweep = make_sweep(journal)
    for step in range(3):
        waypoints = sweep.fly_on(
            LEG, 20.0, situation([LEFT_BEHIND_M + 1.0 + step, 0.0, LEFT_BEHIND_M + 1.0 + step]), vetting()
        )
    assert journal.notices == [(2, "is 16 m behind the line: the others no longer wait for it")]
    assert speeds_mps(waypoints) == [5.0] * 3
    behind = situation([40.0, 0.0, 40.0])
    assert sweep.exposed_at_m(LEG, behind, (1, 2, 3)) == 40.0
    assert sweep.exposed_at_m(LEG, behind, (2,)) == 0.0


def test_late_frames_of_one_vehicle_leave_the_line_where_it_is() -> None:
    sweep = make_sweep()
    assert sweep.exposed_at_m(LEG, situation([40.0, 42.0, 41.0]), [1, 2, 3]) == pytest.approx(41.0)
    assert sweep.exposed_at_m(LEG, situation([40.0, 42.0, 33.0]), [1, 2, 3]) == pytest.approx(115.0 / 3.0)
    assert sweep.exposed_at_m(LEG, situation([40.0, 42.0, 9.0]), [1, 2, 3]) == pytest.approx(41.0)
    assert sweep.exposed_at_m(LEG, situation([42.0, 9.0]), [1, 2]) == pytest.approx(42.0)
    assert sweep.exposed_at_m(LEG, situation([40.0, 42.0, 9.0]), [3]) == pytest.approx(9.0)


def test_slow_frames_slow_the_line_so_that_their_places_stay_as_close() -> None:
    journal = Heard()
    sweep, along_m, pace_mps = make_sweep(journal), 0.0, FULL_MPS
    gaps_m = []
    for number in range(12):
        waypoints = sweep.fly_on(LEG, along_m, situation([along_m] * 3, 3.0 * number), vetting())
        pace_mps = speeds_mps(waypoints)[0] or 0.0
        gaps_m.append(3.0 * pace_mps)
        along_m += gaps_m[-1]
    assert gaps_m[-1] == pytest.approx(1.25 * FULL_MPS / 2.0)
    (named,) = journal.notices
    assert named[1].startswith("Frames come every 3.0 s instead of every 0.5 s: the line flies at 1.0 m/s")


def test_a_sweep_that_gains_no_ground_is_over() -> None:
    sweep = make_sweep()
    times_s = np.arange(0.0, STUCK_S + 2.0, 0.5)
    flown = [bool(sweep.fly_on(LEG, 0.0, situation([0.0] * 3, now_s), vetting())) for now_s in times_s.tolist()]
    assert flown == [now_s <= STUCK_S for now_s in times_s]


def test_ground_without_frames_is_a_gap_and_the_leg_is_not_looked_at_beyond_it() -> None:
    progress = ScanProgress(0.5)
    progress.plan([LEG])
    gap_m = make_sweep().longest_gap_m
    assert gap_m == 10.0
    assert progress.advance_in_flight(8.0, gap_m) is Advance.ON_LEG
    assert progress.advance_in_flight(18.5, gap_m) is Advance.GAP
    assert progress.along_m == 8.0
    assert progress.remaining_leg.start_enu_m == (0.0, 18.0)
    for along_m in np.arange(8.0, LEG.length_m - 0.5, 5.0).tolist():
        assert progress.advance_in_flight(along_m, gap_m) is Advance.ON_LEG
    assert progress.advance_in_flight(LEG.length_m - 0.4, gap_m) is Advance.END_OF_LEG
