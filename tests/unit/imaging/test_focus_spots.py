"""Spots at known places, each hidden in most frames, and where their rays meet."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.focus import autofocus
from aos_gcs.imaging.focus import region as focus_region
from aos_gcs.imaging.focus import spots as focus_spots
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.ground import ground_layer, is_among_crowns, is_seen_through
from aos_gcs.imaging.focus.region import GroundRegion
from aos_gcs.imaging.focus.spots import Spots, detect_spots, find_spots
from aos_gcs.imaging.model import Frame, Pixels

CAMERA = CameraModel.from_fov(240, 240, np.radians(50.0))
POSES = [nadir_pose([1.2 * i - 10.8, 1.5 * np.sin(i / 3.0), 35.0]) for i in range(19)]
BOUNDS_M = (-14.0, -10.0, 14.0, 10.0)
HEIGHTS_M = np.arange(-5.0, 20.1, 0.5)
FLIPPED = np.diag([1.0, -1.0, -1.0])


def flight(places_m: ArrayLike, seen: float, *, shaken: bool = False) -> list[Frame]:
    """Frames of noise with spots, each of which a frame sees with some probability; shaken ones see them anywhere."""
    rng = np.random.default_rng(0)
    u, v = np.arange(CAMERA.width_px), np.arange(CAMERA.height_px)
    frames = []
    for index, pose in enumerate(POSES):
        image = rng.normal(100.0, 1.0, (CAMERA.height_px, CAMERA.width_px))
        pixels = project_points(places_m, CAMERA, pose)
        for u_px, v_px in rng.uniform(0.0, CAMERA.width_px, pixels.shape) if shaken else pixels:
            if rng.random() < seen:
                image += 30.0 * np.outer(np.exp(-((v - v_px) ** 2) / 4.5), np.exp(-((u - u_px) ** 2) / 4.5))
        frames.append(Frame(index, image.astype(np.float32)[:, :, np.newaxis], ("grey",), pose, CAMERA))
    return frames


def scattered(count: int, low_m: float, high_m: float, seed: int) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    return np.column_stack(
        (rng.uniform(-11.0, 11.0, count), rng.uniform(-7.0, 7.0, count), rng.uniform(low_m, high_m, count))
    )


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tenth of the points to compare textures on: spots need none."""
    monkeypatch.setattr(focus_region, "MAX_POINTS", 1_000)


GROUND_M, CROWNS_M = scattered(8, 0.0, 0.0, 1), scattered(25, 8.0, 14.0, 2)


def test_rays_meet_where_the_spots_are() -> None:
    (spots,) = find_spots(flight(GROUND_M, 0.6), BOUNDS_M, HEIGHTS_M)
    assert len(spots.points_m) >= len(GROUND_M)
    assert spots.up == 1.0
    for place_m in GROUND_M:
        nearest = int(np.linalg.norm(spots.points_m - place_m, axis=1).argmin())
        np.testing.assert_allclose(spots.points_m[nearest], place_m, atol=0.3)
        assert abs(spots.points_m[nearest, 2] - place_m[2]) < 3.0 * spots.sigmas_m[nearest]


def test_what_meets_by_chance_makes_no_layer() -> None:
    (spots,) = find_spots(flight(scattered(30, 0.0, 14.0, 3), 0.8, shaken=True), BOUNDS_M, HEIGHTS_M)
    assert np.all(spots.significances < 9.0)
    assert ground_layer(spots, np.zeros(2)) is None


def test_the_thermal_band_is_looked_at_apart_from_the_others() -> None:
    frames = flight(GROUND_M, 0.6)
    noise = np.random.default_rng(4).normal(100.0, 30.0, frames[0].image.shape).astype(np.float32)
    both = [
        Frame(index, np.concatenate((noise, frame.image), axis=2), ("red", "thermal"), frame.pose, CAMERA)
        for index, frame in enumerate(frames)
    ]
    thermal, others = find_spots(both, BOUNDS_M, HEIGHTS_M)
    (alone,) = find_spots(frames, BOUNDS_M, HEIGHTS_M)
    np.testing.assert_array_equal(thermal.points_m, alone.points_m)
    assert ground_layer(others, np.zeros(2)) is None


def test_finer_frames_show_the_same_things() -> None:
    (coarse, *_) = flight(GROUND_M, 1.0)
    image = coarse.image[:, :, 0]
    spots = detect_spots(image)
    finer = detect_spots(np.kron(image, np.ones((4, 4), dtype=np.float32)), reduction=4)
    assert len(spots) == 5
    np.testing.assert_allclose(finer, (spots + 0.5) * 4.0 - 0.5, atol=1e-6)


@pytest.mark.parametrize(("sampling_m", "reduction"), [(0.2, 1), (0.064, 1), (0.035, 2), (0.01, 7)])
def test_fine_frames_are_reduced_to_the_size_of_things(
    sampling_m: float, reduction: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    reductions: list[int] = []

    def detect(image: Pixels, reduction: int) -> NDArray[np.float64]:
        del image
        reductions.append(reduction)
        return np.empty((0, 2))

    monkeypatch.setattr(focus_spots, "detect_spots", detect)
    (frame, *_) = flight(GROUND_M, 1.0)
    (spots,) = find_spots([frame], BOUNDS_M, HEIGHTS_M, sampling_m)
    assert len(spots.points_m) == 0
    assert reductions == [reduction]


def test_images_without_values_have_no_spots() -> None:
    assert detect_spots(np.full((240, 240), np.nan, dtype=np.float32)).shape == (0, 2)


@pytest.mark.usefixtures("few_points")
def test_autofocus_finds_the_ground_below_crowns_that_stand_out_more() -> None:
    frames = flight(np.vstack((GROUND_M, CROWNS_M)), 0.7)
    result = find_focus(frames, GroundRegion(*BOUNDS_M), -5.0, 20.0)
    assert result.found, result.reason
    assert abs(result.height_m) < min(1.0, 3.0 * result.sigma_m)


@pytest.mark.usefixtures("few_points")
def test_autofocus_knows_that_crowns_are_not_the_ground() -> None:
    assert not find_focus(flight(CROWNS_M, 0.7), GroundRegion(*BOUNDS_M), -5.0, 20.0).found


def layered(*layers: tuple[int, float, float], up: float = 1.0) -> Spots:
    """Spots of layers: number, lowest and highest height."""
    points_m = np.vstack([scattered(count, low_m, high_m, 7) for count, low_m, high_m in layers])
    points_m[:, 2] *= up
    return Spots(points_m, np.full(len(points_m), 12.0), np.full(len(points_m), 0.2), up)


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_the_lowest_layer_is_the_ground_whichever_way_z_points(up: float) -> None:
    layer = ground_layer(layered((6, 0.0, 0.0), (30, 8.0, 14.0), up=up), np.zeros(2))
    assert layer is not None
    assert layer.height_m == pytest.approx(0.0, abs=0.2)
    assert 0.3 < layer.sigma_m < 1.0
    assert layer.significance == pytest.approx(72.0)


@pytest.mark.parametrize(
    "spots",
    [
        pytest.param(layered((30, 8.0, 14.0)), id="crowns alone"),
        pytest.param(layered((2, 0.0, 0.0), (30, 8.0, 14.0)), id="too few on the ground"),
        pytest.param(layered((6, 0.0, 0.0), (6, 3.0, 4.0)), id="bushes above it"),
        pytest.param(layered((12, -1.9, 1.9)), id="too thick"),
        pytest.param(Spots(np.empty((0, 3)), np.empty(0), np.empty(0), 1.0), id="nothing"),
    ],
)
def test_other_layers_are_not_the_ground(spots: Spots) -> None:
    assert ground_layer(spots, np.zeros(2)) is None


def test_ground_far_from_the_centre_does_not_tell_the_height_there() -> None:
    spots = layered((6, 0.0, 0.0))
    assert ground_layer(spots, np.zeros(2)) is not None
    assert ground_layer(spots, np.array([60.0, 0.0])) is None


@pytest.mark.parametrize(("height_m", "crowns"), [(0.0, False), (11.0, True), (13.0, True)])
def test_heights_among_crowns_are_told_from_the_ground(height_m: float, *, crowns: bool) -> None:
    assert is_among_crowns(layered((8, 0.0, 0.0), (30, 8.0, 14.0)), height_m) is crowns


@pytest.mark.parametrize("up", [1.0, -1.0])
@pytest.mark.parametrize(
    ("spots", "height_m", "through"),
    [
        pytest.param((2, 0.0, 0.0), 12.0, True, id="two below crowns"),
        pytest.param((1, 0.0, 0.0), 12.0, False, id="one may be chance"),
        pytest.param((8, 0.0, 0.0), 0.0, False, id="the ground itself"),
        pytest.param((8, 9.0, 14.0), 0.0, False, id="crowns above it"),
    ],
)
def test_there_is_nothing_below_the_ground(
    spots: tuple[int, float, float], height_m: float, *, through: bool, up: float
) -> None:
    assert is_seen_through(layered(spots, up=up), up * height_m, np.zeros(2)) is through


@pytest.mark.usefixtures("few_points")
def test_autofocus_does_not_take_for_ground_what_it_sees_through(monkeypatch: pytest.MonkeyPatch) -> None:
    frames = flight(scattered(40, 12.0, 12.0, 5), 0.7)
    below: list[Spots] = []
    monkeypatch.setattr(autofocus, "find_spots", lambda *_: below)
    assert find_focus(frames, GroundRegion(*BOUNDS_M), 8.0, 16.0).found
    below.append(layered((2, 0.0, 0.0)))
    result = find_focus(frames, GroundRegion(*BOUNDS_M), 8.0, 16.0)
    assert not result.found
    assert "objects are visible far below" in result.reason


def test_ground_that_falls_is_not_seen_through() -> None:
    points_m = scattered(20, 0.0, 0.0, 7)
    points_m[:, 2] = 0.55 * points_m[:, 0]
    slope = Spots(points_m, np.full(20, 12.0), np.full(20, 0.2), 1.0)
    assert not is_seen_through(slope, 0.0, np.zeros(2))


@pytest.mark.parametrize("poor", [{"significances": 8.0}, {"sigmas_m": 2.0}])
def test_spots_by_chance_and_spots_of_unknown_height_are_not_seen_through_it(poor: dict[str, float]) -> None:
    spots = replace(layered((8, 0.0, 0.0)), **{name: np.full(8, value) for name, value in poor.items()})
    assert not is_seen_through(spots, 12.0, np.zeros(2))


def test_a_world_with_z_down_is_no_different() -> None:
    turned = [
        Frame(
            frame.vehicle_id,
            frame.image,
            frame.bands,
            Pose(FLIPPED @ pose.position_enu_m, FLIPPED @ pose.R_cam2enu),
            CAMERA,
        )
        for frame, pose in zip(flight(GROUND_M, 0.6), POSES, strict=True)
    ]
    (spots,) = find_spots(turned, BOUNDS_M, np.arange(-20.0, 5.1, 0.5))
    assert spots.up == -1.0
    layer = ground_layer(spots, np.zeros(2))
    assert layer is not None
    assert layer.height_m == pytest.approx(0.0, abs=0.3)
