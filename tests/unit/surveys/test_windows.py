"""Windows along a recorded flight, and what is read of large photographs."""

from __future__ import annotations

import tracemalloc
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from aos_gcs.errors import ImagingError
from aos_gcs.examination.overview import overview_grid
from aos_gcs.examination.reduction import reduced
from aos_gcs.examination.search import Candidate, apart
from aos_gcs.examination.windows import ExaminedGround, FrameWindow, examined_ground, plan_windows, runs
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import Plane, project_points
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys.seen_ground import seen_ground, share_without_height

LEVEL = Plane(0.0)
CAMERA = CameraModel.from_fov(64, 48, np.radians(60.0))


@dataclass(frozen=True)
class View:
    camera: CameraModel
    pose: Pose


def flight(count: int, spacing_m: float, north_m: float = 0.0) -> list[View]:
    return [View(CAMERA, nadir_pose([spacing_m * index, north_m, 30.0])) for index in range(count)]


def window(first: int, end: int) -> FrameWindow:
    return FrameWindow(tuple(range(first, end)))


def examined(views: list[View], windows: Sequence[FrameWindow], surface: FocalSurface = LEVEL) -> ExaminedGround:
    return examined_ground(seen_ground(views, surface, 0.0), [one.frames for one in windows])


def former_windows(views: list[View]) -> list[tuple[int, int]]:
    """Return the windows that recorded surveys have: frames as they follow each other, first ones and ends."""
    reach_m, found, first = 2.0 * 60.0 / np.sqrt(3.0), [], 0
    while True:
        end = min(first + 30, len(views))
        for index in range(first + 1, end):
            if np.linalg.norm((views[index].pose.position_enu_m - views[first].pose.position_enu_m)[:2]) > reach_m:
                end = index
                break
        end = min(max(end, first + 2), len(views))
        found.append((first, end))
        if end == len(views):
            return found
        first = max(first + 1, min(first + round(2 / 3 * (end - first)), len(views) - 2))


def lanes(count: int, length: int, spacing_m: float, *, to_and_fro: bool) -> list[View]:
    """Return lanes 12 m apart, flown alternately or all eastwards."""
    return [
        view
        for lane in range(count)
        for view in flight(length, spacing_m, 12.0 * lane)[:: -1 if to_and_fro and lane % 2 else 1]
    ]


@pytest.mark.parametrize("count", [1, 2, 3, 29, 30, 31, 47, 192])
@pytest.mark.parametrize("spacing_m", [0.5, 8.0, 500.0])
def test_windows_hold_every_frame_with_its_neighbour(count: int, spacing_m: float) -> None:
    windows = plan_windows(flight(count, spacing_m), 0.0)
    assert sorted({index for window in windows for index in window.frames}) == list(range(count))
    assert all(2 <= len(window.frames) <= 30 for window in windows) or count == 1
    assert all(one.first < other.first <= one.last for one, other in pairwise(windows))


def test_frames_that_share_no_ground_are_not_in_one_window() -> None:
    # Footprints of 35 m: two of them hold eight places 10 m apart.
    assert max(len(window.frames) for window in plan_windows(flight(60, 10.0), 0.0)) == 7


@pytest.mark.parametrize(
    "views",
    [
        flight(100, 3.0),
        [*flight(20, 3.0), *flight(20, 3.0, 500.0), *flight(20, 3.0)],
        flight(40, 300.0),
        lanes(6, 25, 4.0, to_and_fro=True),
        lanes(6, 25, 9.0, to_and_fro=False),
        lanes(6, 40, 20.0, to_and_fro=False),
    ],
    ids=["line", "two places in turn", "no overlap", "lanes to and fro", "one-way lanes", "wide one-way lanes"],
)
def test_windows_of_one_drone_are_those_of_recorded_surveys(views: list[View]) -> None:
    windows = plan_windows(views, 0.0)
    assert [(one.first, one.last + 1) for one in windows] == former_windows(views)
    assert all(one.frames == tuple(range(one.first, one.last + 1)) for one in windows)


@pytest.mark.parametrize("apart_m", [60.0, 150.0])
@pytest.mark.parametrize("drones", [2, 5])
def test_drones_whose_pictures_alternate_have_the_windows_of_each(drones: int, apart_m: float) -> None:
    alone = [
        [
            View(CAMERA, nadir_pose(view.pose.position_enu_m + np.array([0.0, (30.0 + apart_m) * number, 0.0])))
            for view in lanes(3, 20, 4.0, to_and_fro=True)
        ]
        for number in range(drones)
    ]
    windows = plan_windows([view for together in zip(*alone, strict=True) for view in together], 0.0)
    for number, views in enumerate(alone):
        own = [one for one in windows if one.first % drones == number]
        assert [one.frames for one in own] == [
            tuple(drones * index + number for index in one.frames) for one in plan_windows(views, 0.0)
        ]


def test_a_drone_that_pauses_while_another_flies_is_continued_as_a_new_flight() -> None:
    """Pictures that are hours apart are in one folder, too; only those taken about the same time are one flight."""
    one, other = flight(20, 3.0), flight(80, 3.0, 500.0)
    views = [*one[:5], *other[:4], *one[5:10], *other[4:], *one[10:]]
    found = runs(views, 0.0)
    assert [len(run) for run in found] == [10, 80, 10]
    assert sorted(index for run in found for index in run) == list(range(100))


def test_drones_that_meet_share_windows() -> None:
    one = flight(30, 3.0)
    other = [View(CAMERA, nadir_pose([87.0 - 3.0 * index, 5.0, 30.0])) for index in range(30)]
    views = [view for pair in zip(one, other, strict=True) for view in pair]
    windows = plan_windows(views, 0.0)
    assert {index for found in windows for index in found.frames} == set(range(60))
    assert any({index % 2 for index in found.frames} == {0, 1} for found in windows)
    assert examined(views, windows).share > 0.95


def test_ground_that_several_windows_examine_counts_as_often() -> None:
    views = [*flight(4, 0.1), *flight(4, 0.1)]
    once, twice = (window(0, 4),), (window(0, 4), window(4, 8))
    assert examined(views, once).windows_per_place == pytest.approx(1.0)
    assert examined(views, twice).windows_per_place == pytest.approx(2.0)
    # Elsewhere each has ground of its own, and what one frame alone sees is not examined.
    apart_views = [*flight(4, 0.1), *[View(CAMERA, nadir_pose([200.0 + 0.1 * index, 0.0, 30.0])) for index in range(4)]]
    assert examined(apart_views, twice).windows_per_place == pytest.approx(1.0)


def test_ground_in_one_frame_alone_is_not_examined() -> None:
    assert examined(flight(1, 1.0), (window(0, 1),)) == ExaminedGround(0.0, 1.0)
    # Footprints of 35 m: half of what three frames see is in two of them.
    views = flight(3, 17.3)
    assert examined(views, plan_windows(views, 0.0)).share == pytest.approx(0.5, abs=0.05)
    views = flight(30, 300.0)
    assert examined(views, plan_windows(views, 0.0)).share == 0.0


def test_ground_without_a_height_is_not_examined() -> None:
    """Terrain that ends below the middle of the flight, or has a hole there."""
    views = flight(30, 3.0)
    windows = plan_windows(views, 0.0)
    whole = Terrain(-100.0, -100.0, 5.0, np.zeros((50, 70)))
    assert share_without_height(views, whole) == 0.0
    assert examined(views, windows, whole) == examined(views, windows)
    heights_m = np.zeros((50, 70))
    heights_m[:, 29:] = np.nan
    half = Terrain(-100.0, -100.0, 5.0, heights_m)
    # The flight sees from -17 to 104 m east; heights are known up to 40 m.
    assert share_without_height(views, half) == pytest.approx(64 / 121, abs=0.02)
    seen = seen_ground(views, half, 0.0)
    assert seen.known == pytest.approx(seen.total * 57 / 121, rel=0.03)
    # What has a height is examined as well as before.
    assert examined(views, windows, half).share == pytest.approx(1.0, abs=0.1)
    assert examined(views, [], half) == ExaminedGround(0.0, 1.0)


def test_frames_that_were_not_read_examine_nothing() -> None:
    views = flight(30, 3.0)
    seen = seen_ground(views, LEVEL, 0.0)
    assert examined_ground(seen, [range(30)]).share > 0.9
    # The first fifteen see -17 to 59 m, all of them -17 to 104 m east.
    assert examined_ground(seen, [range(15)]).share == pytest.approx(76 / 121, abs=0.05)
    assert examined_ground(seen, [[7], []]).share == 0.0


def test_a_map_of_half_a_country_is_refused_in_words_of_a_survey() -> None:
    views = [*flight(3, 5.0), View(CAMERA, nadir_pose([300e3, 0.0, 30.0]))]
    with pytest.raises(ImagingError, match=r"see ground over 300 km, .* a folder of its own"):
        overview_grid(views, 0.0)


def test_flights_far_apart_take_no_more_memory_than_near_ones() -> None:
    """Two sites 50 km apart, and a camera that sees to the horizon."""
    far = [View(CAMERA, nadir_pose([50e3 + 5.0 * index, 40e3, 30.0])) for index in range(6)]
    views = [*flight(6, 5.0), *far]
    windows = window(0, 6), window(6, 12)
    tracemalloc.start()
    both = examined(views, windows)
    high = [View(view.camera, nadir_pose([0.0, 0.0, 20e3])) for view in views]
    examined(high, windows)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert both.windows_per_place == 1.0
    assert both.share == pytest.approx(examined(views[:6], windows[:1]).share, abs=0.02)
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
