"""From sightings to the decision that a target is found."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.imaging.model import Blob, FocalGrid, StepAnalysis
from aos_gcs.mission.settings import DetectionSettings
from aos_gcs.mission.targeting import TargetTracker

SETTINGS = DetectionSettings(threshold_m2=0.1, found_steps=3, found_radius_m=1.0, found_min_count=3)


def seen(east_m: float, north_m: float, area_m2: float = 0.2, count: int = 3) -> StepAnalysis:
    return analysis(Blob(area_m2, (east_m, north_m, 0.0), count, (1, 2)))


def analysis(blob: Blob | None) -> StepAnalysis:
    return StepAnalysis(
        grid=FocalGrid(0.0, 1.0, 0.5, 2, 2, 0.0),
        integral=np.zeros((2, 2, 3), np.float32),
        coverage=np.ones((2, 2), np.uint16),
        anomaly_count=np.zeros((2, 2), np.uint16),
        blob=blob,
        vehicle_ids=(1, 2),
        fitness=np.zeros(2),
        leader_id=1,
    )


def test_nothing_and_small_blobs_are_out_of_view() -> None:
    tracker = TargetTracker(SETTINGS)
    assert not tracker.observe(analysis(None))
    assert not tracker.observe(seen(0, 0, area_m2=0.099))
    assert tracker.steps_out_of_view == 2
    assert tracker.estimate() is None
    assert tracker.observe(seen(0, 0, area_m2=0.1))
    assert (tracker.steps_in_view, tracker.steps_out_of_view) == (1, 0)


def test_found_after_agreeing_steps_in_a_row() -> None:
    tracker = TargetTracker(SETTINGS)
    verdicts = []
    for offset_m in (0.0, 0.4, -0.4):
        tracker.observe(seen(5.0 + offset_m, 20.0))
        verdicts.append(tracker.is_found())
    assert verdicts == [False, False, True]


def test_a_gap_starts_the_count_again_but_keeps_the_estimate() -> None:
    tracker = TargetTracker(SETTINGS)
    for _ in range(2):
        tracker.observe(seen(5.0, 20.0))
    tracker.observe(analysis(None))
    tracker.observe(seen(5.0, 20.0))
    assert not tracker.is_found()
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.sightings == 3


def test_a_blob_marked_by_too_few_frames_is_no_confirmation() -> None:
    tracker = TargetTracker(SETTINGS)
    for count in (3, 2, 3):
        tracker.observe(seen(5.0, 20.0, count=count))
    assert not tracker.is_found()
    for _ in range(2):
        tracker.observe(seen(5.0, 20.0))
    assert tracker.is_found()


def test_sightings_that_wander_apart_are_not_found() -> None:
    tracker = TargetTracker(SETTINGS)
    for east_m in (0.0, 1.9, 2.8):
        tracker.observe(seen(east_m, 0.0))
    assert tracker.steps_in_view == 3
    assert not tracker.is_found()


def test_a_jump_is_another_object() -> None:
    tracker = TargetTracker(SETTINGS)
    for _ in range(3):
        tracker.observe(seen(0.0, 0.0))
    tracker.observe(seen(10.0, 0.0))
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.position_enu_m == (10.0, 0.0, 0.0)
    assert estimate.sightings == 1
    assert not tracker.is_found()


def test_the_estimate_weighs_by_area_and_gets_an_error_from_three_sightings_on() -> None:
    tracker = TargetTracker(SETTINGS)
    tracker.observe(seen(0.0, 0.0, area_m2=0.3))
    tracker.observe(seen(1.0, 0.0, area_m2=0.1))
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.position_enu_m == pytest.approx((0.25, 0.0, 0.0))
    assert estimate.sigma_m is None
    tracker.observe(seen(0.25, 0.0, area_m2=0.2))
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.sigma_m is not None
    assert 0.0 < estimate.sigma_m < 0.5


@given(st.lists(st.floats(-0.4, 0.4), min_size=13, max_size=40))
def test_the_estimate_follows_the_latest_sightings_only(offsets_m: list[float]) -> None:
    tracker = TargetTracker(SETTINGS)
    for offset_m in offsets_m:
        tracker.observe(seen(offset_m, 0.0))
    estimate = tracker.estimate()
    assert estimate is not None
    assert estimate.sightings == 12
    assert estimate.position_enu_m[0] == pytest.approx(np.mean(offsets_m[-12:]), abs=1e-9)
    assert estimate.sigma_m is not None
    assert estimate.sigma_m <= 0.4
