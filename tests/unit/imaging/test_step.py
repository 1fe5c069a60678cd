import dataclasses
import functools
import re
import tracemalloc

import cv2
import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError, ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.integral import BATCH_FRAMES
from aos_gcs.imaging.model import AnomalySource, Detector, Frame, LeaderCriterion
from aos_gcs.imaging.pictures import render_pictures, shade_step
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.examination import ExaminedFrame, examine
from aos_gcs.imaging.step.integration import integrate
from aos_gcs.imaging.step.settings import ImagingSettings

CAMERA = CameraModel.from_fov(128, 128, np.radians(50.0))
BANDS = ("red", "green", "blue", "thermal")
TARGET = (3.0, -2.0, 0.5)
SETTINGS = ImagingSettings(plane_height_m=0.5, rx_quantile=0.99)


def look(vehicle_id: int, pose: Pose, occluded: float = 0.0, target: bool = True, seed: int | None = None) -> Frame:
    """A frame of noise with a warm square of 1.5 m at the target, hidden in part."""
    rng = np.random.default_rng(vehicle_id if seed is None else seed)
    image = rng.normal(100.0, 3.0, (128, 128, 4)).astype(np.float32)
    if target:
        corners = np.array([[-0.75, -0.75, 0], [0.75, -0.75, 0], [0.75, 0.75, 0], [-0.75, 0.75, 0]]) + TARGET
        outline = np.round(project_points(corners, CAMERA, pose)).astype(np.int32)
        mask = np.zeros((128, 128), dtype=np.uint8)
        cv2.fillConvexPoly(mask, outline, 1)
        visible = (mask == 1) & (rng.random(mask.shape) >= occluded)
        image[visible, 3] += 80.0
    return Frame(vehicle_id, image, BANDS, pose, CAMERA)


def swarm(occluded: float = 0.0, target: bool = True) -> list[Frame]:
    return [look(10 + i, nadir_pose([2.0 * i - 4, 0.5 * i, 30 + i], 0.2 * i), occluded, target) for i in range(6)]


def test_the_target_is_found_where_it_is() -> None:
    analysis = analyse_step(swarm(occluded=0.6), SETTINGS)
    assert analysis.blob is not None
    np.testing.assert_allclose(analysis.blob.centroid_enu_m, TARGET, atol=0.25)
    assert 1.2 < analysis.visibility_m2 < 4.5
    assert [view.vehicle_id for view in analysis.sightings[0].views] == [10, 11, 12, 13, 14, 15]
    assert analysis.blob.max_count >= 3
    assert analysis.leader_id in analysis.vehicle_ids
    integral = integrate(swarm(occluded=0.6), analysis.grid)
    assert integral.mean.shape == (analysis.grid.rows, analysis.grid.columns, 4)
    np.testing.assert_array_equal(np.isnan(integral.mean[:, :, 0]), analysis.coverage == 0)
    np.testing.assert_array_equal(integral.coverage, analysis.coverage)
    assert analysis.coverage.max() == 6


def test_together_the_frames_see_more_than_any_of_them() -> None:
    frames = swarm(occluded=0.8)
    together = analyse_step(frames, SETTINGS).visibility_m2
    alone = [analyse_step([frame], SETTINGS).visibility_m2 for frame in frames]
    assert together > 1.5 * max(alone)


def test_an_empty_scene_has_no_blob_and_no_leader() -> None:
    analysis = analyse_step(swarm(target=False), SETTINGS)
    assert analysis.blob is None
    assert analysis.leader_id is None
    assert analysis.visibility_m2 == 0.0
    assert not analysis.fitness.any()


def test_contribution_favours_the_vehicle_that_sees_most_of_the_target() -> None:
    poses = [nadir_pose([x, -2.0, 30.0]) for x in (1.0, 3.0, 5.0)]
    frames = [look(i, pose, hidden) for i, pose, hidden in zip((1, 2, 3), poses, (0.9, 0.8, 0.1), strict=True)]
    analysis = analyse_step(frames, SETTINGS)
    assert analysis.leader_id == 3
    assert analysis.fitness[2] > 2 * analysis.fitness[1]
    assert analysis.fitness.max() <= analysis.visibility_m2


def test_the_masks_around_the_blob_are_those_of_each_vehicle() -> None:
    frames = [*swarm(occluded=0.4), look(99, nadir_pose([200.0, 0.0, 30.0]), target=False)]
    analysis = analyse_step(frames, SETTINGS)
    assert analysis.blob is not None
    assert analysis.masks is not None
    masks, grid = analysis.masks, analysis.grid
    assert masks.marked.shape[0] == len(analysis.vehicle_ids) == 7
    assert not masks.marked[6].any()
    # All of the blob lies in the window, so that its counts and each vehicle's share can be had from the masks.
    row = round((grid.north_m - masks.north_m) / grid.resolution_m)
    column = round((masks.west_m - grid.west_m) / grid.resolution_m)
    rows, columns = masks.marked.shape[1:]
    assert rows * grid.resolution_m == pytest.approx(8.0, abs=2 * grid.resolution_m)
    window = analysis.anomaly_count[row : row + rows, column : column + columns]
    np.testing.assert_array_equal(masks.marked.sum(axis=0), window)
    np.testing.assert_allclose(masks.marked.sum(axis=(1, 2)) * grid.resolution_m**2, analysis.fitness)


@pytest.mark.parametrize("target", [(-11.5, 0.0), (11.5, 11.5), (0.0, -11.5)])
def test_the_window_of_the_masks_ends_with_the_grid(target: tuple[float, float]) -> None:
    poses = [nadir_pose([0.0, 0.0, 30.0]), nadir_pose([0.5, 0.0, 30.0])]
    frames = [look(i, pose, target=False) for i, pose in enumerate(poses, 1)]
    for frame in frames:
        u, v = np.round(project_points([(*target, 0.5)], CAMERA, frame.pose)[0]).astype(int)
        frame.image[v - 2 : v + 3, u - 2 : u + 3, 3] += 80.0
    analysis = analyse_step(frames, SETTINGS)
    assert analysis.masks is not None
    masks, grid = analysis.masks, analysis.grid
    assert masks.west_m >= grid.west_m
    assert masks.north_m <= grid.north_m
    np.testing.assert_allclose(masks.marked.sum(axis=(1, 2)) * grid.resolution_m**2, analysis.fitness)
    assert (masks.marked.sum(axis=(1, 2)) >= 20).all()


def test_without_a_blob_there_are_no_masks() -> None:
    assert analyse_step(swarm(target=False), SETTINGS).masks is None


def test_integral_favours_the_lowest_vehicle_whatever_it_saw_itself() -> None:
    frames = [look(1, nadir_pose([3, -2, 40]), 0.0), look(2, nadir_pose([3, -2, 25]), 1.0)]
    settings = dataclasses.replace(SETTINGS, leader_criterion=LeaderCriterion.INTEGRAL)
    analysis = analyse_step(frames, settings)
    assert analysis.leader_id == 2
    gsd_m = 24.5 / CAMERA.fx_px
    assert analysis.fitness[1] == pytest.approx(analysis.visibility_m2 / gsd_m**2, rel=1e-3)


def test_equal_views_are_led_by_the_one_that_has_the_target_in_its_centre() -> None:
    settings = dataclasses.replace(SETTINGS, leader_criterion=LeaderCriterion.INTEGRAL)
    frames = [look(i, nadir_pose([x, -2.0, 30.0])) for i, x in ((1, -2.0), (2, 2.9), (3, 6.0))]
    analysis = analyse_step(frames, settings)
    np.testing.assert_allclose(analysis.fitness, analysis.fitness[0], rtol=1e-9)
    assert analysis.leader_id == 2


def test_frames_are_examined_once_for_all_planes() -> None:
    frames, looked_at = swarm(occluded=0.6), []

    @functools.cache
    def known(frame: Frame) -> ExaminedFrame:
        looked_at.append(frame)
        return examine(frame, SETTINGS)

    for plane_height_m in (0.5, 2.0):
        settings = dataclasses.replace(SETTINGS, plane_height_m=plane_height_m)
        with_known, anew = analyse_step(frames, settings, known=known), analyse_step(frames, settings)
        np.testing.assert_array_equal(with_known.anomaly_count, anew.anomaly_count)
        assert with_known.leader_id == anew.leader_id
    assert len(looked_at) == len(frames)
    assert set(looked_at) == set(frames)


def test_the_minimum_count_asks_for_agreement() -> None:
    frames = [look(1, nadir_pose([3, -2, 30])), look(2, nadir_pose([3, -2, 30]), target=False)]
    assert analyse_step(frames, SETTINGS).blob is not None
    assert analyse_step(frames, dataclasses.replace(SETTINGS, minimum_count=2)).blob is None


def test_the_last_frame_of_a_vehicle_stands_for_it() -> None:
    seen, blind = nadir_pose([3, -2, 30]), nadir_pose([200, 0, 30])
    analysis = analyse_step([look(1, seen), look(2, seen), look(1, blind, seed=9)], SETTINGS)
    assert analysis.vehicle_ids == (1, 2)
    assert analysis.fitness[0] == 0.0
    assert analysis.leader_id == 2
    assert analysis.blob is not None
    assert {view.vehicle_id for view in analysis.sightings[0].views} == {1, 2}


UP = Pose(np.array([3.0, -2.0, 30.0]), np.eye(3))
NOISE = np.random.default_rng(8).normal(100.0, 3.0, (128, 128, 4)).astype(np.float32)


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"pose": UP}, "does not see the focal plane"),
        ({"pose": Pose(np.array([3.0, np.nan, 30.0]), np.eye(3))}, "position is not known"),
        ({"pose": Pose(np.array([3.0, -2.0, 30.0]), np.full((3, 3), np.nan))}, "orientation is not known"),
        ({"pose": Pose(np.array([3.0, -2.0, 30.0]), np.diag([1.0, -1.0, -0.9]))}, "not a rotation"),
        ({"pose": Pose(np.array([3.0, -2.0, 30.0]), np.diag([1.0, 1.0, -1.0]))}, "not a rotation"),
        ({"camera": dataclasses.replace(CAMERA, fx_px=np.nan)}, "intrinsics are not known"),
        ({"camera": dataclasses.replace(CAMERA, fy_px=-1.0)}, "focal lengths are not positive"),
        ({"image": np.full((128, 128, 4), np.nan, dtype=np.float32)}, "no finite pixel"),
        ({"image": np.full((128, 128, 4), 255, dtype=np.uint8)}, r"the same everywhere \(255, 255, 255, 255\)"),
        ({"image": NOISE[:100]}, r"has shape \(100, 128, 4\)"),
        ({"image": NOISE[:, :, 0]}, r"has shape \(128, 128\)"),
    ],
)
@pytest.mark.parametrize("place", [0, 6])
def test_a_frame_that_cannot_be_used_is_skipped_with_its_reason(
    wrong: dict[str, object], reason: str, place: int
) -> None:
    frames = swarm(occluded=0.4)
    expected = analyse_step(frames, SETTINGS)
    bad = dataclasses.replace(look(99, nadir_pose([3.0, -2.0, 30.0]), target=False), **wrong)  # type: ignore[arg-type]
    analysis = analyse_step([*frames[:place], bad, *frames[place:]], SETTINGS)
    assert list(analysis.skipped) == [99]
    assert re.search(reason, analysis.skipped[99])
    assert analysis.vehicle_ids == expected.vehicle_ids
    np.testing.assert_array_equal(analysis.fitness, expected.fitness)
    np.testing.assert_array_equal(analysis.coverage, expected.coverage)
    with pytest.raises(ImagingError, match=f"No frame can be used .*vehicle 99.*{reason}"):
        analyse_step([bad, dataclasses.replace(bad, vehicle_id=98)], SETTINGS)


def test_the_bands_of_most_frames_are_those_of_the_step() -> None:
    frames = swarm()
    thermal = [dataclasses.replace(f, image=f.image[:, :, 3:], bands=("thermal",)) for f in frames[:2]]
    analysis = analyse_step([*thermal, *frames[2:]], SETTINGS)
    assert sorted(analysis.skipped) == [10, 11]
    assert "has the bands thermal" in analysis.skipped[10]
    assert analysis.vehicle_ids == (12, 13, 14, 15)


def test_frames_of_other_sizes_and_depths_are_used_together() -> None:
    frames = swarm()
    coarse = CameraModel.from_fov(64, 64, np.radians(50.0))
    image = frames[0].image.reshape(64, 2, 64, 2, 4).mean(axis=(1, 3), dtype=np.float32)
    whole = dataclasses.replace(frames[0], image=image.round().astype(np.uint16), camera=coarse)
    bytes_only = [dataclasses.replace(f, image=f.image.round().clip(0, 255).astype(np.uint8)) for f in frames[1:]]
    mixed = [whole, *bytes_only]
    analysis = analyse_step(mixed, SETTINGS)
    assert not analysis.skipped
    assert analysis.blob is not None
    np.testing.assert_allclose(analysis.blob.centroid_enu_m, TARGET, atol=0.25)
    assert [view.vehicle_id for view in analysis.sightings[0].views] == [f.vehicle_id for f in frames]


@pytest.mark.parametrize("source", AnomalySource)
@pytest.mark.parametrize("detector", Detector)
def test_every_detector_finds_the_target_in_frames_and_in_their_integral(
    detector: Detector, source: AnomalySource
) -> None:
    settings = dataclasses.replace(SETTINGS, detector=detector, anomaly_source=source)
    analysis = analyse_step(swarm(occluded=0.5), settings)
    assert analysis.blob is not None
    np.testing.assert_allclose(analysis.blob.centroid_enu_m, TARGET, atol=0.25)
    assert (analysis.fitness > 0.0).all()
    assert analyse_step(swarm(target=False), settings).blob is None


def test_in_the_integral_a_frame_marks_what_it_covers() -> None:
    frames = [*swarm(occluded=0.5), look(99, nadir_pose([18.0, -2.0, 30.0]), target=False)]
    settings = dataclasses.replace(SETTINGS, anomaly_source=AnomalySource.INTEGRAL)
    analysis = analyse_step(frames, settings)
    assert analysis.blob is not None
    assert analysis.masks is not None
    np.testing.assert_allclose(analysis.fitness, [*[analysis.visibility_m2] * 6, 0.0])
    marked = analysis.anomaly_count > 0
    np.testing.assert_array_equal(analysis.anomaly_count[marked], analysis.coverage[marked])
    asked = dataclasses.replace(settings, minimum_count=7)
    assert analyse_step(frames, asked).blob is None


def test_the_thermal_detector_needs_a_thermal_band() -> None:
    frames = [dataclasses.replace(f, image=f.image[:, :, :3], bands=BANDS[:3]) for f in swarm()]
    with pytest.raises(ImagingError, match=r"red, green, blue: choose another imaging\.detector"):
        analyse_step(frames, dataclasses.replace(SETTINGS, detector=Detector.THERMAL))


def test_memory_does_not_grow_with_the_number_of_frames() -> None:
    frame = look(1, nadir_pose([3.0, -2.0, 30.0]))
    in_bytes = dataclasses.replace(frame, image=frame.image.clip(0, 255).astype(np.uint8))

    def peak_bytes(count: int) -> int:
        tracemalloc.start()
        try:
            frames = [dataclasses.replace(in_bytes, vehicle_id=i + 1) for i in range(count)]
            integrate(frames, analyse_step(frames, SETTINGS).grid)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak_bytes(BATCH_FRAMES)
    assert peak_bytes(64) - peak_bytes(2 * BATCH_FRAMES) < 4 * frame.image.nbytes


def test_the_analysis_is_deterministic() -> None:
    frames = swarm(occluded=0.5)
    one, other = analyse_step(frames, SETTINGS), analyse_step(frames, SETTINGS)
    np.testing.assert_array_equal(one.anomaly_count, other.anomaly_count)
    np.testing.assert_array_equal(one.fitness, other.fitness)
    assert one.blob == other.blob


def test_a_plane_above_the_cameras_and_no_frames_are_refused() -> None:
    with pytest.raises(ImagingError, match="below the cameras"):
        analyse_step(swarm(), dataclasses.replace(SETTINGS, plane_height_m=100.0))
    with pytest.raises(ImagingError, match="no frame"):
        analyse_step([], SETTINGS)


@pytest.mark.parametrize(
    "wrong",
    [
        {"rx_quantile": 1.0},
        {"rx_min_score": -1.0},
        {"minimum_count": 0},
        {"gap_cells": -1},
        {"resolution_m": 0.0},
        {"max_cells": 1},
        {"plane_height_m": float("nan")},
    ],
)
def test_settings_out_of_range_are_refused_by_name(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        ImagingSettings(**wrong)  # type: ignore[arg-type]


def decode(png: bytes) -> np.ndarray:
    return cv2.cvtColor(cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED), cv2.COLOR_BGRA2RGBA)


def test_pictures_show_bands_marks_and_what_is_uncovered() -> None:
    analysis = analyse_step(swarm(), SETTINGS)
    pictures = {picture.kind: picture for picture in render_pictures(swarm(), analysis)}
    assert set(pictures) == {"integral", "thermal", "anomaly"}
    east_m = analysis.grid.west_m + analysis.grid.columns * analysis.grid.resolution_m
    for picture in pictures.values():
        rgba = decode(picture.png)
        assert rgba.shape == (*analysis.coverage.shape, 4)
        np.testing.assert_array_equal(rgba[:, :, 3], np.where(analysis.coverage > 0, 255, 0))
        assert (picture.west_m, picture.north_m) == (analysis.grid.west_m, analysis.grid.north_m)
        assert picture.east_m == pytest.approx(east_m)
        assert picture.south_m < picture.north_m
    anomaly = decode(pictures["anomaly"].png)[:, :, :3].max(axis=2)
    covered = analysis.coverage > 0
    assert (anomaly[covered & (analysis.anomaly_count > 0)] > 100).all()
    assert (anomaly[covered & (analysis.anomaly_count == 0)] < 10).all()
    thermal = decode(pictures["thermal"].png)[:, :, :3].sum(axis=2)
    assert thermal[analysis.anomaly_count >= 5].mean() > 1.3 * thermal[covered].mean()


def test_a_thermal_swarm_has_a_grey_integral() -> None:
    frames = [dataclasses.replace(f, image=f.image[:, :, 3:], bands=("thermal",)) for f in swarm()]
    integral, thermal, _ = render_pictures(frames, analyse_step(frames, SETTINGS))
    grey = decode(integral.png)
    np.testing.assert_array_equal(grey[:, :, 0], grey[:, :, 2])
    assert thermal.kind == "thermal"


def test_colours_of_the_integral_are_those_of_the_bands() -> None:
    image = np.zeros((128, 128, 3), dtype=np.uint8)
    image[:64, :, 0] = 200
    image[64:, :, 2] = 200
    frame = Frame(1, image, ("red", "green", "blue"), nadir_pose([0, 0, 30]), CAMERA)
    rgba = decode(render_pictures([frame], analyse_step([frame], SETTINGS))[0].png)
    assert tuple(rgba[30, 64]) == (255, 0, 0, 255)
    assert tuple(rgba[-30, 64]) == (0, 0, 255, 255)


def test_a_large_raster_gives_a_smaller_picture_that_keeps_single_marks() -> None:
    frame = look(1, nadir_pose([0, 0, 30]), target=False)
    analysis = analyse_step([frame], dataclasses.replace(SETTINGS, resolution_m=0.02))
    count = np.zeros_like(analysis.anomaly_count)
    count[777, 555] = 1
    anomaly = render_pictures([frame], dataclasses.replace(analysis, anomaly_count=count))[-1]
    rgba = decode(anomaly.png)
    assert rgba.shape[0] * rgba.shape[1] <= 260_000
    assert rgba[:, :, :3].max() > 100


def test_noisy_edges_do_not_hide_a_warm_spot() -> None:
    rng = np.random.default_rng(5)
    analysis = analyse_step([look(1, nadir_pose([0, 0, 30]), target=False)], SETTINGS)
    shape = analysis.coverage.shape
    coverage = np.full(shape, 10, dtype=np.uint16)
    coverage[:, :30] = 1
    thermal = rng.normal(12.0, np.where(coverage > 1, 0.2, 10.0)).astype(np.float32)
    spot = np.zeros(shape, dtype=bool)
    spot[60:64, 80:84] = True
    thermal[spot] = 16.0
    covered = dataclasses.replace(analysis, coverage=coverage)
    picture = shade_step(covered, thermal[:, :, np.newaxis], ("thermal",), ["thermal"])["thermal"]
    brightness = picture[:, :, :3].astype(int).sum(axis=2)
    assert brightness[spot].min() > 2 * brightness[(coverage > 1) & ~spot].max()


def test_a_reduced_picture_averages_and_keeps_uncovered_cells_out() -> None:
    analysis = analyse_step([look(1, nadir_pose([0, 0, 30]), target=False)], SETTINGS)
    rows, columns = 1200, 1000
    checked = np.indices((rows, columns)).sum(axis=0) % 2 * 100.0
    checked[:100], checked[-100:] = 0.0, 100.0  # even areas that set the contrast
    integral = np.where(np.arange(columns) < 400, np.nan, checked).astype(np.float32)[:, :, np.newaxis]
    coverage = np.where(np.isnan(integral[:, :, 0]), 0, 1).astype(np.uint16)
    empty = np.zeros((rows, columns), dtype=np.uint16)
    replaced = dataclasses.replace(analysis, coverage=coverage, anomaly_count=empty)
    rgba = shade_step(replaced, integral, ("grey",), ["integral"])["integral"]
    height, width = rgba.shape[:2]
    assert height * width < rows * columns
    assert (rgba[:, : int(0.39 * width), 3] == 0).all()
    assert (rgba[:, int(0.41 * width) :, 3] == 255).all()
    inner = rgba[height // 4 : -height // 4, int(0.45 * width) : -5, 0].astype(float)
    assert inner.std() < 90.0  # 127 for the pattern itself
