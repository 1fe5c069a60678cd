"""Tracks made of sightings, and the decision that a target is found."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.geolocation import Geolocation, Uncertainty
from aos_gcs.imaging.model import Blob, BlobView, Sighting
from aos_gcs.imaging.persons.decision import DECISION, FORM_TOLD, FindingKind, Verdict
from aos_gcs.imaging.persons.form import FormSums, form_sums
from aos_gcs.imaging.persons.warm_bodies import WarmView
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.mission.search.targets.tracker import TargetTracker, error_ellipse
from tests.fakes.target_sightings import CAMERA, SETTINGS, STEP_S, Follower, analysis, seen


def test_nothing_and_small_blobs_are_out_of_view() -> None:
    follower = Follower()
    assert not follower.observe()
    assert not follower.observe(seen(0, 0, area_m2=0.099))
    assert follower.tracker.steps_out_of_view == 2
    assert follower.tracker.estimate() is None
    assert follower.observe(seen(0, 0, area_m2=0.1))
    assert follower.tracker.steps_out_of_view == 0


def test_found_after_agreeing_steps_in_a_row() -> None:
    follower = Follower()
    verdicts = []
    for offset_m in (0.0, 0.4, -0.4):
        follower.observe(seen(5.0 + offset_m, 20.0))
        verdicts.append(follower.agrees())
    assert verdicts == [False, False, True]


@pytest.mark.parametrize(("kind", "agrees"), [(FindingKind.PERSON, True), (FindingKind.ANOMALY, False)])
def test_a_gap_keeps_the_estimate_but_without_temperatures_starts_the_count_again(
    kind: FindingKind, agrees: bool
) -> None:
    follower = Follower(kind)
    for _ in range(2):
        follower.observe(seen(5.0, 20.0))
    follower.observe()
    assert not follower.agrees(), "out of view"
    follower.observe(seen(5.0, 20.0))
    assert follower.agrees() is agrees
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.sightings == 3


@pytest.mark.parametrize("kind", [FindingKind.ANIMAL, FindingKind.WARM_OBJECT, FindingKind.OBJECT])
def test_what_is_no_person_is_never_agreed_to_be_one(kind: FindingKind) -> None:
    follower = Follower(kind)
    for _ in range(10):
        follower.observe(seen(5.0, 20.0))
    assert not follower.agrees()


@pytest.mark.parametrize(
    ("second", "kind", "is_announced"),
    [(0.5, FindingKind.PERSON, True), (0.3, FindingKind.PERSON, False), (0.0, FindingKind.WARM_OBJECT, False)],
)
def test_several_sightings_decide_together(second: float, kind: FindingKind, is_announced: bool) -> None:
    """A person who is less sure than 80 % is announced once the look is over."""
    follower = Follower()
    for probability in (0.9, second, 0.9):
        single = FindingKind.PERSON if probability >= DECISION else FindingKind.WARM_OBJECT
        follower.verdict = Verdict(single, probability, ())
        follower.observe(seen(5.0, 20.0))
    (track_id,) = follower.tracker.places_enu_m()
    verdict = follower.tracker.verdict(track_id)
    assert verdict is not None
    assert verdict.kind is kind
    assert follower.agrees() is is_announced


def test_a_person_whom_leaves_hide_most_of_the_time_is_announced_by_its_warmth() -> None:
    """One mark 10 m off, among few, kept it from being announced for a whole mission."""
    tracker, judgement = (
        TargetTracker(SETTINGS),
        Judgement(
            Verdict(FindingKind.PERSON, 0.9, ()),
            Geolocation(np.array([5.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3)),
        ),
    )
    agreed = []
    for step in range(3):
        tracker.observe(analysis(*([seen(5.0, 20.0)] if step < 2 else [])), STEP_S * (step + 1))
        (track_id,) = tracker.places_enu_m()
        tracker.judge({track_id: judgement})
        agreed.append(tracker.agrees(track_id))
    assert agreed == [False, False, True]


def test_a_new_track_at_a_known_body_is_taken_for_the_same() -> None:
    """Leaves cut a boar in two; its second track was announced by four glances after the first was known to be one."""
    tracker = TargetTracker(SETTINGS)
    place = Geolocation(np.array([5.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
    boar = Judgement(Verdict(FindingKind.ANIMAL, 0.05, ()), place)
    glance = Judgement(Verdict(FindingKind.PERSON, 0.8, ()), place)
    for step in range(8):
        pieces = [seen(5.0, 20.0)] if step < 7 else [seen(5.0, 20.0), seen(9.0, 20.0)]
        tracker.observe(analysis(*pieces), STEP_S * (step + 1))
        tracker.judge(dict.fromkeys(tracker.places_enu_m(), boar if step < 7 else glance))
    verdicts = [tracker.verdict(track_id) for track_id in tracker.places_enu_m()]
    assert [None if verdict is None else verdict.kind for verdict in verdicts] == [FindingKind.ANIMAL] * 2


@pytest.mark.parametrize(
    ("vantage_points", "agrees"), [(0, True), (1, False), (FORM_TOLD - 1, False), (FORM_TOLD, True)]
)
def test_a_person_whose_form_begins_to_show_is_announced_once_it_is_told(vantage_points: int, *, agrees: bool) -> None:
    """Seen from two sides, a boar of 25 degrees was announced with 78 %; its form made that 14 %."""
    tracker = TargetTracker(SETTINGS)
    place = Geolocation(np.array([5.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
    judgement = Judgement(Verdict(FindingKind.PERSON, 0.9, ()), place, form_sums=standing_person(vantage_points))
    for step in range(SETTINGS.detection.found_steps):
        tracker.observe(analysis(seen(5.0, 20.0)), STEP_S * (step + 1))
        (track_id,) = tracker.places_enu_m()
        tracker.judge({track_id: judgement})
    assert tracker.agrees(track_id) is agrees


def standing_person(vantage_points: int) -> FormSums:
    """Sums of the form of a body of 0.5 by 0.3 m at (5, 20), from that many places 10 m around it."""
    rng = np.random.default_rng(1)
    bearings_rad = np.linspace(0.0, 2.0 * math.pi, vantage_points, endpoint=False)
    views = [
        WarmView(
            vehicle_id=1,
            points_enu_m=np.array([5.0, 20.0]) + rng.uniform(-0.5, 0.5, (100, 2)) * (0.5, 0.3),
            contrast_k=np.full(100, 14.0),
            pixel_area_m2=0.0015,
            camera=CAMERA,
            pose=nadir_pose([5.0 + 10.0 * math.sin(bearing_rad), 20.0 + 10.0 * math.cos(bearing_rad), 35.0]),
        )
        for bearing_rad in bearings_rad
    ]
    return form_sums(views, 0.0)


def test_two_looks_that_are_nearly_the_same_do_not_tell_a_person() -> None:
    """Between leaves a boar showed its bare parts alone; flying past told nothing more, and it was announced."""
    tracker = TargetTracker(replace(SETTINGS, detection=replace(SETTINGS.detection, found_steps=4)))
    place = Geolocation(np.array([5.0, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
    boar, in_flight = Verdict(FindingKind.PERSON, 0.99, ()), Verdict(FindingKind.ANIMAL, 0.4, (), is_evidence=False)
    agreed = []
    for step, verdict in enumerate((boar, boar, in_flight, in_flight, in_flight, boar, boar)):
        tracker.observe(analysis(seen(5.0, 20.0)), STEP_S * (step + 1))
        (track_id,) = tracker.places_enu_m()
        tracker.judge({track_id: Judgement(verdict, place)})
        agreed.append(tracker.agrees(track_id))
    assert agreed == [False] * 6 + [True]


def test_a_track_that_goes_from_a_person_to_a_stone_elsewhere_is_judged_by_the_stone_alone() -> None:
    """The track of a person jumped 10 m to a stone, which was announced for the person's sake."""
    tracker, track_id = TargetTracker(SETTINGS), 0
    for step, (east_m, kind, probability) in enumerate(
        [(0.0, FindingKind.PERSON, 0.99)] * 2 + [(10.0, FindingKind.WARM_OBJECT, 0.3)]
    ):
        tracker.observe(analysis(seen(5.0, 20.0)), STEP_S * (step + 1))
        (track_id,) = tracker.places_enu_m()
        place = Geolocation(np.array([5.0 + east_m, 20.0, 0.0]), 0.1 * np.eye(3), 0.1 * np.eye(3))
        tracker.judge({track_id: Judgement(Verdict(kind, probability, ()), place)})
    verdict = tracker.verdict(track_id)
    assert verdict is not None
    assert verdict.probability == pytest.approx(0.3)


def test_a_sighting_that_was_not_judged_is_no_confirmation() -> None:
    follower = Follower()
    for _ in range(2):
        follower.observe(seen(5.0, 20.0))
    follower.tracker.observe(analysis(seen(5.0, 20.0)), follower.now_s + STEP_S)
    assert not follower.agrees()


def test_a_settled_blob_is_tracked_but_is_no_target() -> None:
    follower = Follower()
    assert not follower.observe(replace(seen(5.0, 20.0), settled=True))
    assert follower.tracker.estimate() is None
    assert len(follower.tracker.places_enu_m()) == 1
    assert follower.observe(seen(9.0, 3.0, 0.15), replace(seen(5.0, 20.0), settled=True))
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.position_enu_m[:2] == pytest.approx((9.0, 3.0))


def test_without_temperatures_a_blob_marked_by_too_few_frames_is_no_confirmation() -> None:
    follower = Follower(FindingKind.ANOMALY)
    for count in (3, 2, 3):
        follower.observe(seen(5.0, 20.0, count=count))
    assert not follower.agrees()
    for _ in range(2):
        follower.observe(seen(5.0, 20.0))
    assert follower.agrees()


def test_sightings_that_wander_apart_are_not_found() -> None:
    follower = Follower()
    for east_m in (0.0, 1.9, 2.8):
        follower.observe(seen(east_m, 0.0))
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.sightings == 3  # enough of one target, but not in one place
    assert not follower.agrees()


def test_a_jump_is_another_object() -> None:
    follower = Follower()
    for _ in range(3):
        follower.observe(seen(0.0, 0.0))
    follower.observe(seen(10.0, 0.0))
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.position_enu_m == pytest.approx((10.0, 0.0, 0.0))
    assert estimate.sightings == 1
    assert not follower.agrees()


def test_a_walker_is_found_where_its_track_predicts_it() -> None:
    follower = Follower()
    verdicts = []
    for step in range(6):
        follower.observe(seen(3.0 * step, 0.0))
        verdicts.append(follower.agrees())
    assert verdicts == [False, False, False, False, False, True]
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.velocity_enu_mps == pytest.approx((1.5, 0.0), abs=0.2)


def test_a_second_target_is_told_of_once_it_is_confirmed() -> None:
    follower = Follower()
    for step in range(4):
        follower.observe(seen(0.0, 0.0), seen(20.0, 5.0, area_m2=0.15))
        assert len(follower.tracker.estimates()) == (1 if step < 3 else 2)
    target, other = follower.tracker.estimates()
    assert target == follower.tracker.estimate()
    assert (target.track_id, other.track_id) == (1, 2)
    assert other.position_enu_m == pytest.approx((20.0, 5.0, 0.0))


def test_two_persons_in_turns_do_not_keep_each_other_from_being_found() -> None:
    follower = Follower()
    for area_m2 in (0.2, 0.4, 0.2):
        follower.observe(*sorted((seen(0.0, 0.0, 0.3), seen(20.0, 0.0, area_m2)), key=lambda s: -s.blob.area_m2))
    assert follower.agrees()


def test_the_estimate_stays_when_the_target_is_not_seen_again() -> None:
    follower = Follower()
    follower.observe(seen(5.0, 5.0))
    for _ in range(30):
        follower.observe()
    assert follower.tracker.measured_enu_m is None
    assert follower.tracker.estimate() is not None
    assert [target.track_id for target in follower.tracker.estimates()] == [1]
    follower.tracker.give_up()
    assert follower.tracker.estimate() is None
    assert follower.tracker.estimates() == ()


def test_the_error_shrinks_with_sightings_but_not_below_the_biases() -> None:
    follower, sigmas_m = Follower(), []
    for _ in range(30):
        follower.observe(seen(5.0, 5.0))
        estimate = follower.tracker.estimate()
        assert estimate is not None
        assert estimate.sigma_m is not None
        sigmas_m.append(estimate.sigma_m)
    assert sigmas_m == sorted(sigmas_m, reverse=True)
    biases_m = math.sqrt(0.8 * (0.5**2 + (35.0 * math.radians(1.0)) ** 2) + 0.1**2)
    assert sigmas_m[-1] == pytest.approx(biases_m, rel=0.1)


def test_one_vehicle_with_a_poor_compass_has_a_long_ellipse() -> None:
    uncertainty = replace(Uncertainty(), yaw_rad=math.radians(10.0), attitude_rad=0.0, position_horizontal_m=0.1)
    tracker = TargetTracker(replace(SETTINGS, uncertainty=uncertainty))
    view = BlobView(1, np.array([10.0, 0.0]), CAMERA, nadir_pose([0.0, 0.0, 35.0]))
    tracker.observe(analysis(Sighting(Blob(0.2, (10.0, 0.0, 0.0), 1), (view,))), 1.0)
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.ellipse is not None
    assert estimate.ellipse.semi_major_m > 2 * estimate.ellipse.semi_minor_m
    assert abs(math.sin(estimate.ellipse.heading_rad)) < 0.01  # north and south, across the line of sight


def test_a_suspected_blob_is_in_view_however_small_it_is() -> None:
    view = BlobView(1, np.array([10.0, 0.0]), CAMERA, nadir_pose([0.0, 0.0, 35.0]))
    small = Sighting(Blob(0.01, (10.0, 0.0, 0.0), 1), (view,))
    for sighting, is_in_view in ((small, False), (replace(small, suspected=True), True)):
        assert TargetTracker(SETTINGS).observe(analysis(sighting), 1.0) is is_in_view


def test_the_ellipse_of_a_covariance() -> None:
    along = np.array([math.sin(0.5), math.cos(0.5)])
    across = np.array([along[1], -along[0]])
    ellipse = error_ellipse(4.0 * np.outer(along, along) + np.outer(across, across))
    assert (ellipse.semi_major_m, ellipse.semi_minor_m, ellipse.heading_rad) == pytest.approx((2.0, 1.0, 0.5))


def test_a_verdict_on_a_track_stays_until_there_is_another() -> None:
    follower = Follower()
    follower.observe(seen(2.0, 3.0))
    follower.tracker.judge({})
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.person_confidence == pytest.approx(0.9)
    assert estimate.reasons == ("it waves",)
    assert estimate.kind is FindingKind.UNDECIDED  # until the mission has decided


def test_without_a_verdict_nothing_is_said_about_persons() -> None:
    tracker = TargetTracker(SETTINGS)
    tracker.observe(analysis(seen(2.0, 3.0)), STEP_S)
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.person_confidence is None


def test_a_target_that_stays_is_where_its_warm_body_is_known_best() -> None:
    follower = Follower()
    for _ in range(4):
        follower.observe(seen(5.0, 20.0))
    sharp, blurred = (
        Geolocation(np.array([east_m, 20.0, 0.0]), sigma_m**2 * np.eye(3), np.zeros((3, 3)))
        for east_m, sigma_m in ((5.2, 0.2), (6.0, 0.8))
    )
    for place in (sharp, blurred):
        follower.tracker.judge({1: Judgement(follower.verdict, place)})
    estimate = follower.tracker.estimate()
    assert estimate is not None
    assert estimate.position_enu_m == (5.2, 20.0, 0.0)
    assert estimate.sigma_m == pytest.approx(0.2)


def test_a_track_that_goes_over_to_another_body_leaves_the_place_of_the_former_one() -> None:
    """A person was announced where a deer stood: the track had been the deer's, whose place was known better."""
    tracker = TargetTracker(SETTINGS)
    for now_s, east_m, sigma_m, kind in (
        (2.0, -6.6, 0.3, FindingKind.ANIMAL),
        (19.6, 4.4, 0.8, FindingKind.PERSON),
        (23.8, 4.4, 0.8, FindingKind.PERSON),
    ):
        tracker.observe(analysis(), now_s - 1.0)
        tracker.observe(analysis(seen(east_m, 30.0)), now_s)
        place = Geolocation(np.array([east_m, 30.0, 0.0]), sigma_m**2 * np.eye(3), np.zeros((3, 3)))
        tracker.judge({1: Judgement(Verdict(kind, 0.9, ()), place)})
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.sightings == 3, "one track"
    assert estimate.position_enu_m == (4.4, 30.0, 0.0), "that of its body"


def test_an_announced_person_is_given_with_the_time_at_which_it_was_last_seen_there() -> None:
    """A person who had walked on for 20 s was said to be seen at that moment at a place 5 m away."""
    tracker = TargetTracker(SETTINGS)
    for now_s, kind in ((2.0, FindingKind.PERSON), (6.0, FindingKind.PERSON), (26.0, FindingKind.ANIMAL)):
        tracker.observe(analysis(seen(4.4, 30.0)), now_s)
        place = Geolocation(np.array([4.4, 30.0, 0.0]), 0.04 * np.eye(3), np.zeros((3, 3)))
        tracker.judge({1: Judgement(Verdict(kind, 0.9, ()), place)})
        tracker.settle(1, FindingKind.PERSON)
    estimate = tracker.estimate()
    assert estimate is not None
    assert (estimate.sightings, estimate.seen_at_s) == (3, 6.0)


def test_a_walker_out_of_view_is_given_where_it_was_last_seen() -> None:
    """A walker's track went on for 9 m, and the person that it showed was announced once more there."""
    follower = Follower()
    for step in range(5):
        follower.observe(seen(2.0 * STEP_S * step, 0.0))
    before = follower.tracker.estimate()
    for _ in range(3):
        follower.observe()
    after = follower.tracker.estimate()
    assert before is not None
    assert after is not None
    assert math.hypot(*before.velocity_enu_mps) > 1.5
    assert after.position_enu_m == before.position_enu_m == pytest.approx((8.0 * STEP_S, 0.0, 0.0), abs=0.5)
    assert follower.tracker.places_enu_m()[1][0] > 18.0, "the track goes on"
