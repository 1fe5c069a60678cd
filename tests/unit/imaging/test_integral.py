import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.imaging.focal_plane import choose_grid, grid_to_plane
from aos_gcs.imaging.integral import BATCH_FRAMES, integrate
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.views import grid_view, perspective_view

CAMERA = CameraModel.from_fov(48, 40, np.radians(50.0))


def texture(x_m: NDArray[np.float64], y_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return 100 + 40 * np.sin(0.4 * x_m) + 30 * np.cos(0.3 * y_m + 0.2 * x_m)


def render(pose: Pose, camera: CameraModel, plane_height_m: float) -> NDArray[np.float32]:
    """What a camera sees of the textured plane."""
    u, v = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    points = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, plane_height_m)
    return texture(points[:, 0], points[:, 1]).reshape(u.shape).astype(np.float32)


def frame_of(image: NDArray[np.generic], pose: Pose, camera: CameraModel = CAMERA, vehicle_id: int = 1) -> Frame:
    bands = ("red", "green", "blue", "thermal")[-image.shape[2] :] if image.ndim == 3 else ("thermal",)
    return Frame(vehicle_id, image if image.ndim == 3 else image[:, :, np.newaxis], bands, pose, camera)


def tilted_pose(rng: np.random.Generator, spread_m: float = 6.0) -> Pose:
    nadir = nadir_pose([*rng.uniform(-spread_m, spread_m, 2), rng.uniform(30, 36)], rng.uniform(-3, 3))
    tilt = Rotation.from_euler("xyz", rng.uniform(-0.15, 0.15, 3)).as_matrix()
    return Pose(nadir.position_enu_m, nadir.R_cam2enu @ tilt)


def test_the_texture_of_the_plane_is_recovered_through_occluders() -> None:
    rng = np.random.default_rng(0)
    frames = []
    for _ in range(40):
        pose = tilted_pose(rng)
        image = render(pose, CAMERA, 2.0)
        # Leaves near the camera hide 30 % of each frame, at other places in every frame.
        image[rng.random(image.shape) < 0.3] = 0.0
        frames.append(frame_of(image, pose))
    grid = choose_grid(frames, 2.0)
    mean, coverage = integrate(frames, grid_view(grid), exact=False)
    columns, rows = np.meshgrid(np.arange(grid.columns), np.arange(grid.rows))
    x_m, y_m, _ = grid_to_plane(grid) @ np.stack((columns.ravel(), rows.ravel(), np.ones(columns.size)))
    expected = 0.7 * texture(x_m, y_m).reshape(coverage.shape)
    well_covered = coverage >= 30
    assert well_covered.sum() > 300
    error = mean[:, :, 0][well_covered] - expected[well_covered]
    assert abs(error.mean()) < 1.0
    assert error.std() < 8.0
    single = integrate(frames[:1], grid_view(grid), exact=False)[0][:, :, 0]
    assert np.nanstd((single - expected)[well_covered]) > 30.0


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_virtual_view_of_unoccluded_frames_is_what_a_camera_there_sees(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frames = [frame_of(render(pose, CAMERA, -1.0), pose) for pose in (tilted_pose(rng) for _ in range(4))]
    virtual_pose = tilted_pose(rng)
    integral, count = integrate(frames, perspective_view(CAMERA, virtual_pose, -1.0))
    np.testing.assert_array_equal(np.isnan(integral[:, :, 0]), count == 0)
    error = np.abs(integral[:, :, 0] - render(virtual_pose, CAMERA, -1.0))
    assert np.nanmean(error) < 0.5
    assert np.nanmax(error) < 10.0


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), order=st.permutations(range(5)))
def test_the_order_of_frames_does_not_matter(seed: int, order: list[int]) -> None:
    rng = np.random.default_rng(seed)
    frames = [frame_of(rng.uniform(0, 255, (40, 48, 2)).astype(np.float32), tilted_pose(rng)) for _ in range(5)]
    shuffled = [frames[i] for i in order]
    grid = choose_grid(frames, 0.0)
    for one, other in (
        (integrate(frames, grid_view(grid), exact=False), integrate(shuffled, grid_view(grid), exact=False)),
        (
            integrate(frames, perspective_view(CAMERA, frames[0].pose, 0.0)),
            integrate(shuffled, perspective_view(CAMERA, frames[0].pose, 0.0)),
        ),
    ):
        np.testing.assert_allclose(one[0], other[0], rtol=1e-5)
        np.testing.assert_array_equal(one[1], other[1])


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1), value=st.integers(1, 255), dtype=st.sampled_from([np.uint8, np.uint16, np.float32])
)
def test_constant_frames_integrate_to_the_constant(seed: int, value: int, dtype: type[np.generic]) -> None:
    rng = np.random.default_rng(seed)
    frames = [frame_of(np.full((40, 48, 4), value, dtype=dtype), tilted_pose(rng)) for _ in range(3)]
    grid = choose_grid(frames, 0.0)
    for mean, coverage in (
        integrate(frames, grid_view(grid), exact=False),
        integrate(frames, perspective_view(CAMERA, tilted_pose(rng), 0.0)),
    ):
        assert mean.dtype == np.float32
        assert (coverage > 0).any()
        np.testing.assert_allclose(mean[coverage > 0], value, rtol=1e-5)
        assert np.isnan(mean[coverage == 0]).all()


def test_a_frame_seen_from_its_own_pose_is_itself() -> None:
    pose = tilted_pose(np.random.default_rng(1))
    image = np.random.default_rng(2).integers(0, 65_535, (40, 48, 3), dtype=np.uint16)
    integral, count = integrate([frame_of(image, pose)], perspective_view(CAMERA, pose, 3.0))
    assert (count[1:-1, 1:-1] == 1).all()
    np.testing.assert_allclose(integral[1:-1, 1:-1], image[1:-1, 1:-1], atol=0.01)


def test_more_channels_than_opencv_has_scalars_for() -> None:
    rng = np.random.default_rng(3)
    image = rng.uniform(0, 1, (40, 48, 6)).astype(np.float32)
    frame = Frame(1, image, tuple("abcdef"), nadir_pose([0, 0, 30]), CAMERA)
    grid = choose_grid([frame], 0.0)
    mean, coverage = integrate([frame, frame], grid_view(grid), exact=False)
    assert coverage.max() == 2
    alone = Frame(1, image[:, :, 5:], ("f",), frame.pose, CAMERA)
    np.testing.assert_allclose(mean[:, :, 5:], integrate([alone], grid_view(grid), exact=False)[0], atol=1e-5)


def test_pixels_that_are_not_finite_do_not_cover() -> None:
    image = np.ones((40, 48, 2), dtype=np.float32)
    image[20, 24, 0] = np.nan
    frames = [frame_of(image, nadir_pose([0, 0, 30])), frame_of(np.ones_like(image), nadir_pose([0.3, 0, 30]))]
    for mean, coverage in (
        integrate(frames, grid_view(choose_grid(frames, 0.0)), exact=False),
        integrate(frames, perspective_view(CAMERA, frames[0].pose, 0.0)),
    ):
        assert set(np.unique(coverage)) >= {1, 2}
        np.testing.assert_allclose(mean[coverage > 0], 1.0)
        assert 0 < (coverage[10:30, 10:40] == 1).sum() <= 9


def test_frames_are_taken_a_few_at_a_time() -> None:
    alive = 0
    most = 0

    class Counted(np.ndarray):
        def __del__(self) -> None:
            nonlocal alive
            alive -= self.base is None

    def stream() -> list[Frame]:
        nonlocal alive, most
        for x in range(40):
            image = Counted((40, 48, 1), dtype=np.uint8)
            image[:] = 7
            alive += 1
            most = max(most, alive)
            yield Frame(1, image, ("grey",), nadir_pose([0.1 * x, 0, 30]), CAMERA)

    integral, count = integrate(stream(), perspective_view(CAMERA, nadir_pose([0, 0, 30]), 0.0))
    assert count.max() == 40
    assert np.nanmax(integral) == pytest.approx(7.0)
    assert most <= BATCH_FRAMES + 2


def test_a_plane_behind_the_virtual_camera_is_refused() -> None:
    frame = frame_of(np.zeros((40, 48, 1), dtype=np.uint8), nadir_pose([0, 0, 30]))
    with pytest.raises(ImagingError, match=r"z = 31 m lies behind the virtual camera at z = 30\.0 m"):
        integrate([frame], perspective_view(CAMERA, frame.pose, 31.0))
    with pytest.raises(ImagingError, match="passes through the virtual camera"):
        integrate([frame], perspective_view(CAMERA, frame.pose, 30.0))


def test_frames_behind_whose_camera_the_plane_lies_do_not_contribute() -> None:
    down = frame_of(np.full((40, 48, 1), 5, dtype=np.uint8), nadir_pose([0, 0, 30]))
    below_the_plane = frame_of(np.full((40, 48, 1), 99, dtype=np.uint8), nadir_pose([0, 0, -30]))
    integral, count = integrate([down, below_the_plane], perspective_view(CAMERA, down.pose, 0.0))
    assert count.max() == 1
    assert np.nanmax(integral) == 5.0


def test_nothing_is_focused_above_the_horizon() -> None:
    level = Pose(np.array([0.0, 0.0, 30.0]), np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    frame = frame_of(np.full((40, 48, 1), 9, dtype=np.uint8), level)
    integral, count = integrate([frame], perspective_view(CAMERA, level, 0.0))
    assert (count[20:, 1:-1] == 1).sum() > 500
    assert not count[:20].any()
    assert np.isnan(integral[:20]).all()


def test_frames_that_do_not_fit_are_refused() -> None:
    grey = frame_of(np.zeros((40, 48, 1), dtype=np.uint8), nadir_pose([0, 0, 30]))
    colour = frame_of(np.zeros((40, 48, 3), dtype=np.uint8), nadir_pose([0, 0, 30]), vehicle_id=7)
    cut = Frame(8, np.zeros((39, 48, 1), dtype=np.uint8), grey.bands, grey.pose, CAMERA)
    grid = choose_grid([grey], 0.0)
    with pytest.raises(ImagingError, match="vehicle 7 has the bands"):
        integrate([grey, colour], grid_view(grid), exact=False)
    with pytest.raises(ImagingError, match=r"vehicle 8 has shape \(39, 48, 1\)"):
        integrate([grey, cut], perspective_view(CAMERA, grey.pose, 0.0))
    with pytest.raises(ImagingError, match="no frame"):
        integrate([], grid_view(grid), exact=False)
    with pytest.raises(ImagingError, match="no frame"):
        integrate([], perspective_view(CAMERA, grey.pose, 0.0))


def test_grid_and_view_agree() -> None:
    rng = np.random.default_rng(4)
    frames = [
        frame_of(cv2.GaussianBlur(rng.uniform(0, 255, (40, 48)), (0, 0), 3).astype(np.float32), tilted_pose(rng))
        for _ in range(3)
    ]
    grid = choose_grid(frames, 0.0)
    # A nadir camera whose pixels are the grid's cells.
    height_m = 40.0
    focal_px = height_m / grid.resolution_m
    camera = CameraModel(grid.columns, grid.rows, focal_px, focal_px, (grid.columns - 1) / 2, (grid.rows - 1) / 2)
    centre = [grid.west_m + grid.columns * grid.resolution_m / 2, grid.north_m - grid.rows * grid.resolution_m / 2]
    on_grid, coverage = integrate(frames, grid_view(grid), exact=False)
    in_view, count = integrate(frames, perspective_view(camera, nadir_pose([*centre, height_m]), 0.0))
    assert (coverage != count).mean() < 0.002
    same = (coverage == count) & (count > 0)
    # Coordinates in steps of 1/32 pixel: far less than the texture's deviation of 7.
    np.testing.assert_allclose(on_grid[same], in_view[same], atol=0.2)
