"""Judgement of marks that are laid out by hand, with values that can be counted."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.detection.marks import NO_MARKS, Marks
from aos_gcs.imaging.model import FocalGrid, Frame, KnownPlaces
from aos_gcs.imaging.step.agreement import agreeing_frames
from aos_gcs.imaging.step.blobs import BlobCells
from aos_gcs.imaging.step.judgement import judge
from aos_gcs.imaging.step.marking import MarkedFrame
from aos_gcs.imaging.step.settings import ImagingSettings

CAMERA = CameraModel.from_fov(64, 64, math.radians(50.0))
GRID = FocalGrid(west_m=-10.0, north_m=10.0, resolution_m=0.5, rows=40, columns=40, height_m=0.0)
SETTINGS = ImagingSettings(gap_cells=0, agreeing_frames=1)


def marked(vehicle_id: int, *cells: tuple[int, int], east_m: float = 0.0) -> MarkedFrame:
    image = np.zeros((64, 64, 1), dtype=np.float32)
    frame = Frame(vehicle_id, image, ("grey",), nadir_pose([east_m, 0.0, 30.0]), CAMERA)
    return MarkedFrame(frame, Marks(*np.array(cells, dtype=np.intp).T) if cells else NO_MARKS)


def test_counts_areas_and_leader_are_those_that_can_be_counted() -> None:
    frames = [marked(1, (20, 20), (20, 21)), marked(2, (20, 21), (21, 21), (21, 20)), marked(3, (5, 5))]
    judgement = judge(frames, GRID, (), SETTINGS)
    assert judgement.anomaly_count.sum() == 6
    assert judgement.anomaly_count[20, 21] == 2
    large, small = judgement.sightings
    assert (large.blob.area_m2, small.blob.area_m2) == (4 * 0.25, 0.25)
    assert large.blob.centroid_enu_m == pytest.approx((0.25 + 0.5 * 3 / 5, -0.25 - 0.5 * 2 / 5, 0.0))
    assert [view.vehicle_id for view in large.views] == [1, 2]
    assert judgement.vehicle_ids == (1, 2, 3)
    assert judgement.fitness.tolist() == [0.5, 0.75, 0.0]
    assert judgement.leader_id == 2
    assert judgement.present_m2 == 1.0
    assert judgement.masks is not None
    assert judgement.masks.marked.sum(axis=(1, 2)).tolist() == [2, 3, 0]


def test_blobs_on_which_too_few_frames_agree_are_left_out() -> None:
    # Marks of two frames lie a cell of 0.5 m apart, and another place is marked by one of them.
    frames = [marked(1, (20, 20), (5, 5)), marked(2, (20, 20)), marked(3)]
    (blob,) = [one.blob for one in judge(frames, GRID, (), ImagingSettings(gap_cells=0)).sightings]
    assert blob.centroid_enu_m == pytest.approx((0.25, -0.25, 0.0))
    assert blob.max_count == 2
    assert judge(frames, GRID, (), ImagingSettings(gap_cells=0, agreeing_frames=3)).sightings == ()
    # Of several bands, one clear view is enough; and no more frames have to agree than see the place.
    colour = [
        dataclasses.replace(one, frame=dataclasses.replace(one.frame, bands=("red", "green", "blue"))) for one in frames
    ]
    assert len(judge(colour, GRID, (), ImagingSettings(gap_cells=0)).sightings) == 2
    coverage = np.full((40, 40), 3, dtype=np.uint16)
    coverage[:10] = 1
    assert len(judge(frames, GRID, (), ImagingSettings(gap_cells=0), coverage=coverage).sightings) == 2


def test_frames_agree_within_the_half_width_of_a_body() -> None:
    fine = dataclasses.replace(GRID, resolution_m=0.05)
    blob = BlobCells(np.array([20]), np.array([10]), np.array([1], dtype=np.uint16))
    for apart, expected in ((0, 2), (5, 2), (6, 1), (15, 1)):
        frames = [marked(1, (20, 10)), marked(2, (20, 10 + apart)), marked(3, (35, 35))]
        assert agreeing_frames(blob, fine, frames) == expected


def test_equal_shares_are_led_by_the_vehicle_above_the_blob() -> None:
    cells = (20, 20), (20, 21)
    judgement = judge([marked(1, *cells, east_m=6.0), marked(2, *cells, east_m=0.5)], GRID, (), SETTINGS)
    assert judgement.fitness.tolist() == [0.5, 0.5]
    assert judgement.leader_id == 2


def test_earlier_views_enlarge_a_blob_and_make_none() -> None:
    first = judge([marked(1, (20, 20), (20, 21), (20, 22))], GRID, (), SETTINGS)
    assert len(first.history) == 1
    second = judge([marked(2, (20, 22), (20, 23))], GRID, first.history, SETTINGS)
    assert second.sightings[0].blob.area_m2 == 4 * 0.25
    assert second.present_m2 == 2 * 0.25
    assert second.vehicle_ids == (2,)
    assert second.fitness.tolist() == [0.5]
    elsewhere = judge([marked(2)], GRID, first.history, SETTINGS)
    assert elsewhere.anomaly_count.sum() == 3
    assert elsewhere.sightings == ()
    assert elsewhere.leader_id is None
    assert elsewhere.history == first.history


def test_agreement_is_asked_of_cells_not_of_blobs() -> None:
    frames = [marked(1, (20, 20), (20, 21)), marked(2, (20, 21), (20, 22))]
    judgement = judge(frames, GRID, (), dataclasses.replace(SETTINGS, minimum_count=2))
    assert judgement.sightings[0].blob.area_m2 == 0.25
    assert judge(frames[:1], GRID, (), dataclasses.replace(SETTINGS, minimum_count=2)).sightings == ()


@pytest.mark.parametrize(("vehicles", "settled"), [(2, True), (3, False)])
def test_what_few_vehicles_mark_is_settled_farther_from_its_place(vehicles: int, settled: bool) -> None:
    """A stone drew a swarm back again and again: one or two vehicles at a time placed it 2.5 m beside itself."""
    frames = [marked(vehicle_id, (20, 20), (20, 21)) for vehicle_id in range(1, vehicles + 1)]
    (sighting,) = judge(frames, GRID, (), SETTINGS).sightings
    east_m, north_m, _ = sighting.blob.centroid_enu_m
    (again,) = judge(frames, GRID, (), SETTINGS, KnownPlaces(((east_m + 2.5, north_m),))).sightings
    assert again.settled is settled


def test_pieces_at_a_suspected_place_are_one_blob_that_comes_before_larger_ones() -> None:
    """Five vehicles saw a person in pieces, none of which was large enough to draw the swarm."""
    pieces = [marked(1, (20, 20)), marked(2, (20, 22)), marked(3, (22, 20), (5, 5), (5, 6), (6, 5), (6, 6))]
    assert [one.blob.area_m2 for one in judge(pieces, GRID, (), SETTINGS).sightings] == [1.0, 0.25, 0.25, 0.25]
    suspected = KnownPlaces(suspected_enu_m=((0.5, -0.5),))
    judgement = judge(pieces, GRID, (), SETTINGS, suspected)
    person, other = judgement.sightings
    assert (person.blob.area_m2, person.suspected) == (0.75, True)
    assert [view.vehicle_id for view in person.views] == [1, 2, 3]
    assert (other.blob.area_m2, other.suspected) == (1.0, False)
    assert judgement.blob == person.blob
    assert judgement.fitness.tolist() == [0.25, 0.25, 0.25]
    settled = judge(pieces, GRID, (), SETTINGS, dataclasses.replace(suspected, settled_enu_m=((0.5, -0.5),)))
    assert [one.settled for one in settled.sightings] == [False, True]


def test_one_frame_is_enough_for_a_blob_at_a_suspected_place() -> None:
    frames = [marked(1, (20, 20), (5, 5)), marked(2), marked(3)]
    asking = ImagingSettings(gap_cells=0, agreeing_frames=2)
    assert judge(frames, GRID, (), asking).sightings == ()
    (sighting,) = judge(frames, GRID, (), asking, KnownPlaces(suspected_enu_m=((0.5, -0.5),))).sightings
    assert sighting.blob.centroid_enu_m == pytest.approx((0.25, -0.25, 0.0))
