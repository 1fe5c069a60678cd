"""Windows along a recorded flight, and what is read of large photographs."""

from __future__ import annotations

import tracemalloc
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from aos_gcs.errors import ImagingError
from aos_gcs.examination.overview import overview_grid
from aos_gcs.examination.reduction import reduced
from aos_gcs.examination.search import Candidate, apart
from aos_gcs.examination.windows import ExaminedGround, FrameWindow, examined_ground, plan_windows
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.decision import FindingKind, Verdict

CAMERA = CameraModel.from_fov(64, 48, np.radians(60.0))


@dataclass(frozen=True)
class View:
    camera: CameraModel
    pose: Pose


def flight(count: int, spacing_m: float) -> list[View]:
    return [View(CAMERA, nadir_pose([spacing_m * index, 0.0, 30.0])) for index in range(count)]


@pytest.mark.parametrize("count", [1, 2, 3, 29, 30, 31, 47, 192])
@pytest.mark.parametrize("spacing_m", [0.5, 8.0, 500.0])
def test_windows_hold_every_frame_with_its_neighbour(count: int, spacing_m: float) -> None:
    windows = plan_windows(flight(count, spacing_m), 0.0)
    assert sorted({index for window in windows for index in window.frames}) == list(range(count))
    assert all(2 <= len(window.frames) <= 30 for window in windows) or count == 1
    assert all(one.first < other.first < one.end for one, other in pairwise(windows))


def test_frames_that_share_no_ground_are_not_in_one_window() -> None:
    # Footprints of 35 m: two of them hold eight places 10 m apart.
    assert max(len(window.frames) for window in plan_windows(flight(60, 10.0), 0.0)) == 7


def test_ground_that_several_windows_examine_counts_as_often() -> None:
    views = [*flight(4, 0.1), *flight(4, 0.1)]
    once, twice = (FrameWindow(0, 4),), (FrameWindow(0, 4), FrameWindow(4, 8))
    assert examined_ground(views, once, 0.0).windows_per_place == pytest.approx(1.0)
    assert examined_ground(views, twice, 0.0).windows_per_place == pytest.approx(2.0)
    # Elsewhere each has ground of its own, and what one frame alone sees is not examined.
    apart_views = [*flight(4, 0.1), *[View(CAMERA, nadir_pose([200.0 + 0.1 * index, 0.0, 30.0])) for index in range(4)]]
    assert examined_ground(apart_views, twice, 0.0).windows_per_place == pytest.approx(1.0)


def test_ground_in_one_frame_alone_is_not_examined() -> None:
    assert examined_ground(flight(1, 1.0), (FrameWindow(0, 1),), 0.0) == ExaminedGround(0.0, 1.0)
    # Footprints of 35 m: half of what three frames see is in two of them.
    views = flight(3, 17.3)
    assert examined_ground(views, plan_windows(views, 0.0), 0.0).share == pytest.approx(0.5, abs=0.05)
    views = flight(30, 300.0)
    assert examined_ground(views, plan_windows(views, 0.0), 0.0).share == 0.0


def test_a_map_of_half_a_country_is_refused_in_words_of_a_survey() -> None:
    views = [*flight(3, 5.0), View(CAMERA, nadir_pose([300e3, 0.0, 30.0]))]
    with pytest.raises(ImagingError, match=r"see ground over 300 km, .* a folder of its own"):
        overview_grid(views, 0.0)


def test_flights_far_apart_take_no_more_memory_than_near_ones() -> None:
    """Two sites 50 km apart, and a camera that sees to the horizon."""
    far = [View(CAMERA, nadir_pose([50e3 + 5.0 * index, 40e3, 30.0])) for index in range(6)]
    views = [*flight(6, 5.0), *far]
    windows = FrameWindow(0, 6), FrameWindow(6, 12)
    tracemalloc.start()
    both = examined_ground(views, windows, 0.0)
    high = [View(view.camera, nadir_pose([0.0, 0.0, 20e3])) for view in views]
    examined_ground(high, windows, 0.0)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert both.windows_per_place == 1.0
    assert both.share == pytest.approx(examined_ground(views[:6], windows[:1], 0.0).share, abs=0.02)
    assert most < 100e6


def candidate(east_m: float, significance: float, kind: FindingKind = FindingKind.ANOMALY) -> Candidate:
    return Candidate((east_m, 0.0, 0.0), Verdict(kind, None, ()), None, 5, significance)


def test_pieces_within_a_person_s_length_are_one_finding_the_most_significant_first() -> None:
    pieces = [candidate(0.0, 6.0), candidate(1.7, 9.0), candidate(9.0, 30.0), candidate(3.6, 7.0)]
    assert [one.significance for one in apart(pieces)] == [30.0, 9.0, 7.0]
    # A person beside a warm stone is the one to be looked for.
    pair = [candidate(0.0, 20.0, FindingKind.WARM_OBJECT), candidate(1.0, 6.0, FindingKind.PERSON)]
    assert [one.verdict.kind for one in apart(pair)] == [FindingKind.PERSON]


def test_a_large_frame_is_reduced_with_its_camera() -> None:
    camera = CameraModel(90, 61, 80.0, 81.0, 43.2, 31.1)
    pose = nadir_pose([1.0, 2.0, 30.0], 0.4)
    image = np.zeros((61, 90, 1), dtype=np.uint8)
    image[30:33, 45:48] = 90
    small = reduced(Frame(1, image, ("thermal",), pose, camera), 90 * 61 // 9)
    assert small.image.shape == (20, 30, 1)
    assert small.image[10, 15, 0] == 90
    assert small.image.dtype == np.uint8
    place_m = np.array([[3.0, 1.0, 0.0]])
    before, after = (project_points(place_m, one, pose)[0] for one in (camera, small.camera))
    assert (after + 0.5) * 3 == pytest.approx(before + 0.5)
    assert reduced(small) is small
