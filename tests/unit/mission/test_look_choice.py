"""The choice between a close look and the scan, with values that can be computed by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.search.decisions.look_choice import LOOK_S, RETURN_S, TURN_S, USUAL_POD, LookChoice
from aos_gcs.mission.search.scan.progress import ScanProgress
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.search_settings import LookOrder, SearchMode, SearchSettings
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity
from tests.fakes.notices import Notices
from tests.fakes.target_sightings import SETTINGS

PLACE = (3.0, 40.0)


def choice(
    legs: int = 2,
    length_m: float = 100.0,
    search: SearchSettings | None = None,
    left_for_later: Sequence[LeftPlace] = (),
) -> tuple[LookChoice, ScanProgress, Notices]:
    settings: MissionSettings = replace(SETTINGS, search=search or SearchSettings(looks=LookOrder.GAIN))
    progress, journal = ScanProgress(0.5), Notices()
    progress.plan([ScanLeg((20.0 * number, 0.0), (0.0, 1.0), length_m) for number in range(legs)])
    return LookChoice(settings, journal, progress, left_for_later), progress, journal


def verdict(probability: float | None) -> Verdict:
    return Verdict(FindingKind.ANIMAL, probability, ())


def least_probability(legs: int, length_m: float, share: float = 1.0) -> float:
    """Return the probability from which p / (T_L + T_R) >= (1 - p) P / T_S."""
    scan_s = legs * (length_m / SETTINGS.flight.leg_speed_mps + TURN_S)
    rate = share * USUAL_POD / scan_s * (LOOK_S + RETURN_S)
    return rate / (1.0 + rate)


@given(st.integers(1, 20), st.floats(10.0, 2000.0), st.floats(0.0, 1.0))
def test_the_look_comes_first_where_it_gains_more(legs: int, length_m: float, probability: float) -> None:
    one, _, _ = choice(legs, length_m)
    least = least_probability(legs, length_m)
    if abs(probability - least) > 1e-9:
        assert one.leaves(PLACE, verdict(probability), vehicles=10) is (probability < least)


def test_the_longer_the_search_the_sooner_a_look_is_worth_it() -> None:
    assert least_probability(2, 100.0) == pytest.approx(0.344, abs=1e-3)
    assert least_probability(10, 500.0) == pytest.approx(0.028, abs=1e-3)


def test_what_has_not_been_judged_waits_for_a_step_and_without_temperatures_it_may_be_a_person() -> None:
    one, _, _ = choice(20, 500.0)
    assert one.leaves(PLACE, None, vehicles=10)
    assert not one.leaves(PLACE, verdict(None), vehicles=10)
    assert one.later_enu_m == ()


def test_a_swarm_that_can_split_loses_less_of_the_scan() -> None:
    split = SearchSettings(looks=LookOrder.GAIN, split=True)
    between = (least_probability(2, 100.0) + least_probability(2, 100.0, 0.5)) / 2.0
    assert choice(search=split)[0].leaves(PLACE, verdict(between), vehicles=7)
    assert not choice(search=split)[0].leaves(PLACE, verdict(between), vehicles=10)
    assert choice()[0].leaves(PLACE, verdict(between), vehicles=10)


@pytest.mark.parametrize("search", [SearchSettings(looks=LookOrder.FIRST), SearchSettings(SearchMode.STOPS)])
def test_without_the_choice_nothing_is_left(search: SearchSettings) -> None:
    one, _, _ = choice(search=search)
    assert not one.leaves(PLACE, None, vehicles=10)


def test_places_are_looked_at_in_the_order_of_their_gain_on_legs_of_their_own() -> None:
    one, progress, journal = choice()
    one.leaves((0.0, 90.0), verdict(0.05), vehicles=3)
    one.leaves((20.0, 10.0), verdict(0.3), vehicles=3)
    assert set(one.later_enu_m) == {(0.0, 90.0), (20.0, 10.0)}
    assert not one.is_look_leg
    for place_m in ((20.0, 10.0), (0.0, 90.0)):
        leg = one.next_leg((), None)
        assert leg is not None
        progress.leave_for(leg)
        assert one.is_look_leg
        # It leads over the place, which leads the swarm again.
        assert one.later_enu_m == ()
        assert leg.after(leg.length_m / 2.0).start_enu_m == pytest.approx(place_m)
        # A look leg has nothing to go on with.
        assert not one.leaves(place_m, verdict(0.01), vehicles=3)
    assert one.next_leg((), None) is None
    assert len(journal.texts) == 2
    one.tell_left((), None)
    assert len(journal.texts) == 2


def test_what_was_looked_at_meanwhile_is_not_flown_to() -> None:
    one, _, journal = choice()
    one.leaves(PLACE, verdict(0.1), vehicles=3)
    assert one.next_leg([(3.0, 41.5)], None) is None
    one.tell_left((), None)
    assert journal.texts == []


def test_legs_that_are_left_for_looks_count_as_left_out() -> None:
    one, progress, _ = choice(legs=3, length_m=100.0)
    progress.advance_in_flight(30.0, 50.0)
    one.leaves(PLACE, verdict(0.1), vehicles=3)
    leg = one.next_leg((), None)
    assert leg is not None
    progress.leave_for(leg)
    assert progress.left_out_m == pytest.approx(270.0)
    assert progress.present_leg is leg


def test_before_there_are_legs_nothing_is_left() -> None:
    one, _, _ = choice(legs=0)
    assert one.next_leg((), None) is None


def test_what_the_search_ends_without_is_named() -> None:
    one, _, journal = choice()
    one.leaves(PLACE, verdict(0.1), vehicles=3)
    one.tell_left((), None)
    assert journal.texts == ["Not examined (left for later): 3.0 m east, 40.0 m north"]
    assert journal.severities == [Severity.WARNING]


def test_the_station_that_takes_up_a_flight_goes_on_with_what_was_left() -> None:
    one, _, _ = choice()
    one.leaves((3.0, 40.0), verdict(0.1), vehicles=3)
    one.leaves((9.0, 80.0), verdict(0.3), vehicles=3)
    other, progress, _ = choice(left_for_later=one.left_for_later)
    assert other.taken_up == other.left_for_later == one.left_for_later
    assert [left.place_enu_m for left in other.left_for_later] == [(3.0, 40.0), (9.0, 80.0)]
    for _ in progress.legs:
        progress.begin_next_leg()
    leg = other.next_leg([], None)
    assert leg is not None
    assert (leg.start_enu_m[0], leg.start_enu_m[1] + leg.length_m / 2.0) == pytest.approx((9.0, 80.0))
