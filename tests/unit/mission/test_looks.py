"""What is looked at, settled and announced, and for how long."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.imaging.geolocation import Geolocation
from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.imaging.step.judgement import SETTLED_M
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.search.targets.claims import Claims
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.looks import Looks
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.mission.search.targets.tracker import TargetTracker
from tests.fakes.notices import Notices
from tests.fakes.target_sightings import SETTINGS, STEP_S, Follower, analysis, seen


@pytest.mark.parametrize("steps_out_of_view", [0, 3])
def test_the_blob_of_a_settled_target_is_settled_even_where_it_lies_beside_its_place(steps_out_of_view: int) -> None:
    """Erring poses displace blobs from what all views locate; the swarm would turn to the same thing for ever.

    Also when the vehicles that hover no longer see what they saw in flight: one sweep was stopped ten times.
    """
    follower = Follower(FindingKind.WARM_OBJECT)
    claims = Claims(SETTINGS.detection, Notices(), follower.tracker, Findings())
    beside = seen(5.0, 20.0)
    beside = replace(beside, blob=replace(beside.blob, centroid_enu_m=(5.0 + 1.5 * SETTLED_M, 20.0, 0.0)))
    follower.observe(beside)
    for _ in range(steps_out_of_view):
        follower.observe()
    claims.settle_target()
    for east_m in (5.0, 5.0 + 1.5 * SETTLED_M):
        assert min(math.dist(place, (east_m, 20.0)) for place in claims.settled_enu_m) < 0.5
    settled = claims.settled_enu_m
    claims.settle_target()
    assert claims.settled_enu_m == settled


def test_what_leaves_show_and_hide_in_turn_is_left_after_three_sightings() -> None:
    """A cloth that flickers drew the swarm ten times in one mission, as it was never seen often enough in a row."""
    cloth = Judgement(Verdict(FindingKind.OBJECT, 0.0, (), is_surely_other=True))
    tracker = TargetTracker(SETTINGS)
    claims = Claims(SETTINGS.detection, Notices(), tracker, Findings())
    for step in range(9):
        sightings = [seen(5.0, 20.0)] if step % 4 == 0 else []
        tracker.observe(analysis(*sightings), STEP_S * (step + 1))
        tracker.judge(dict.fromkeys(tracker.places_enu_m(), cloth))
        claims.announce()
        is_third = step == 8
        assert claims.is_look_over() is is_third


def test_what_most_frames_show_to_be_no_person_is_left_at_once() -> None:
    """A stone that all vehicles had seen in all frames of three steps drew the swarm five times in one mission."""
    stone = Judgement(Verdict(FindingKind.WARM_OBJECT, 0.01, (), is_surely_other=True, is_thorough=True))
    tracker = TargetTracker(SETTINGS)
    claims = Claims(SETTINGS.detection, Notices(), tracker, Findings())
    tracker.observe(analysis(seen(5.0, 20.0)), STEP_S)
    tracker.judge(dict.fromkeys(tracker.places_enu_m(), stone))
    claims.announce()
    assert claims.is_look_over()


def test_what_is_left_for_later_is_not_settled_by_frames_in_flight_and_its_look_begins_anew() -> None:
    """Persons 4 K cooler than usual were dismissed by the frames of the legs, and never looked at."""
    animal = Judgement(Verdict(FindingKind.ANIMAL, 0.005, (), is_surely_other=True))
    tracker = TargetTracker(SETTINGS)
    claims = Claims(SETTINGS.detection, Notices(), tracker, Findings())
    settled = []
    for step in range(9):
        tracker.observe(analysis(seen(5.0, 20.0)), STEP_S * (step + 1))
        tracker.judge(dict.fromkeys(tracker.places_enu_m(), animal))
        tracker.give_up()
        claims.announce(later_enu_m=[(5.5, 20.5)] if step < 6 else ())
        settled.append(len(claims.settled_enu_m))
    assert settled == [0] * 8 + [1]


@pytest.mark.parametrize("warm", [True, False])
def test_what_is_marked_once_and_then_only_warm_is_not_looked_at_again(warm: bool) -> None:
    """A deer drew the swarm five times in one mission: it was marked in single steps, and seen warm in most others."""
    verdict = Verdict(FindingKind.ANIMAL, 0.01, (), is_surely_other=True)
    place = Geolocation(np.array([5.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
    tracker = TargetTracker(SETTINGS)
    claims = Claims(SETTINGS.detection, Notices(), tracker, Findings())
    settled = []
    for step in range(3):
        tracker.observe(analysis(*([] if step else [seen(5.0, 20.0)])), STEP_S * (step + 1))
        tracker.judge(dict.fromkeys(tracker.places_enu_m(), Judgement(verdict, place if warm else None)))
        claims.announce()
        tracker.give_up()
        settled.append(len(claims.settled_enu_m))
    assert settled == [0, 0, 1 if warm else 0], "where nothing warm shows, leaves may hide it"


@pytest.mark.parametrize("sure", [True, False])
def test_what_is_out_of_view_is_searched_for_unless_it_was_surely_no_person(sure: bool) -> None:
    follower = Follower(FindingKind.WARM_OBJECT)
    claims = Claims(SETTINGS.detection, Notices(), follower.tracker, Findings())
    follower.verdict = replace(follower.verdict, is_surely_other=sure)
    assert claims.is_worth_a_search()
    follower.observe(seen(5.0, 20.0))
    follower.observe()
    assert claims.is_worth_a_search() is not sure


def test_a_settled_place_stays_when_its_track_goes_on_to_something_else() -> None:
    """A track that coasted away with a made-up speed took the settled place of a deer along: it was looked at again."""
    looks = Looks()
    looks.settle(1, (5.0, 20.0, 0.0))
    looks.follow({1: np.array([5.8, 20.0])})
    assert looks.settled_enu_m == ((5.8, 20.0),)
    looks.follow({1: np.array([5.8 + 1.1 * SETTLED_M, 20.0])})
    looks.follow({1: np.array([6.0, 20.0])})
    assert looks.settled_enu_m == ((5.8, 20.0),)


def test_only_what_is_in_view_moves_the_places_of_looks() -> None:
    follower = Follower(FindingKind.ANIMAL)
    follower.observe(seen(5.0, 20.0), seen(15.0, 20.0))
    assert len(follower.tracker.places_in_view_enu_m()) == 2
    follower.observe(seen(5.0, 20.0))
    (place_enu_m,) = follower.tracker.places_in_view_enu_m().values()
    assert place_enu_m == pytest.approx([5.0, 20.0], abs=0.5)
    assert len(follower.tracker.places_enu_m()) == 2


def test_a_sighting_that_may_be_a_person_begins_the_count_anew() -> None:
    looks, place = Looks(), (5.0, 20.0, 0.0)
    counts = [
        looks.count_other(1, place, is_surely_other=sure, may_be_person=not sure) for sure in (True, True, False, True)
    ]
    assert counts == [1, 2, 0, 1]


def test_a_sighting_by_too_few_to_be_sure_leaves_the_count_as_it_is() -> None:
    looks, place = Looks(), (5.0, 20.0, 0.0)
    looks.count_other(1, place, is_surely_other=True, may_be_person=False)
    assert looks.count_other(1, place, is_surely_other=False, may_be_person=False) == 1
    assert looks.count_other(2, place, is_surely_other=True, may_be_person=False) == 2, "another track of it"


@pytest.mark.parametrize(
    ("kind", "text"), [(FindingKind.PERSON, "Possible person"), (FindingKind.WARM_OBJECT, "Warm object?")]
)
def test_two_tracks_of_one_body_are_announced_once(kind: FindingKind, text: str) -> None:
    tracker, journal = TargetTracker(SETTINGS), Notices()
    claims = Claims(SETTINGS.detection, journal, tracker, Findings())
    place = Geolocation(np.array([1.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
    is_person = kind is FindingKind.PERSON
    judgement = Judgement(Verdict(kind, 0.9 if is_person else 0.0, (), not is_person), place)
    for step in range(5):
        tracker.observe(analysis(seen(30.0, 0.0, 0.9), seen(0.0, 20.0), seen(2.0, 20.0)), STEP_S * (step + 1))
        tracker.judge({key: judgement for key, at in tracker.places_enu_m().items() if at[0] < 20.0})
        claims.announce()
    assert len([one for one in journal.texts if one.startswith(text)]) == 1
    assert set(journal.track_ids) <= tracker.places_enu_m().keys()
    kinds = [target.kind for target in tracker.estimates() if target.position_enu_m[0] < 20.0]
    assert kinds == [kind] * 2


def test_another_track_of_a_person_who_is_watched_does_not_settle_its_place() -> None:
    """The swarm lost a person two steps after it was announced, and searched on for minutes."""
    tracker = TargetTracker(SETTINGS)
    claims = Claims(SETTINGS.detection, Notices(), tracker, Findings())
    place = Geolocation(np.array([1.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
    judgement = Judgement(Verdict(FindingKind.PERSON, 0.9, ()), place)
    for step in range(8):
        tracker.observe(analysis(seen(0.0, 20.0, 0.9), seen(2.0, 20.0)), STEP_S * (step + 1))
        tracker.judge(dict.fromkeys(tracker.places_enu_m(), judgement))
        watched = claims.announce()
    assert watched is not None
    assert [target.kind for target in tracker.estimates()] == [FindingKind.PERSON] * 2
    assert claims.settled_enu_m == ()
    claims.settle_target()
    assert len(claims.settled_enu_m) >= 1


def test_what_may_be_a_person_is_not_left_for_something_larger() -> None:
    tracker = TargetTracker(SETTINGS)
    claims = Claims(SETTINGS.detection, Notices(), tracker, Findings())
    person, deer = Judgement(Verdict(FindingKind.PERSON, 0.7, ())), Judgement(Verdict(FindingKind.ANIMAL, 0.1, ()))
    tracker.observe(analysis(seen(20.0, 20.0, 0.9), seen(0.0, 20.0)), STEP_S)
    (of_deer,) = (key for key, place in tracker.places_enu_m().items() if place[0] > 10.0)
    assert claims.settled_enu_m == ()
    tracker.judge({key: deer if key == of_deer else person for key in tracker.places_enu_m()})
    assert claims.settled_enu_m == (pytest.approx((20.0, 20.0), abs=0.5),)
    tracker.observe(analysis(seen(20.0, 20.0, 0.9)), 2 * STEP_S)
    assert claims.settled_enu_m == ()


@pytest.mark.parametrize("sure", [True, False])
def test_what_most_vehicles_see_to_be_no_person_needs_no_longer_look(*, sure: bool) -> None:
    follower, journal = Follower(), Notices()
    claims = Claims(SETTINGS.detection, journal, follower.tracker, Findings())
    follower.verdict = Verdict(FindingKind.WARM_OBJECT, 0.01, (), sure)
    over = []
    for _ in range(5):
        follower.observe(seen(5.0, 20.0), seen(20.0, 20.0, 0.15))
        claims.announce()
        over.append(claims.is_look_over())
    assert over == [False, False, sure, sure, sure]
    # The other one is settled in passing, once it is confirmed; nobody has to fly there.
    assert (len(claims.settled_enu_m) == 1) == sure
    assert journal.texts[0].startswith("Warm object?") if sure else journal.texts == []


@pytest.mark.parametrize(
    ("probability", "at_once", "in_the_end"), [(0.9, True, True), (0.75, False, True), (0.55, False, False)]
)
def test_a_person_of_whom_the_looks_are_less_sure_is_announced_once_the_look_is_over(
    probability: float, at_once: bool, in_the_end: bool
) -> None:
    follower, journal = Follower(), Notices()
    claims = Claims(SETTINGS.detection, journal, follower.tracker, Findings())
    follower.verdict = Verdict(FindingKind.PERSON, probability, ())
    steps = SETTINGS.detection.look_steps
    for step in range(1, steps + 1):
        follower.observe(seen(5.0, 20.0))
        claims.announce()
        assert claims.is_look_over() is (step == steps)
    assert bool(journal.texts) is at_once
    claims.settle_target()
    assert any(text.startswith("Possible person") for text in journal.texts) is in_the_end


def test_operators_are_told_once_that_more_looks_make_an_announced_person_unlikely() -> None:
    follower, journal = Follower(), Notices()
    claims = Claims(SETTINGS.detection, journal, follower.tracker, Findings())
    for step in range(40):
        if step == 5:
            follower.verdict = Verdict(FindingKind.WARM_OBJECT, 0.02, ("no skin to be seen",))
        follower.observe(seen(5.0, 20.0))
        claims.announce()
    announced, doubted = journal.texts
    assert announced.startswith("Possible person (96 %) at 5.0 m east, 20.0 m north")
    assert doubted.startswith("Possible person (")
    assert doubted.endswith("More looks make a person unlikely: judge it in Decide")
    assert journal.track_ids[0] == journal.track_ids[1]
    (estimate,) = follower.tracker.estimates()
    assert estimate.kind is FindingKind.PERSON


@pytest.mark.parametrize("other", [FindingKind.OBJECT, FindingKind.WARM_OBJECT])
def test_an_announced_person_stays_where_it_was_when_its_track_goes_on_to_something_else(other: FindingKind) -> None:
    """A finding moved 3 m from the person to a puddle, and the person was announced again."""
    follower, journal = Follower(), Notices()
    claims = Claims(SETTINGS.detection, journal, follower.tracker, Findings())
    for _ in range(5):
        follower.observe(seen(5.0, 20.0))
        claims.announce()
    follower.verdict = Verdict(other, 0.0, ())
    for step in range(8):
        follower.observe(seen(5.0 + 0.5 * step, 20.0))
        claims.announce()
    (estimate,) = follower.tracker.estimates()
    assert estimate.kind is FindingKind.PERSON
    assert estimate.position_enu_m[:2] == pytest.approx((5.0, 20.0), abs=0.2)
    assert follower.tracker.places_enu_m()[estimate.track_id][0] > 6.0


def test_an_announced_person_does_not_go_over_to_another_body_that_a_look_takes_for_one() -> None:
    """Were a stone as warm as clothes, 5 m off, its place, the list would have a second person there."""
    tracker, journal = TargetTracker(SETTINGS), Notices()
    claims = Claims(SETTINGS.detection, journal, tracker, Findings())
    for step in range(8):
        east_m = 5.0 if step < 6 else 10.0
        place = Geolocation(np.array([east_m, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
        tracker.observe(analysis(seen(5.0, 20.0)), STEP_S * (step + 1))
        judgement = Judgement(Verdict(FindingKind.PERSON, 0.9, ()), place)
        tracker.judge(dict.fromkeys(tracker.places_enu_m(), judgement))
        claims.announce()
    (estimate,) = tracker.estimates()
    assert estimate.kind is FindingKind.PERSON
    assert estimate.position_enu_m[0] == pytest.approx(5.0, abs=0.5)


def looked_at(probability: float, *, findings: Findings) -> tuple[Claims, Notices, Follower]:
    """Return the claims of a mission that has looked at something warm, and has not decided that it is a person."""
    follower, journal = Follower(FindingKind.WARM_OBJECT), Notices()
    follower.verdict = Verdict(FindingKind.WARM_OBJECT, probability, ("14 K warmer than its surroundings",))
    claims = Claims(SETTINGS.detection, journal, follower.tracker, findings)
    for step in range(12):
        follower.observe(seen(5.0, 20.0))
        claims.announce()
        claims.is_look_over()
        findings.observe(follower.tracker.estimates(), step, STEP_S * step)
    return claims, journal, follower


@pytest.mark.parametrize(
    ("probability", "percent", "is_announced"), [(0.34, 34, False), (0.36, 36, True), (0.59, 63, True)]
)
def test_what_a_look_leaves_undecided_is_announced_when_the_search_ends(
    probability: float, percent: int, is_announced: bool
) -> None:
    """Eight of eleven persons missed in 210 missions were left with 35 to 60 %, and two other bodies."""
    findings = Findings()
    claims, journal, follower = looked_at(probability, findings=findings)
    claims.settle_target()
    assert not findings.persons()
    told = len(journal.texts)
    claims.announce_at_last()
    assert len(findings.persons()) == len(journal.texts[told:]) == is_announced
    if is_announced:
        assert journal.texts[-1].startswith(f"Possible person ({percent} %) at 5.0 m east, 20.0 m north")
        assert journal.texts[-1].endswith("Undecided when the search ended")
        (estimate,) = follower.tracker.estimates()
        assert (journal.track_ids[-1], estimate.kind) == (estimate.track_id, FindingKind.PERSON)
        assert claims.first_at_s is not None
    claims.announce_at_last()
    assert len(journal.texts) == told + is_announced


def test_what_was_not_looked_at_or_is_rejected_is_not_announced_when_the_search_ends() -> None:
    findings = Findings()
    claims, _, _ = looked_at(0.5, findings=findings)
    claims.announce_at_last()
    assert not findings.persons()
    claims.settle_target()
    findings.change(1, FindingChange(status=FindingStatus.REJECTED), "Ada")
    claims.announce_at_last()
    assert not findings.persons()


def test_what_lies_beside_an_announced_person_is_not_announced_when_the_search_ends() -> None:
    findings = Findings()
    claims, journal, _ = looked_at(0.5, findings=findings)
    claims.settle_target()
    beside = findings.add((7.0, 20.0, 0.0), "", "Ada", 1, 1.0)
    findings.change(beside.finding_id, FindingChange(status=FindingStatus.CONFIRMED), "Ada")
    told = len(journal.texts)
    claims.announce_at_last()
    assert len(journal.texts) == told
